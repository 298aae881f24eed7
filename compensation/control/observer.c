/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/observer.h"

#include <math.h>
#include <stddef.h>

#include "compensation/control/linear.h"
#include "compensation/control/observer_start.h"
#include "compensation/control/scalars.h"

static const double most_surprise = 4.0;    /* standard deviations */
static const double rate_error_share = 0.2; /* of how fast what the start left fades at a sensor */

void tt_observer_lay(tt_observer* o, const tt_observer_model* model, tt_arena* arena) {
  const tt_sensor_model* m = model->sensors;
  const ptrdiff_t n = m->order, sensors = m->sensors, measured = m->measured, drives = m->drives;
  o->model = model;
  o->past_model.sensors = m;
  o->past_model.heats = model->heats;
  tt_past_lay(&o->past, &o->past_model, arena);
  tt_trust_lay(&o->trust, model->readings, m->sensor_std, arena);
  tt_errors_lay(&o->errors, m, arena);
  double** const of_measured[] = {&o->reading_C,   &o->reading_K,        &o->innovation_sum,
                                  &o->moment_sum,  &o->innovation_count, &o->value,
                                  &o->mean_moment, &o->deviation,        &o->first_value};
  double** const of_sensors[] = {&o->guide_K, &o->seen_one,  &o->seen_start,  &o->shift,
                                 &o->bias,    &o->bias_rate, &o->unsure_rate, &o->own_offset};
  double** const of_states[] = {&o->correction, &o->correction_rate, &o->corrected};
  for (size_t i = 0; i < sizeof of_measured / sizeof *of_measured; ++i) *of_measured[i] = tt_doubles(arena, measured);
  for (size_t i = 0; i < sizeof of_sensors / sizeof *of_sensors; ++i) *of_sensors[i] = tt_doubles(arena, sensors);
  for (size_t i = 0; i < sizeof of_states / sizeof *of_states; ++i) *of_states[i] = tt_doubles(arena, n);
  o->has_value = tt_ints(arena, measured);
  o->explained = tt_ints(arena, measured);
  o->first_sensor = tt_ints(arena, measured);
  o->energy = tt_doubles(arena, n * drives);
  o->way = tt_doubles(arena, drives);
  o->unrecorded = tt_ints(arena, drives);
  o->scratch = tt_doubles(arena, 2 * sensors);
  o->gap = tt_doubles(arena, model->ambients);
  o->row = tt_doubles(arena, model->readings->channels);
  o->numbers = tt_doubles(arena, tt_observer_numbers);
  o->flags = tt_ints(arena, tt_observer_flags);
}

void tt_observer_reset(tt_observer* o) {
  const tt_sensor_model* m = o->model->sensors;
  tt_trust_start(&o->trust);
  for (int s = 0; s < m->measured; ++s) o->reading_C[s] = o->reading_K[s] = tt_nan();
  double* const of_measured[] = {o->innovation_sum, o->moment_sum, o->innovation_count};
  double* const of_sensors[] = {o->shift, o->bias, o->bias_rate, o->unsure_rate, o->seen_one, o->own_offset};
  double* const of_states[] = {o->correction, o->correction_rate, o->corrected};
  for (size_t i = 0; i < sizeof of_measured / sizeof *of_measured; ++i) tt_zero(m->measured, of_measured[i]);
  for (size_t i = 0; i < sizeof of_sensors / sizeof *of_sensors; ++i) tt_zero(m->sensors, of_sensors[i]);
  for (size_t i = 0; i < sizeof of_states / sizeof *of_states; ++i) tt_zero(m->order, of_states[i]);
  for (int d = 0; d < m->drives; ++d) o->unrecorded[d] = 0;
  o->numbers[drives_s] = 0.0;
  tt_gemv_t(m->order, m->sensors, 1.0, m->sensor_rows, m->one_kelvin, o->seen_one);
  for (int i = 0; i < tt_observer_flags; ++i) o->flags[i] = 0;
}

void tt_observer_read(tt_observer* o, const double* sensors_C, const double* row) {
  for (int s = 0; s < o->model->sensors->measured; ++s) o->reading_C[s] = sensors_C ? sensors_C[s] : tt_nan();
  tt_take_out_sensors(&o->trust.check, o->reading_C, row);
  for (int s = 0; s < o->model->sensors->measured; ++s)
    o->reading_K[s] = o->reading_C[s] - o->model->readings->reference_C;
}

int tt_observer_any_reading(const tt_observer* o) {
  for (int s = 0; s < o->model->sensors->measured; ++s) {
    if (tt_is_finite(o->reading_K[s])) return 1;
  }
  return 0;
}

/* Whether theta and S are between two corrections. */
static int busy(const tt_observer* o) { return o->flags[at_correction] >= correction_observe; }

const double* tt_observer_guide(tt_observer* o, const tt_moment* now) {
  const tt_sensor_model* m = o->model->sensors;
  if (busy(o))
    tt_copy(m->sensors, o->bias, o->guide_K);
  else
    tt_errors_sensor_correction(&o->errors, o->guide_K);
  for (int s = 0; s < m->sensors; ++s) o->guide_K[s] = now->seen[s] + o->guide_K[s] + o->model->sensor_offset[s];
  for (int s = 0; s < m->measured; ++s) {
    if (!tt_is_finite(o->reading_K[s]) || !tt_trusted(&o->trust, s)) continue;
    o->guide_K[s] = o->reading_K[s];
    if (tt_errors_doubts(&o->errors, s)) o->guide_K[s] -= o->own_offset[s];
  }
  return o->guide_K;
}

/* Steps since the end of the last one, with which the state is extrapolated. */
static double ahead_of(const tt_moment* now) {
  return now->last_step > 0.0 ? (now->time - now->step_end) / now->last_step : 0.0;
}

void tt_observer_watch(tt_observer* o, double time, const double* expected_K, int inputs_leapt) {
  for (int s = 0; s < o->model->sensors->measured; ++s) o->scratch[s] = o->reading_K[s] - o->model->sensor_offset[s];
  tt_trust_watch(&o->trust, time, o->scratch, expected_K, inputs_leapt, o->unsure_rate);
}

void tt_observer_add_readings(tt_observer* o, const tt_moment* now, int inputs_leapt) {
  const int measured = o->model->sensors->measured;
  const double ahead = ahead_of(now), since = now->time - o->numbers[corrected_at],
               moment = now->interval_s + (now->time - now->step_end);
  double* expected = o->scratch + o->model->sensors->sensors;
  for (int s = 0; s < measured; ++s)
    expected[s] = now->seen[s] + ahead * now->seen_change[s] + o->bias[s] + since * o->bias_rate[s];
  tt_observer_watch(o, now->time, expected, inputs_leapt);
  for (int s = 0; s < measured; ++s) {
    if (!tt_trusted(&o->trust, s)) continue;
    o->innovation_sum[s] += o->reading_K[s] - o->model->sensor_offset[s] - now->seen[s] - ahead * now->seen_change[s];
    o->moment_sum[s] += moment;
    o->innovation_count[s] += 1.0;
  }
}

int tt_observer_is_contradicted(tt_observer* o, const tt_moment* now) {
  const double ahead = ahead_of(now);
  int present = 0, off = 0;
  for (int s = 0; s < o->model->sensors->measured; ++s) {
    if (!tt_is_finite(o->reading_K[s])) continue; /* trust counts little: in a pause all sensors become absent */
    const double seen = now->seen[s] + ahead * now->seen_change[s];
    const tt_innovation one = {s, o->reading_K[s] - o->model->sensor_offset[s] - seen, 1.0,
                               seen + o->bias[s] - o->seen_start[s]};
    ++present;
    if (tt_errors_surprise(&o->errors, &one) > most_surprise) ++off;
  }
  return off >= (present > 2 ? 2 : 1);
}

void tt_observer_add_row(tt_observer* o, double duration) {
  const tt_sensor_model* m = o->model->sensors;
  if (o->flags[drives_taken]) {
    for (int d = 0; d < m->drives; ++d) o->unrecorded[d] = 0;
    o->numbers[drives_s] = 0.0;
    o->flags[drives_taken] = 0;
  }
  o->numbers[drives_s] += duration;
}

void tt_observer_add_drive(tt_observer* o, int drive, double duration, const double* heat, double speed) {
  const ptrdiff_t n = o->model->sensors->order;
  double* energy = o->energy + drive * n;
  if (!o->unrecorded[drive]) {
    tt_zero(n, energy);
    o->way[drive] = 0.0;
    o->unrecorded[drive] = 1;
  }
  tt_axpy(n, duration, heat, energy);
  o->way[drive] += duration * speed;
}

int tt_observer_due(const tt_observer* o, const tt_moment* now) {
  /* What work before has left changes fast at first: then the observer corrects at each end of a step. */
  const double after =
      tt_min(o->model->correction_s, tt_max(o->model->step_s, 0.25 * (now->step_end - now->started_at)));
  return o->flags[at_correction] == correction_none && now->interval_s >= after;
}

static void set_untold(tt_observer* o) {
  const tt_sensor_model* m = o->model->sensors;
  const ptrdiff_t n = m->order;
  for (int d = 0; d < m->drives; ++d) {
    double* energy = o->energy + d * n;
    if (o->unrecorded[d]) {
      /* Set to a mean in place: the next row begins anew. */
      for (int i = 0; i < n; ++i) energy[i] /= o->numbers[drives_s];
      tt_errors_set_untold(&o->errors, d, energy, o->way[d] / o->numbers[drives_s]);
    } else {
      tt_errors_set_untold(&o->errors, d, NULL, 0.0);
    }
  }
  o->flags[drives_taken] = 1;
}

void tt_observer_begin_correction(tt_observer* o, const tt_moment* now, const tt_interval* interval) {
  const int measured = o->model->sensors->measured;
  for (int s = 0; s < measured; ++s) {
    const double count = o->innovation_count[s];
    o->has_value[s] = count > 0.0;
    if (!o->has_value[s]) continue;
    o->value[s] = o->innovation_sum[s] / count;
    o->mean_moment[s] = tt_clamp(o->moment_sum[s] / count / now->interval_s, 0.0, 1.0);
    o->deviation[s] = now->seen[s] + o->bias[s] - o->seen_start[s];
  }
  tt_zero(measured, o->innovation_sum);
  tt_zero(measured, o->moment_sum);
  tt_zero(measured, o->innovation_count);
  set_untold(o);
  o->numbers[interval_end] = now->step_end;
  o->numbers[interval_s] = interval->duration;
  tt_errors_begin_advance(&o->errors, interval);
  o->flags[at_correction] = correction_advance;
  o->flags[at_item] = 0;
}

int tt_observer_correction_slices(const tt_observer_model* model) {
  return tt_sensitivities_slices(model->sensors) + model->sensors->measured + 2;
}

static void observe(tt_observer* o, int s) {
  const tt_innovation one = {s, o->value[s], o->mean_moment[s], o->deviation[s]};
  tt_errors_observe(&o->errors, &one, o->numbers[interval_s]);
  o->flags[has_observed] = 1;
}

int tt_observer_correction_work(tt_observer* o, int* slices) {
  int32_t *stage = &o->flags[at_correction], *item = &o->flags[at_item];
  if (*stage == correction_advance) {
    const int state = tt_sensitivities_work(&o->errors.sensitivities, slices);
    if (state == 2) *stage = correction_failed;
    if (state == 1) *stage = correction_take;
    return state == 2 ? 2 : 0;
  }
  *slices = 1;
  switch (*stage) {
    case correction_take:
      tt_errors_finish_advance(&o->errors);
      tt_errors_sensor_correction(&o->errors, o->shift);
      o->flags[has_observed] = 0;
      *stage = correction_observe;
      break;
    case correction_observe:
      while (*item < o->model->sensors->measured && !o->has_value[*item]) ++*item;
      if (*item < o->model->sensors->measured) {
        observe(o, (*item)++);
      } else {
        if (o->flags[has_observed]) tt_errors_settle(&o->errors);
        *stage = correction_done;
      }
      break;
    default: break;
  }
  return *stage == correction_done ? 1 : *stage == correction_failed ? 2 : 0;
}

int tt_observer_correction_slice(tt_observer* o) {
  int one = 1;
  return tt_observer_correction_work(o, &one);
}

/* Something was learnt: readings and the state are corrected by it from this time on. */
void tt_observer_settle(tt_observer* o, const tt_moment* now, double time) {
  const tt_sensor_model* m = o->model->sensors;
  const double before = now->step_end - o->numbers[corrected_at], after = now->step_end - time;
  double* change = o->scratch;
  for (int s = 0; s < m->sensors; ++s) change[s] = -(o->bias[s] + before * o->bias_rate[s]);
  tt_errors_sensor_correction(&o->errors, o->bias);
  tt_errors_sensor_correction_rate(&o->errors, o->bias_rate);
  tt_errors_sensor_rate_std(&o->errors, o->unsure_rate);
  for (int s = 0; s < m->sensors; ++s) o->own_offset[s] = tt_errors_own_offset(&o->errors, s).value;
  for (int s = 0; s < m->sensors; ++s) {
    o->unsure_rate[s] += rate_error_share * fabs(o->bias_rate[s]);
    change[s] += o->bias[s] + after * o->bias_rate[s];
  }
  tt_errors_correction_rate(&o->errors, o->correction_rate);
  o->numbers[corrected_at] = time;
  tt_monitor_correct(&o->trust.monitor, change);
  tt_observer_set_corrected(o, now);
}

void tt_observer_finish_correction(tt_observer* o, const tt_moment* now) {
  const int stage = o->flags[at_correction];
  if (stage != correction_done && stage != correction_failed) return;
  o->flags[at_correction] = correction_none;
  if (stage == correction_failed) return;
  if (o->flags[has_observed]) tt_trust_watch_drift(&o->trust, now->time, &o->errors);
  tt_observer_settle(o, now, o->numbers[interval_end]);
}

void tt_observer_learn(tt_observer* o, const tt_moment* now, const double* tool, const double* table,
                       const double* state, const double* error, double std_m) {
  tt_errors_learn(&o->errors, tool, table, state, error, std_m);
  tt_observer_settle(o, now, now->step_end);
}

void tt_observer_show(tt_observer* o, double duration) { tt_errors_show(&o->errors, duration); }

void tt_observer_set_corrected(tt_observer* o, const tt_moment* now) {
  const double since = now->step_end - o->numbers[corrected_at];
  if (!busy(o)) tt_errors_correction(&o->errors, o->correction);
  for (int i = 0; i < o->model->sensors->order; ++i)
    o->corrected[i] = now->state[i] + o->correction[i] + since * o->correction_rate[i];
}

double tt_observer_corrected_at(const tt_observer* o) { return o->numbers[corrected_at]; }

void tt_observer_predicted_C(const tt_observer* o, const tt_moment* now, double* readings_C) {
  const double ahead = tt_min(1.0, ahead_of(now));
  for (int s = 0; s < o->model->sensors->measured; ++s)
    readings_C[s] = now->seen[s] + ahead * now->seen_change[s] + o->shift[s] + o->model->sensor_offset[s] +
                    o->model->readings->reference_C;
}
