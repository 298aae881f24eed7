/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/twin_jobs.h"

#include "compensation/control/linear.h"
#include "compensation/control/operating.h"
#include "compensation/control/outputs.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

/* Phases of jobs but the step. The last two are those of corrections and of the start. */
enum {
  phase_heats,
  phase_operator, /* of a day's work */
  phase_modes,
  phase_first,
  phase_take,
  phase_operator_ahead,
  phase_ahead,
  phase_operator_correction,
  phase_correction,
  phase_outputs,
  phase_deviation
};

enum { slices_at_once = 64 }; /* where a job is done at once */

static void coefficients_of_day(const void* with, const double* row, double* p, double* q) {
  const tt_twin* t = with;
  tt_coefficients(t->model, row, t->guide, NULL, p, q, t->occupancy);
}

void tt_lay_jobs(tt_twin* t, tt_arena* state, tt_arena* work) {
  const tt_model* m = t->model;
  t->start_row = tt_doubles(state, m->channels);
  t->first_p = tt_doubles(state, m->terms);
  t->job_p = tt_doubles(state, m->terms);
  t->heat = tt_doubles(work, m->order);
  t->mean_q = tt_doubles(work, m->inputs);
  t->mean_state = tt_doubles(work, m->order);
  if (!m->observer) return;
  tt_observer_data_of(m, &t->data);
  t->data.day.coefficients = coefficients_of_day;
  t->data.day.with = t;
  tt_observer_lay(&t->observer, &t->data.observer, state);
  tt_day_lay(&t->day, &t->data.day, state);
  tt_deviation_lay(&t->deviation, m, &t->data.sensors, state, work);
}

void tt_reset_jobs(tt_twin* t) {
  if (!t->model->observer) return;
  tt_observer_reset(&t->observer);
  tt_deviation_prepare(&t->deviation, t->model);
}

tt_moment tt_moment_of(const tt_twin* t) {
  const tt_numbers* n = t->now;
  const tt_moment moment = {n->time,  n->step_end, n->started_at, n->last_step,     n->interval_s,
                            t->state, t->change,   t->sensors,    t->sensors_change};
  return moment;
}

void tt_read_predicted(tt_twin* t) {
  const tt_model* m = t->model;
  tt_zero(m->readings, t->sensors);
  tt_gemv_t(m->order, m->readings, 1.0, m->sensor_rows, t->state, t->sensors);
}

double tt_share_ahead(const tt_twin* t) {
  const tt_numbers* now = t->now;
  if (!(now->last_step > 0.0)) return 0.0;
  const double more = now->job == TT_JOB_STEP ? tt_min(0.5, (now->time - now->job_began) / now->last_step) : 0.0;
  return tt_min(1.0 + more, (now->time - now->step_end) / now->last_step);
}

/* Readings that chillers and laws use: measured ones where they are trusted, else predicted ones. */
static void guide_readings(tt_twin* t) {
  const tt_model* m = t->model;
  if (m->observer) {
    const tt_moment now = tt_moment_of(t);
    tt_copy(m->readings, tt_observer_guide(&t->observer, &now), t->readings);
    return;
  }
  for (int s = 0; s < m->readings; ++s) t->readings[s] = t->sensors[s] + m->sensor_offset[s];
}

void tt_start_clock(tt_twin* t, const double* row) {
  const tt_model* m = t->model;
  guide_readings(t);
  tt_guide_K(m, row, t->guide);
  tt_chiller_start(m, t->readings, t->guide, &t->chiller);
  tt_coefficients(m, row, t->chiller.outlet, t->readings, t->p, t->q, t->occupancy);
}

static void begin(tt_twin* t, int job, int phase) {
  t->now->job = job;
  t->now->phase = phase;
  t->now->slices_done = 0;
}

/* A step. */

/* Corrections that come by and by have come on by a step at its end. */
static void show_more(tt_twin* t, double step_s) {
  if (!t->model->observer) return;
  const tt_moment now = tt_moment_of(t);
  tt_observer_show(&t->observer, step_s);
  tt_observer_set_corrected(&t->observer, &now);
}

void tt_begin_step(tt_twin* t, double step_s, double end) {
  const tt_model* m = t->model;
  show_more(t, step_s);
  guide_readings(t);
  tt_guide_K(m, t->mean_row, t->guide);
  tt_chiller_advance(m, t->mean_row, t->readings, t->guide, step_s, &t->chiller);
  tt_coefficients(m, t->mean_row, t->chiller.inlet, t->readings, t->p, t->q, t->occupancy);
  begin(t, TT_JOB_STEP, 0);
  t->now->job_step = step_s;
  t->now->job_end = end;
}

static tt_step step_of(const tt_twin* t) {
  const tt_numbers* now = t->now;
  tt_step step = {now->job_step, t->p, t->q, t->state, NULL, NULL, 0.0};
  if (t->model->observer) {
    step.correction = t->observer.correction;
    step.rate = t->observer.correction_rate;
    step.since = now->job_end - tt_observer_corrected_at(&t->observer);
  }
  return step;
}

static int same(int n, const double* a, const double* b) {
  for (int i = 0; i < n; ++i) {
    if (a[i] != b[i]) return 0;
  }
  return 1;
}

static void add_to_interval(tt_twin* t, double h) {
  const tt_model* m = t->model;
  if (t->now->interval_s == 0.0) {
    tt_copy(m->terms, t->p, t->first_p);
    t->now->p_changed = 0;
  }
  t->now->p_changed = t->now->p_changed || !same(m->terms, t->p, t->first_p);
  t->now->interval_s += h;
  tt_axpy(m->terms, h, t->p, t->interval_p);
  tt_axpy(m->inputs, h, t->q, t->interval_q);
  tt_axpy(m->order, 0.5 * h, t->before, t->interval_state);
  tt_axpy(m->order, 0.5 * h, t->state, t->interval_state);
}

static void take_effect(tt_twin* t) {
  const tt_model* m = t->model;
  const tt_work* w = &t->work;
  tt_copy(m->order, t->state, t->before);
  tt_copy(m->order, w->stage, t->state);
  tt_copy(m->order, w->difference, t->change);
  for (int s = 0; s < m->readings; ++s) t->sensors_change[s] = w->next_sensors[s] - t->sensors[s];
  tt_copy(m->readings, w->next_sensors, t->sensors);
  tt_copy(tt_output_count(m), w->next_base, t->base);
  tt_copy(tt_output_count(m), w->next_slope, t->slope);
  t->now->last_step = t->now->job_step;
  if (!m->observer) return;
  add_to_interval(t, t->now->job_step);
  const tt_moment now = tt_moment_of(t);
  tt_observer_set_corrected(&t->observer, &now);
}

static void step_slice(tt_twin* t) {
  tt_numbers* now = t->now;
  const tt_step step = step_of(t);
  const int bad = tt_slice(t->model, &t->work, &step, now->slices_done);
  if (bad) t->work.factor_step = 0.0;
  if (!bad && ++now->slices_done < tt_slices(&t->work)) return;
  now->job = TT_JOB_NONE;
  now->failed = bad;
  now->step_end = now->job_end;
  if (!bad) take_effect(t);
}

/* Corrections and the start. */

int tt_correction_due(const tt_twin* t) {
  if (!t->model->observer || t->now->job != TT_JOB_NONE) return 0;
  const tt_moment now = tt_moment_of(t);
  return tt_observer_due(&t->observer, &now);
}

void tt_begin_correction(tt_twin* t) {
  const tt_model* m = t->model;
  tt_numbers* now = t->now;
  const tt_moment moment = tt_moment_of(t);
  const tt_interval interval = {now->interval_s, t->job_p, t->mean_q, t->mean_state, NULL};
  /* Equal coefficients stay equal to the last bit, so that their factor is found again. */
  for (int j = 0; j < m->terms; ++j) t->job_p[j] = now->p_changed ? t->interval_p[j] / now->interval_s : t->p[j];
  for (int k = 0; k < m->inputs; ++k) t->mean_q[k] = t->interval_q[k] / now->interval_s;
  for (int i = 0; i < m->order; ++i) t->mean_state[i] = t->interval_state[i] / now->interval_s;
  tt_observer_begin_correction(&t->observer, &moment, &interval);
  now->interval_s = 0.0;
  tt_zero(m->terms, t->interval_p);
  tt_zero(m->inputs, t->interval_q);
  tt_zero(m->order, t->interval_state);
  begin(t, TT_JOB_CORRECTION, phase_operator_correction);
}

void tt_begin_showing(tt_twin* t) { begin(t, TT_JOB_CORRECTION, phase_outputs); }

/* The coefficients of one of the operating points of a day's work; coolant inlets are at the reference. */
static void begin_operator(tt_twin* t, int kind) {
  tt_zero(t->model->coolants, t->guide);
  tt_day_coefficients(&t->day, kind, t->job_p);
  t->now->modes = kind;
  t->now->phase = phase_operator;
  t->now->slices_done = 0;
}

void tt_begin_start(tt_twin* t) {
  tt_copy(t->model->channels, t->row, t->start_row);
  tt_day_set(&t->day, t->start_row);
  t->now->job_began = t->now->time;
  begin(t, TT_JOB_START, phase_heats);
}

/* Slices of a phase that has a fixed number of them, else 0. */
static int slices_of(const tt_twin* t, int phase) {
  switch (phase) {
    case phase_heats: return t->data.observer.heats;
    case phase_operator:
    case phase_operator_ahead:
    case phase_operator_correction: return tt_operator_slices(&t->work);
    case phase_correction: return tt_observer_correction_slices(&t->data.observer) + 1;
    case phase_deviation: return tt_deviation_slices(t->model, &t->data.sensors);
    case phase_outputs: return tt_project_slices(&t->work);
    default: return 0;
  }
}

/* At most so many slices of the present phase, from the values that its first one found. slices: then as many as were
 * done. Returns whether a phase without a fixed number of them has ended. */
static int work_of(tt_twin* t, int* slices) {
  const ptrdiff_t order = t->model->order;
  const int item = t->now->slices_done, most = *slices;
  *slices = 1;
  switch (t->now->phase) {
    case phase_heats:
      tt_zero(t->model->coolants, t->guide);
      tt_day_heat(&t->day, item, t->observer.past.heats + item * order);
      return 0;
    case phase_operator:
    case phase_operator_ahead:
    case phase_operator_correction: tt_operator_slice(t->model, &t->work, t->job_p, item); return 0;
    case phase_modes: *slices = most; return tt_past_work(&t->observer.past, slices);
    case phase_first: return tt_observer_start_slice(&t->observer);
    case phase_take: return tt_observer_take_slice(&t->observer);
    case phase_ahead: *slices = most; return tt_sensitivities_work(&t->observer.errors.sensitivities, slices);
    case phase_correction:
      *slices = most;
      tt_observer_correction_work(&t->observer, slices);
      return 0;
    case phase_deviation:
      *slices = tt_deviation_work(&t->deviation, t->model, &t->observer.errors, t->work.next_base, item, most);
      return 0;
    case phase_outputs:
      tt_project_slice(t->model, &t->work, t->observer.corrected, t->observer.correction_rate, item);
      return 0;
    default: return 1;
  }
}

/* The initial state is known. */
static void set_start(tt_twin* t) {
  const tt_model* m = t->model;
  double uniform_K = 0.0;
  if (tt_observer_uniform(&t->observer, &uniform_K)) {
    for (int i = 0; i < m->order; ++i) t->state[i] = m->one_kelvin[i] * uniform_K;
    tt_copy(m->order, t->state, t->before);
    tt_read_predicted(t);
  }
  t->now->step_end = t->now->started_at = t->now->time;
  tt_start_clock(t, t->start_row);
  const tt_moment now = tt_moment_of(t);
  tt_observer_begin_taking(&t->observer, &now);
  tt_copy(m->terms, t->p, t->job_p);
}

static void end_job(tt_twin* t) {
  tt_deviation_finish(&t->deviation, t->model);
  tt_copy(tt_output_count(t->model), t->work.next_base, t->base);
  if (t->now->job == TT_JOB_START) t->now->step_end = t->now->started_at = t->now->time;
  t->now->job = TT_JOB_NONE;
}

/* After the last slice of a phase: the next one. */
static void end_phase(tt_twin* t) {
  tt_observer* o = &t->observer;
  tt_numbers* now = t->now;
  const tt_moment moment = tt_moment_of(t);
  const int phase = now->phase++;
  now->slices_done = 0;
  switch (phase) {
    case phase_heats: begin_operator(t, TT_MODES_COOLING); break;
    case phase_operator: tt_past_begin_modes(&o->past, now->modes, t->work.operator_matrix); break;
    case phase_modes:
      if (now->modes < TT_MODES_SWEPT)
        begin_operator(t, now->modes + 1);
      else
        tt_observer_begin_start(o, &moment, t->start_row);
      break;
    case phase_first: set_start(t); break;
    case phase_operator_ahead: tt_observer_begin_foresight(o, t->work.operator_matrix); break;
    case phase_ahead:
      tt_observer_finish_foresight(o, &moment);
      now->phase = phase_outputs;
      break;
    case phase_operator_correction:
      tt_sensitivities_set_operator(&o->errors.sensitivities, t->work.operator_matrix);
      break;
    case phase_correction: tt_observer_finish_correction(o, &moment); break;
    case phase_deviation: end_job(t); break;
    default: break;
  }
}

/* Returns how many of the slices it did. */
static int phase_work(tt_twin* t, int slices) {
  const int fixed = slices_of(t, t->now->phase), left = fixed > 0 ? fixed - t->now->slices_done : slices;
  int done = slices < left ? slices : left;
  const int ended = work_of(t, &done);
  t->now->slices_done += done;
  if (fixed > 0 ? t->now->slices_done >= fixed : ended) end_phase(t);
  return done;
}

int tt_job_slices(const tt_twin* t) {
  const int ends = t->now->job == TT_JOB_STEP ? 0 : slices_of(t, phase_deviation) + slices_of(t, phase_outputs);
  switch (t->now->job) {
    case TT_JOB_STEP: return tt_slices(&t->work);
    case TT_JOB_CORRECTION: return slices_of(t, phase_operator) + slices_of(t, phase_correction) + ends;
    case TT_JOB_START:
      return slices_of(t, phase_heats) + 4 * slices_of(t, phase_operator) + tt_past_slices(&t->observer.past_model) +
             t->data.sensors.measured + 1 + tt_sensitivities_slices(&t->data.sensors) + ends;
    default: return 0;
  }
}

void tt_work_on(tt_twin* t, int slices) {
  while (slices > 0 && t->now->job != TT_JOB_NONE) {
    if (t->now->job == TT_JOB_STEP) {
      step_slice(t);
      --slices;
    } else {
      slices -= phase_work(t, slices);
    }
  }
}

void tt_finish_job(tt_twin* t) {
  while (t->now->job != TT_JOB_NONE) tt_work_on(t, slices_at_once);
}

/* The first slices of the present phase. */
static void redo(tt_twin* t, int slices) {
  t->now->slices_done = 0;
  while (t->now->slices_done < slices) {
    int done = slices - t->now->slices_done;
    work_of(t, &done);
    t->now->slices_done += done;
  }
}

void tt_redo_job(tt_twin* t) {
  tt_numbers* now = t->now;
  const int done = now->slices_done;
  t->work.factor_step = 0.0;
  if (now->job == TT_JOB_NONE) return;
  if (now->job == TT_JOB_STEP) {
    const tt_step step = step_of(t);
    for (int i = 0; i < done; ++i) tt_slice(t->model, &t->work, &step, i);
    return;
  }
  /* Other phases have all that they need in the state. */
  if (now->phase == phase_modes || now->phase == phase_first || now->phase == phase_take || now->phase == phase_ahead ||
      now->phase == phase_correction || now->phase == phase_heats)
    return;
  if (now->phase == phase_deviation) {
    /* It reads the outputs of the phase before. */
    const int outputs = slices_of(t, phase_outputs);
    now->phase = phase_outputs;
    redo(t, outputs);
    now->phase = phase_deviation;
  }
  redo(t, done);
}
