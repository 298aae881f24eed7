/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/chiller.h"

#include <math.h>

#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

enum { steps_of_lag = 8, most_steps = 4096 };

tt_chiller tt_chiller_in(tt_arena* arena, const tt_model* m) {
  tt_chiller c;
  const ptrdiff_t n = m->coolants;
  c.outlet = tt_doubles(arena, n);
  c.inlet = tt_doubles(arena, n);
  c.integral = tt_doubles(arena, n);
  c.running = tt_ints(arena, n);
  return c;
}

static double set_point(const tt_model* m, int i, const double* readings_K, const double* guide_K) {
  double guide = m->coolant_guide[i] < 0 ? guide_K[i] : readings_K[m->coolant_guide[i]];
  if (m->coolant_warmed_by[i] >= 0) guide += m->coolant_warmed_share[i] * (readings_K[m->coolant_warmed_by[i]] - guide);
  return guide + m->coolant_offset[i];
}

void tt_chiller_start(const tt_model* m, const double* readings_K, const double* guide_K, tt_chiller* c) {
  for (int i = 0; i < m->coolants; ++i) c->outlet[i] = c->inlet[i] = set_point(m, i, readings_K, guide_K);
}

/* Two-point control of the outlet: exponentials from one end of the band to the other. */
static double mean_over_step(const tt_model* m, int i, double set, double step_s, tt_chiller* c) {
  const double tau = m->coolant_time_constant[i];
  double left = step_s, sum = 0.0, outlet = c->outlet[i];
  while (left > 0.0) {
    const double target = set + (c->running[i] ? -m->coolant_pull_down[i] : m->coolant_drift_up[i]);
    const double edge = set + (c->running[i] ? -0.5 : 0.5) * m->coolant_band[i];
    const double ratio = (edge - target) / (outlet - target);
    const double to_edge = ratio < 1.0 && ratio > 0.0 ? -tau * tt_log(ratio) : 0.0;
    const double span = tt_min(left, to_edge), decay = tt_exp(-span / tau);
    sum += target * span + (outlet - target) * tau * (1.0 - decay);
    outlet = target + (outlet - target) * decay;
    left -= span;
    if (to_edge <= span && left > 0.0) c->running[i] ^= 1;
  }
  c->outlet[i] = outlet;
  return sum / step_s;
}

typedef struct walk {
  double outlet, integral;
  int running;
} walk;

/* What stands over a step. */
typedef struct aims {
  double set, returned, most; /* most: cooling that the power allows at the flow, K */
} aims;

/* dT/dt of the outlet, and of the integral. */
static double slope(const tt_model* m, int i, const aims* a, const walk* w, double* integral) {
  double target = a->returned + (w->running ? -m->coolant_pull_down[i] : m->coolant_drift_up[i]);
  *integral = 0.0;
  if (m->coolant_control[i] == TT_PI_CONTROL) {
    const double off = (m->coolant_controls_return[i] ? a->returned : w->outlet) - a->set;
    const double wanted = m->coolant_gain[i] * off + w->integral;
    *integral = m->coolant_gain[i] / m->coolant_integral_time[i] * off;
    if ((wanted > a->most && *integral > 0.0) || (wanted < 0.0 && *integral < 0.0)) *integral = 0.0;
    target = a->returned - tt_clamp(wanted, 0.0, a->most);
  }
  return (target - w->outlet) / m->coolant_time_constant[i];
}

/* Heun's method in parts of the lag; compressors switch at the end of a part. Returns the mean outlet. */
static double walked(const tt_model* m, int i, const aims* a, double span, walk* w) {
  const int pi = m->coolant_control[i] == TT_PI_CONTROL;
  const double tau = m->coolant_time_constant[i];
  const double quickest = pi ? tt_min(tau / (1.0 + m->coolant_gain[i]), m->coolant_integral_time[i]) : tau;
  const int steps = (int)tt_clamp(ceil(steps_of_lag * span / quickest), 16.0, most_steps);
  const double h = span / steps;
  double sum = 0.0;
  for (int k = 0; k < steps; ++k) {
    double integral_0, integral_1;
    const double slope_0 = slope(m, i, a, w, &integral_0), before = w->outlet;
    walk guess = *w;
    guess.outlet += h * slope_0;
    guess.integral += h * integral_0;
    const double slope_1 = slope(m, i, a, &guess, &integral_1);
    w->outlet += 0.5 * h * (slope_0 + slope_1);
    w->integral += 0.5 * h * (integral_0 + integral_1);
    sum += 0.5 * h * (before + w->outlet);
    if (m->coolant_control[i] != TT_TWO_POINT) continue;
    const double off = (m->coolant_controls_return[i] ? a->returned : w->outlet) - a->set;
    if ((w->running ? -off : off) >= 0.5 * m->coolant_band[i]) w->running ^= 1;
  }
  return sum / span;
}

static double inlet_of(const tt_model* m, int i, const double* row, const double* readings_K, double set, double step_s,
                       tt_chiller* c) {
  const double measured = row[m->coolant_inlet[i]], on = row[m->coolant_on[i]];
  if (tt_is_finite(measured)) return c->outlet[i] = measured + m->coolant_inlet_offset[i] - m->reference_C;
  if (!(on > 0.0)) return c->outlet[i]; /* it keeps its temperature */
  if (m->coolant_controls_return[i] || m->coolant_control[i] == TT_PI_CONTROL) {
    walk w = {c->outlet[i], c->integral[i], c->running[i]};
    const aims a = {set, readings_K[m->coolant_returns[i]],
                    m->coolant_power[i] / (m->coolant_heat_flow[i] * tt_max(1e-6, on))};
    const double mean = walked(m, i, &a, step_s, &w);
    c->outlet[i] = w.outlet;
    c->integral[i] = w.integral;
    c->running[i] = w.running;
    return mean;
  }
  if (m->coolant_control[i] == TT_TWO_POINT) return mean_over_step(m, i, set, step_s, c);
  return c->outlet[i] = set + (c->outlet[i] - set) * tt_exp(-step_s / m->coolant_time_constant[i]);
}

void tt_chiller_advance(const tt_model* m, const double* row, const double* readings_K, const double* guide_K,
                        double step_s, tt_chiller* c) {
  for (int i = 0; i < m->coolants; ++i) {
    const double set = set_point(m, i, readings_K, guide_K);
    c->inlet[i] = inlet_of(m, i, row, readings_K, set, step_s, c);
  }
}
