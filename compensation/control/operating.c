/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/operating.h"

#include <math.h>

#include "compensation/control/laws.h"
#include "compensation/control/occupancy.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

/* Below it the direction of free convection is undecided: the laws keep their value there. */
static const double least_delta_K = 0.05;
static const double zero_C_in_K = 273.15;

void tt_update_row(const tt_model* m, const double* given, double* row) {
  for (int k = 0; k < m->channels; ++k) {
    if (!tt_is_nan(given[k])) row[k] = given[k];
  }
  for (int a = 0; a < m->axes; ++a) {
    const int low = m->axis_low[a], high = m->axis_high[a];
    const double slack = 1e-6 * (fabs(row[low]) + fabs(row[high]) + 1.0), position = given[m->axis_position[a]];
    const int ended = row[m->axis_feed[a]] == 0.0 || position < row[low] - slack || position > row[high] + slack;
    if (ended && tt_is_nan(given[low])) row[low] = tt_nan();
    if (ended && tt_is_nan(given[high])) row[high] = tt_nan();
  }
}

double tt_ambient_K(const tt_model* m, int ambient, const double* row) {
  double offset = 0.0;
  int i = ambient;
  /* The offset of one that follows ends where its own channel is measured. */
  while (m->ambient_follows[i] >= 0) {
    const double own = row[m->ambient_channel[i]];
    if (tt_is_finite(own)) return own - m->reference_C + offset;
    offset += m->ambient_offset[i];
    i = m->ambient_follows[i];
  }
  const double measured = row[m->ambient_channel[i]];
  return (tt_is_finite(measured) ? measured : m->ambient_default_C[i]) + m->ambient_offset[i] - m->reference_C + offset;
}

static double gradient_K_m(const tt_model* m, int ambient, const double* row) {
  if (m->ambient_gradient_channel[ambient] < 0) return 0.0;
  const double measured = row[m->ambient_gradient_channel[ambient]];
  return tt_is_finite(measured) ? measured : m->ambient_gradient[ambient];
}

void tt_guide_K(const tt_model* m, const double* row, double* guide_K) {
  for (int i = 0; i < m->coolants; ++i) {
    const int ambient = m->coolant_guide_ambient[i];
    guide_K[i] = ambient >= 0 ? tt_ambient_K(m, ambient, row) : 0.0;
  }
}

typedef struct film {
  double convection, radiation, ambient_K, surroundings_K;
} film;

static double own_convection(const tt_model* m, int i, double own, double ambient) {
  const double delta = own - ambient;
  int orientation = m->film_orientation[i];
  /* Cold air sinks: under a plate that is colder than the air it behaves as over a warm one. */
  if (delta < 0.0 && orientation != TT_VERTICAL) orientation = orientation == TT_UP ? TT_DOWN : TT_UP;
  return tt_free_convection(orientation, m->film_length[i], tt_max(fabs(delta), least_delta_K),
                            ambient + m->reference_C + zero_C_in_K);
}

/* What a table takes of its channel: the numbers of mesh::TableInput. */
static double at_input(int input, double value) {
  if (input == TT_AS_IT_IS) return value;
  return input == TT_HOUR_OF_DAY ? value - 24.0 * floor(value / 24.0) : fabs(value);
}

static double table_convection(const tt_model* m, int i, double value) {
  if (!tt_is_finite(value)) return 0.0; /* input not supplied: the law contributes zero */
  const int curve = m->film_table[i];
  const double at = tt_curve(m, curve, at_input(m->film_table_input[i], value));
  if (m->film_speed_factor[i] == 1.0) return at;
  const double lowest = m->curve_value[m->curve_first[curve]];
  return tt_max(0.0, lowest + m->film_speed_factor[i] * (at - lowest));
}

static film film_at(const tt_model* m, int i, const double* row, const double* readings_K) {
  const double reference_K = m->reference_C + zero_C_in_K;
  const int ambient = m->film_ambient[i], surroundings = m->film_surroundings[i], own = m->film_own[i];
  film f = {m->film_still[i], m->film_radiation[i], 0.0, 0.0};
  if (ambient >= 0) f.ambient_K = tt_ambient_K(m, ambient, row);
  if (surroundings >= 0) f.surroundings_K = surroundings == ambient ? f.ambient_K : tt_ambient_K(m, surroundings, row);
  if (own >= 0 && readings_K) {
    if (m->film_of_temperature[i]) {
      const int volume = m->film_volume[i];
      f.convection = own_convection(m, i, readings_K[own], volume >= 0 ? readings_K[volume] : f.ambient_K);
    }
    if (m->film_exact[i]) {
      f.radiation =
          tt_radiation_between(m->film_emissivity[i], readings_K[own] + reference_K, f.surroundings_K + reference_K);
    }
  }
  if (m->film_table[i] >= 0) f.convection = table_convection(m, i, row[m->film_table_channel[i]]);
  if (m->film_speed_channel[i] >= 0) {
    const double speed = row[m->film_speed_channel[i]] * m->film_to_rad_s[i], still = f.convection;
    const double forced = m->film_speed_factor[i] * m->film_fraction[i] * tt_rotating_disc(speed, m->film_radius[i]);
    f.convection = tt_cbrt(still * still * still + forced * forced * forced);
  }
  double factor = m->film_factor[i];
  if (m->film_state[i] >= 0) factor *= row[m->film_state[i]];
  f.convection *= factor;
  f.radiation *= factor;
  return f;
}

double tt_source_power(const tt_model* m, int i, const double* row) {
  const double drive = m->source_drive[i] >= 0 ? row[m->source_drive[i]] : tt_nan();
  double standstill = m->source_standstill[i], power = 0.0;
  if (standstill != 0.0) standstill *= row[m->machine_on];
  if (tt_is_finite(drive)) return m->source_scale[i] * m->source_loss_share[i] * drive + standstill;
  for (int k = m->source_law_first[i]; k < m->source_law_first[i + 1]; ++k) {
    const double value = row[m->law_channel[k]], half = m->law_half_speed[k];
    if (!tt_is_finite(value)) continue; /* input not supplied: the law contributes zero */
    const double factor = half > 0.0 ? tt_by_speed(fabs(value) / half, m->source_exponent[i]) : 1.0;
    power += factor * tt_curve(m, m->law_curve[k], at_input(m->law_input[k], value));
  }
  for (int k = m->source_loss_first[i]; k < m->source_loss_first[i + 1]; ++k) {
    power += tt_by_speed(2.0 * tt_loss_relative_speed(m, k, row), m->source_exponent[i]) * tt_loss_power(m, k, row);
  }
  return m->source_scale[i] * power + standstill;
}

void tt_pose(const tt_model* m, const double* row, double* pose) {
  for (int a = 0; a < m->axes; ++a) pose[a] = row[m->axis_position[a]] * m->axis_unit[a];
}

static double conductance(const tt_model* m, int joint, const double* row, const double* readings_K) {
  double factor = m->joint_factor[joint];
  if (m->joint_clamp[joint] >= 0) factor += row[m->joint_clamp[joint]] * (m->joint_clamped_factor[joint] - factor);
  if (m->joint_reading[joint] >= 0) {
    const double at_K = readings_K ? readings_K[m->joint_reading[joint]] : 0.0;
    factor *= tt_curve(m, m->joint_curve[joint], m->reference_C + at_K);
  }
  return m->joint_conductance[joint] * factor;
}

static void occupancies(const tt_model* m, const double* row, double* occupancy) {
  for (int t = 0; t < m->terms; ++t) occupancy[t] = 1.0;
  for (int j = 0; j < m->joints; ++j) {
    const int a = m->joint_grid_axis[j], first = m->joint_first_term[j];
    if (a < 0 || first < 0) continue;
    double low = row[m->axis_low[a]], high = row[m->axis_high[a]];
    if (!tt_is_finite(low) || !tt_is_finite(high)) low = high = row[m->axis_position[a]];
    tt_grid_occupancy(m, j, low * m->axis_unit[a], high * m->axis_unit[a], occupancy + first);
  }
}

static void set_film(const tt_model* m, int t, const double* row, const double* readings_K, double* p, double* q) {
  const int i = m->term_item[t], ambient = m->film_ambient[i];
  const film f = film_at(m, i, row, readings_K);
  p[t] = f.convection + f.radiation;
  if (ambient < 0) return;
  const int k = m->film_first_input[i];
  q[k] = f.convection * f.ambient_K + f.radiation * f.surroundings_K + m->film_load[i];
  if (m->ambient_gradient_channel[ambient] >= 0) q[k + 1] = f.convection * gradient_K_m(m, ambient, row);
}

static void set_terms(const tt_model* m, const double* row, const double* readings_K, const double* occupancy,
                      double* p, double* q) {
  for (int t = 0; t < m->terms; ++t) {
    const int channel = m->term_channel[t];
    switch (m->term_kind[t]) {
      case TT_TERM_FILM: set_film(m, t, row, readings_K, p, q); break;
      case TT_TERM_CONTACT: p[t] = conductance(m, m->term_item[t], row, readings_K) * occupancy[t]; break;
      case TT_TERM_GIVEN: p[t] = tt_is_finite(row[channel]) ? m->term_value[t] : 0.0; break;
      default: p[t] = m->term_value[t] * (channel >= 0 ? row[channel] : 1.0); break;
    }
  }
}

void tt_coefficients(const tt_model* m, const double* row, const double* inlet_K, const double* readings_K, double* p,
                     double* q, double* occupancy) {
  occupancies(m, row, occupancy);
  set_terms(m, row, readings_K, occupancy, p, q);
  for (int k = 0; k < m->inputs; ++k) {
    const int t = m->input_term[k], item = m->input_item[k], at = m->input_occupancy[k];
    switch (m->input_kind[k]) {
      case TT_INPUT_VOLUME:
      case TT_INPUT_CONTACT: q[k] = p[t] * tt_ambient_K(m, m->input_ambient[k], row); break;
      case TT_INPUT_GIVEN: q[k] = p[t] > 0.0 ? p[t] * (row[m->input_channel[k]] - m->reference_C) : 0.0; break;
      case TT_INPUT_INLET: q[k] = p[t] * inlet_K[item]; break;
      case TT_INPUT_SOURCE:
        q[k] = tt_source_power(m, item, row) * (at >= 0 ? m->input_share[k] * occupancy[at] : m->input_share[k]);
        break;
      default: break; /* films: with their terms */
    }
  }
}
