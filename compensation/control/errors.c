/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/errors.h"

#include <math.h>
#include <stddef.h>

#include "compensation/control/linear.h"
#include "compensation/control/scalars.h"

#define HOUR 3600.0

static const double untold_air_K = 2.0; /* standard deviation of the air where nobody tells it */
static const double machine_memory = 200.0 * HOUR;
static const double untold_memory = 2.0 * HOUR; /* of how fast a drive runs that nobody tells */
static const double correlation_s = 1800.0;     /* of what the model gets wrong at a sensor */
static const double outlier = 4.0;              /* standard deviations */
static const double no_sensor_K = 1e-6;         /* what is observed beside the sensors has no offset */
static const double expansion_share = 0.03, rest_m = 0.8e-6;
static const double expansion_memory = 2000.0 * HOUR, rest_memory = 12.0 * HOUR;
static const double showing_s = 300.0; /* time constant with which new findings come into effect */
static const double model_error_share = 0.03, model_error_K = 0.01, noise_share = 0.3;

enum { learns, air_is_untold, shapes_count, flag_count };

int tt_errors_first_bias(const tt_sensor_model* model) { return tt_columns(model); }
int tt_errors_first_output(const tt_sensor_model* model) { return tt_columns(model) + model->sensors; }
int tt_errors_count(const tt_sensor_model* model) { return tt_errors_first_output(model) + tt_outputs; }

static const tt_sensor_model* model_of(const tt_errors* e) { return e->sensitivities.model; }

/* An entry of the covariance, or a column of it. */
static double* sigma_at(const tt_errors* e, ptrdiff_t row, ptrdiff_t column) {
  return e->sigma + row + column * tt_errors_count(model_of(e));
}

void tt_errors_lay(tt_errors* e, const tt_sensor_model* model, tt_arena* arena) {
  const ptrdiff_t all = tt_errors_count(model);
  tt_sensitivities_lay(&e->sensitivities, model, arena);
  e->theta = tt_doubles(arena, all);
  e->prior = tt_doubles(arena, all);
  e->mean = tt_doubles(arena, all);
  e->memory = tt_doubles(arena, all);
  e->withheld = tt_doubles(arena, all);
  e->shown = tt_doubles(arena, all);
  e->row = tt_doubles(arena, all);
  e->gain = tt_doubles(arena, all);
  e->sigma = tt_doubles(arena, all * all);
  e->least = tt_doubles(arena, model->drives);
  e->scratch = tt_doubles(arena, model->order);
  e->flags = tt_ints(arena, flag_count);
}

void tt_errors_air_is_untold(tt_errors* e) { e->flags[air_is_untold] = 1; }

static void set_machine_priors(tt_errors* e, const double* ambient_gap_K) {
  const tt_sensor_model* m = model_of(e);
  for (int k = 0; k < m->quantities; ++k) {
    e->prior[k] = k == m->air && e->flags[air_is_untold] ? untold_air_K : m->quantity_std[k];
    e->memory[k] = m->quantity_memory[k];
    const int ambient = m->quantity_ambient[k];
    if (ambient < 0) continue;
    /* It may be at either temperature. */
    e->mean[k] = 0.5 * ambient_gap_K[ambient];
    e->prior[k] = sqrt(e->prior[k] * e->prior[k] + e->mean[k] * e->mean[k]);
  }
  for (int d = 0; d < m->drives; ++d) {
    if (!e->sensitivities.drive_known[d]) continue;
    e->prior[m->quantities + d] = 1.0;
    e->memory[m->quantities + d] = e->sensitivities.unrecorded[d] ? untold_memory : machine_memory;
  }
}

void tt_errors_start(tt_errors* e, double uniform_K, int shapes, const double* patterns, const double* ambient_gap_K) {
  const tt_sensor_model* m = model_of(e);
  const ptrdiff_t all = tt_errors_count(m), start = tt_first_start(m), bias = tt_errors_first_bias(m),
                  output = tt_errors_first_output(m);
  tt_sensitivities_start(&e->sensitivities, shapes, patterns);
  tt_zero(all, e->prior);
  tt_zero(all, e->mean);
  tt_zero(all, e->memory);
  tt_zero(all, e->withheld);
  tt_zero(all * all, e->sigma);
  set_machine_priors(e, ambient_gap_K);
  e->prior[start] = uniform_K;
  for (int k = 1; k <= shapes; ++k) e->prior[start + k] = 1.0;
  for (int s = 0; s < m->sensors; ++s) {
    e->prior[bias + s] = s < m->measured ? m->sensor_std[s] : no_sensor_K;
    e->memory[bias + s] = machine_memory;
  }
  /* Unknown to sensors: they come to life with the first probing. */
  for (int i = 0; i < tt_outputs; ++i) e->memory[output + i] = i < tt_outputs - 3 ? expansion_memory : rest_memory;
  e->flags[learns] = 0;
  e->flags[shapes_count] = shapes;
  tt_copy(all, e->mean, e->theta);
  for (int k = 0; k < all; ++k) *sigma_at(e, k, k) = e->prior[k] * e->prior[k];
}

void tt_errors_doubt(tt_errors* e, int sensor, double std_K) {
  const int k = tt_errors_first_bias(model_of(e)) + sensor;
  if (!(std_K > e->prior[k])) return;
  e->prior[k] = std_K;
  e->memory[k] = 0.0;
  *sigma_at(e, k, k) = std_K * std_K;
}

int tt_errors_doubts(const tt_errors* e, int sensor) {
  return e->memory[tt_errors_first_bias(model_of(e)) + sensor] == 0.0;
}

void tt_errors_set_untold(tt_errors* e, int drive, const double* heat, double nominal) {
  const tt_sensor_model* m = model_of(e);
  const int k = m->quantities + drive, was_known = e->sensitivities.drive_known[drive];
  if (heat == NULL && !e->sensitivities.unrecorded[drive]) return;
  tt_sensitivities_set_heat(&e->sensitivities, drive, heat);
  if (!was_known) {
    /* Nothing of the state has come from it so far. */
    e->prior[k] = 1.0;
    *sigma_at(e, k, k) = 1.0;
  }
  e->least[drive] = -nominal;
  /* What has come from it stays known while the drive is recorded again. */
  e->memory[k] = heat ? untold_memory : machine_memory;
}

void tt_errors_begin_advance(tt_errors* e, const tt_interval* interval) {
  tt_sensitivities_begin(&e->sensitivities, interval, e->theta);
}

static void fade(tt_errors* e, double duration) {
  const int all = tt_errors_count(model_of(e));
  double* keep = e->gain;
  for (int k = 0; k < all; ++k) {
    keep[k] = e->memory[k] > 0.0 ? tt_exp(-duration / e->memory[k]) : 1.0;
    e->theta[k] = e->mean[k] + keep[k] * (e->theta[k] - e->mean[k]);
  }
  /* Column by column, as the covariance is stored; factors in the order of their quantities keep it symmetric. */
  for (int c = 0; c < all; ++c) {
    double* column = sigma_at(e, 0, c);
    for (int r = 0; r < c; ++r) column[r] = column[r] * keep[r] * keep[c];
    for (int r = c; r < all; ++r) column[r] = column[r] * keep[c] * keep[r];
    column[c] += (1.0 - keep[c] * keep[c]) * e->prior[c] * e->prior[c];
  }
}

void tt_errors_finish_advance(tt_errors* e) {
  const double duration = tt_sensitivities_duration(&e->sensitivities);
  tt_sensitivities_finish(&e->sensitivities);
  fade(e, duration);
}

double tt_reading_std(double uncertainty_K, double deviation_K) {
  const double noise = noise_share * uncertainty_K, error = model_error_K + model_error_share * fabs(deviation_K);
  return sqrt(noise * noise + error * error);
}

/* One scalar observation e->row * theta. residual: observed - predicted. */
static void observe(tt_errors* e, double residual, double variance) {
  const tt_sensor_model* m = model_of(e);
  const int all = tt_errors_count(m);
  double* gain = e->gain;
  tt_zero(all, gain);
  tt_gemv(all, all, 1.0, e->sigma, e->row, gain);
  variance += tt_dot(all, e->row, gain);
  const double far = residual * residual / (outlier * outlier * variance);
  if (far > 1.0) variance *= far;
  const double root = sqrt(variance);
  for (int k = 0; k < all; ++k) gain[k] /= root;
  for (int k = 0; k < all; ++k) tt_axpy(all, -gain[k], gain, sigma_at(e, 0, k));
  /* A heat that may change at any time follows the readings, but keeps its deviation: its past says little of it. */
  for (int i = 0; i < m->drives; ++i) {
    for (int j = 0; j < m->drives; ++j) {
      const int r = m->quantities + i, c = m->quantities + j;
      if (e->sensitivities.unrecorded[i] && e->sensitivities.unrecorded[j]) *sigma_at(e, r, c) += gain[r] * gain[c];
    }
  }
  tt_axpy(all, residual / root, gain, e->theta);
}

/* What the reading of a sensor changes by for each quantity, as e->row. */
static void set_row(tt_errors* e, const tt_innovation* innovation) {
  const tt_sensor_model* m = model_of(e);
  const ptrdiff_t columns = tt_columns(m), sensor = innovation->sensor;
  const double *seen = e->sensitivities.seen + sensor * columns, *last = e->sensitivities.seen_last + sensor * columns;
  tt_zero(tt_errors_count(m), e->row);
  for (int k = 0; k < columns; ++k) e->row[k] = (1.0 - innovation->moment) * last[k] + innovation->moment * seen[k];
  e->row[columns + sensor] = 1.0;
}

void tt_errors_observe(tt_errors* e, const tt_innovation* innovation, double independent_s) {
  const int all = tt_errors_count(model_of(e));
  const double inflation = independent_s > 0.0 ? tt_max(1.0, correlation_s / independent_s) : 1.0;
  const double std = tt_reading_std(model_of(e)->sensor_std[innovation->sensor], innovation->deviation);
  set_row(e, innovation);
  observe(e, innovation->value - tt_dot(all, e->row, e->theta), std * std * inflation);
}

double tt_errors_surprise(tt_errors* e, const tt_innovation* innovation) {
  const int all = tt_errors_count(model_of(e));
  const double std = tt_reading_std(model_of(e)->sensor_std[innovation->sensor], innovation->deviation);
  set_row(e, innovation);
  tt_zero(all, e->gain);
  tt_gemv(all, all, 1.0, e->sigma, e->row, e->gain);
  return fabs(innovation->value - tt_dot(all, e->row, e->theta)) /
         sqrt(std * std + tt_max(0.0, tt_dot(all, e->row, e->gain)));
}

/* Some columns at a time, so that a row of theirs is next to each other in memory. */
static void make_symmetric(ptrdiff_t n, double* a) {
  for (ptrdiff_t first = 0; first < n; first += 8) {
    const ptrdiff_t last = first + 8 < n ? first + 8 : n;
    for (ptrdiff_t i = 0; i < last; ++i) {
      for (ptrdiff_t j = i < first ? first : i + 1; j < last; ++j) {
        double *upper = a + i + j * n, *lower = a + j + i * n;
        *upper = *lower = 0.5 * (*upper + *lower);
      }
    }
  }
}

void tt_errors_settle(tt_errors* e) {
  const tt_sensor_model* m = model_of(e);
  const int all = tt_errors_count(m), output = tt_errors_first_output(m);
  make_symmetric(all, e->sigma);
  /* Beyond three standard deviations the first-order picture ends; a share of -1 would be no machine. */
  for (int k = 0; k < m->quantities + m->drives; ++k) {
    const double least = k < m->quantities ? -3.0 : e->least[k - m->quantities];
    e->theta[k] = tt_clamp(e->theta[k], e->mean[k] + least * e->prior[k], e->mean[k] + 3.0 * e->prior[k]);
  }
  for (int k = output; e->flags[learns] && k < all; ++k)
    e->theta[k] = tt_clamp(e->theta[k], -5.0 * e->prior[k], 5.0 * e->prior[k]);
}

static void come_to_life(tt_errors* e) {
  const tt_sensor_model* m = model_of(e);
  const int all = tt_errors_count(m), output = tt_errors_first_output(m);
  for (int k = output; k < all; ++k) {
    e->prior[k] = k < all - 3 ? expansion_share : rest_m;
    *sigma_at(e, k, k) = e->prior[k] * e->prior[k];
  }
  e->flags[learns] = 1;
}

void tt_errors_learn(tt_errors* e, const double* tool, const double* table, const double* nominal, const double* error,
                     double std_m) {
  const tt_sensor_model* m = model_of(e);
  const ptrdiff_t n = m->order, columns = tt_columns(m), all = tt_errors_count(m), output = tt_errors_first_output(m);
  if (!e->flags[learns]) come_to_life(e);
  for (int k = 0; k < all; ++k) e->withheld[k] -= e->theta[k];
  for (int i = 0; i < 3; ++i) {
    if (!tt_is_finite(error[i])) continue;
    const double *tool_row = tool + i * n, *table_row = table + i * n;
    /* Linearised at what is known by now: products of shares and state are part of the prediction. */
    tt_copy(n, nominal, e->scratch);
    tt_gemv(n, columns, 1.0, e->sensitivities.directions, e->theta, e->scratch);
    const double of_tool = tt_dot(n, tool_row, e->scratch), of_table = tt_dot(n, table_row, e->scratch);
    const double more_tool = 1.0 + e->theta[output + i], more_table = 1.0 + e->theta[output + 3 + i];
    for (int k = 0; k < n; ++k) e->scratch[k] = more_tool * tool_row[k] + more_table * table_row[k];
    tt_zero(all, e->row);
    tt_gemv_t(n, columns, 1.0, e->sensitivities.directions, e->scratch, e->row);
    e->row[output + i] = of_tool;
    e->row[output + 3 + i] = of_table;
    e->row[output + 6 + i] = 1.0;
    observe(e, error[i] - more_tool * of_tool - more_table * of_table - e->theta[output + 6 + i], std_m * std_m);
  }
  tt_errors_settle(e);
  for (int k = 0; k < all; ++k) e->withheld[k] += e->theta[k];
}

void tt_errors_show(tt_errors* e, double duration) {
  tt_scale(tt_errors_count(model_of(e)), tt_exp(-duration / showing_s), e->withheld);
}

static const double* shown(tt_errors* e) {
  const int all = tt_errors_count(model_of(e));
  for (int k = 0; k < all; ++k) e->shown[k] = e->theta[k] - e->withheld[k];
  return e->shown;
}

void tt_errors_correction(tt_errors* e, double* correction) {
  const tt_sensor_model* m = model_of(e);
  tt_zero(m->order, correction);
  tt_gemv(m->order, tt_columns(m), 1.0, e->sensitivities.directions, shown(e), correction);
}

void tt_errors_correction_rate(tt_errors* e, double* rate) {
  const tt_sensor_model* m = model_of(e);
  tt_zero(m->order, rate);
  tt_gemv(m->order, tt_start_modes, 1.0, e->sensitivities.start_rate, shown(e) + tt_first_start(m), rate);
}

void tt_errors_sensor_correction(tt_errors* e, double* correction) {
  const tt_sensor_model* m = model_of(e);
  const ptrdiff_t columns = tt_columns(m);
  const double* now = shown(e);
  for (int s = 0; s < m->sensors; ++s)
    correction[s] = tt_dot(columns, e->sensitivities.seen + s * columns, now) + now[columns + s];
}

void tt_errors_sensor_correction_rate(const tt_errors* e, double* rate) {
  const tt_sensor_model* m = model_of(e);
  const ptrdiff_t columns = tt_columns(m), start = tt_first_start(m);
  for (int s = 0; s < m->sensors; ++s) {
    const double* seen = e->sensitivities.seen_rate + s * columns + start;
    rate[s] = tt_dot(tt_start_modes, seen, e->theta + start);
  }
}

void tt_errors_sensor_rate_std(tt_errors* e, double* std) {
  const tt_sensor_model* m = model_of(e);
  const ptrdiff_t columns = tt_columns(m), sensors = m->sensors;
  for (int s = 0; s < sensors; ++s) {
    const double* rate = e->sensitivities.seen_rate + s * columns;
    double variance = 0.0;
    for (int k = 0; k < columns; ++k) variance += rate[k] * tt_dot(columns, sigma_at(e, 0, k), rate);
    variance = tt_max(variance, 0.0);
    for (int d = 0; d < m->drives; ++d) {
      const double own = e->sensitivities.heat_seen[s + d * sensors];
      if (e->sensitivities.unrecorded[d]) variance += own * own;
    }
    std[s] = sqrt(variance);
  }
}

void tt_errors_output_shares(const tt_errors* e, double* shares) {
  const int output = tt_errors_first_output(model_of(e));
  for (int i = 0; i < tt_outputs; ++i) shares[i] = e->theta[output + i] - e->withheld[output + i];
}

int tt_errors_learns(const tt_errors* e) { return e->flags[learns]; }
int tt_errors_shapes(const tt_errors* e) { return e->flags[shapes_count]; }
int tt_errors_air_untold(const tt_errors* e) { return e->flags[air_is_untold]; }

tt_sensor_offset tt_errors_offset(const tt_errors* e, int sensor) {
  const tt_sensor_model* m = model_of(e);
  const int k = tt_errors_first_bias(m) + sensor;
  const double sigma = *sigma_at(e, k, k), rest = 1.0 - sigma / (e->prior[k] * e->prior[k]);
  const tt_sensor_offset unknown = {0.0, HUGE_VAL};
  if (!(rest > 1e-6)) return unknown;
  const tt_sensor_offset offset = {e->theta[k] / rest, sqrt(sigma / rest)};
  return offset;
}

tt_sensor_offset tt_errors_own_offset(const tt_errors* e, int sensor) {
  const int k = tt_errors_first_bias(model_of(e)) + sensor;
  const double sigma = *sigma_at(e, k, k);
  const tt_sensor_offset offset = {e->theta[k], sqrt(tt_max(0.0, sigma))};
  return offset;
}

void tt_errors_release(tt_errors* e, int sensor) {
  const tt_sensor_model* m = model_of(e);
  const int all = tt_errors_count(m), k = tt_errors_first_bias(m) + sensor;
  const double prior = e->prior[k] * e->prior[k];
  /* Never more than a thousandfold: an offset that nothing else tells stays as it is. */
  const double rest = tt_max(prior - *sigma_at(e, k, k), 1e-3 * prior), moved = e->theta[k] / rest;
  double* column = e->gain;
  tt_copy(all, sigma_at(e, 0, k), column);
  tt_axpy(all, moved, column, e->theta);
  tt_axpy(all, moved, column, e->withheld);
  for (int j = 0; j < all; ++j) tt_axpy(all, column[j] / rest, column, sigma_at(e, 0, j));
  tt_errors_settle(e);
}
