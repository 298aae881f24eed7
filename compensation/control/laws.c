/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/laws.h"

#include <math.h>

#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

static const double air_conductivity = 0.0268, air_viscosity = 16.1e-6, prandtl = 0.7, gravity = 9.81;
static const double stefan_boltzmann = 5.670374419e-8;

double tt_curve(const tt_model* m, int curve, double x) {
  if (curve < 0) return 1.0;
  const int first = m->curve_first[curve], last = m->curve_first[curve + 1] - 1;
  const double *at = m->curve_at, *value = m->curve_value;
  if (x <= at[first]) return value[first];
  if (x >= at[last]) return value[last];
  int right = first + 1;
  while (at[right] <= x) ++right;
  const double s = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return value[right - 1] + s * (value[right] - value[right - 1]);
}

static double natural_nusselt(int orientation, double rayleigh) {
  if (orientation == TT_UP) return rayleigh <= 1e7 ? 0.54 * tt_pow(rayleigh, 0.25) : 0.15 * tt_cbrt(rayleigh);
  if (orientation == TT_DOWN) return 0.27 * tt_pow(rayleigh, 0.25);
  const double denominator = tt_pow(1.0 + tt_pow(0.492 / prandtl, 9.0 / 16.0), 8.0 / 27.0);
  const double root = 0.825 + 0.387 * tt_pow(rayleigh, 1.0 / 6.0) / denominator;
  return root * root;
}

double tt_free_convection(int orientation, double length, double delta, double air_K) {
  const double grashof = gravity * length * length * length * fabs(delta) / (air_viscosity * air_viscosity * air_K);
  return natural_nusselt(orientation, grashof * prandtl) * air_conductivity / length;
}

double tt_rotating_disc(double speed, double radius) {
  static const double ends = 260e3, begins = 320e3; /* laminar up to, turbulent from */
  const double re = fabs(speed) * radius * radius / air_viscosity;
  double nusselt;
  if (!(re > 0.0)) return 0.0;
  if (re <= ends) {
    nusselt = 0.355 * sqrt(re);
  } else if (re >= begins) {
    nusselt = 0.0163 * tt_pow(re, 0.8);
  } else {
    const double share = tt_log(re / ends) / tt_log(begins / ends);
    nusselt = tt_pow(0.355 * sqrt(ends), 1.0 - share) * tt_pow(0.0163 * tt_pow(begins, 0.8), share);
  }
  return nusselt * air_conductivity / radius;
}

double tt_radiation_between(double emissivity, double temperature_K, double surroundings_K) {
  return emissivity * stefan_boltzmann * (temperature_K * temperature_K + surroundings_K * surroundings_K) *
         (temperature_K + surroundings_K);
}

double tt_by_speed(double relative, double exponent) {
  return exponent == 0.0 || !(relative > 0.0) ? 1.0 : tt_pow(tt_max(relative, 1e-3), exponent);
}

/* Integral of |sin + f| from 0 to x; alpha: arcsine of f, 0 to pi / 2. */
static double integral_of_torque(double x, double f, double alpha) {
  const double periods = floor(x / (2.0 * TT_PI)), y = x - 2.0 * TT_PI * periods, begins = TT_PI + alpha;
  const double last = 2.0 * TT_PI - alpha, cosine = tt_cos(alpha);
  double negative = periods * (2.0 * cosine - f * (last - begins)); /* of sin + f, where it is below 0 */
  if (y > begins) {
    const double to = tt_min(y, last);
    negative += tt_cos(to) + cosine - f * (to - begins);
  }
  return 1.0 - tt_cos(x) + f * x + 2.0 * negative;
}

/* W between the angles a and b, from the one at which the mass hangs, after a motion in positive direction. */
static double torque_power(const double* numbers, double a, double b) {
  const double f = numbers[3], width = b - a;
  double magnitude = fabs(tt_sin(a) + f), square = magnitude * magnitude;
  if (width > 1e-9) {
    magnitude = (integral_of_torque(b, f, numbers[4]) - integral_of_torque(a, f, numbers[4])) / width;
    square = 0.5 - tt_cos(a + b) * tt_sin(width) / (2.0 * width) + f * (f + 2.0 * (tt_cos(a) - tt_cos(b)) / width);
  }
  return numbers[1] * (numbers[2] * magnitude + (1.0 - numbers[2]) * square);
}

static double holding_power(const double* numbers, const double* row, double low, double high) {
  double a = low - numbers[0], b = high - numbers[0], positive;
  if (b < a) {
    const double kept = a;
    a = b;
    b = kept;
  }
  if (!(numbers[3] > 0.0)) return torque_power(numbers, a, b);
  positive = row[(int)numbers[5]];
  /* |sin(x) - f| is |sin(x + pi) + f| */
  return positive * torque_power(numbers, a, b) + (1.0 - positive) * torque_power(numbers, a + TT_PI, b + TT_PI);
}

static double motor_power(const tt_model* m, int loss, double turns_per_s, double on) {
  const double *numbers = m->loss_numbers + TT_LOSS_NUMBERS * loss, n = fabs(turns_per_s), relative = n / numbers[4];
  double power = numbers[2] * relative + numbers[3] * relative * relative;
  if (numbers[0] > 0.0) {
    const double current = tt_curve(m, m->loss_curve[loss], n) / numbers[0];
    power += on * numbers[1] * current * current;
  }
  return power;
}

double tt_loss_power(const tt_model* m, int loss, const double* row) {
  const double* numbers = m->loss_numbers + TT_LOSS_NUMBERS * loss;
  const double speed = row[m->loss_speed[loss]] * m->loss_to_speed[loss], size = fabs(speed);
  if (m->loss_kind[loss] == TT_HOLDING) {
    double low = row[m->loss_low[loss]], high = row[m->loss_high[loss]];
    if (!tt_is_finite(low) || !tt_is_finite(high)) low = high = row[m->loss_position[loss]];
    if (!tt_is_finite(low)) return 0.0;
    const double unit = m->loss_to_position[loss];
    return row[m->machine_on] * (1.0 - row[m->loss_clamp[loss]]) * holding_power(numbers, row, low * unit, high * unit);
  }
  if (!tt_is_finite(speed)) return 0.0; /* input not supplied: the law contributes zero */
  switch (m->loss_kind[loss]) {
    case TT_MOTOR: return motor_power(m, loss, speed, row[m->machine_on]);
    case TT_BEARING: {
      const double of_speed = tt_max(160.0, tt_pow(numbers[0] * size * 60.0, 2.0 / 3.0));
      return numbers[3] * (numbers[1] * of_speed + numbers[2]) * 1e-3 * 2.0 * TT_PI * size;
    }
    case TT_GUIDE: return (numbers[0] + numbers[1] * size) * size;
    default: return numbers[0] * size;
  }
}

double tt_loss_relative_speed(const tt_model* m, int loss, const double* row) {
  const double fastest = m->loss_fastest[loss];
  return m->loss_speed[loss] < 0 || !(fastest > 0.0) ? -1.0 : fabs(row[m->loss_speed[loss]]) / fastest;
}
