/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/pause.h"

#include "compensation/control/observer.h"
#include "compensation/control/scalars.h"
#include "compensation/control/twin_jobs.h"

static const double pause_step_s = 60.0, first_s = 1e-3;

void tt_twin_pass_pause(tt_twin* t, double until) {
  const tt_model* m = t->model;
  double *off = t->off_row, time = t->now->time;
  for (int k = 0; k < m->channels; ++k)
    off[k] = m->channel_state[k] ? 0.0 : m->channel_temperature[k] ? tt_nan() : m->channel_default[k];
  for (int a = 0; a < m->axes; ++a) off[m->axis_position[a]] = tt_nan();
  tt_twin_row(t, time + first_s, off, NULL); /* what held before ends here */
  for (time += pause_step_s; time < until - first_s; time += pause_step_s) tt_twin_row(t, time, off, NULL);
}

int tt_twin_contradicts_pause(tt_twin* t, const double* sensors_C) {
  if (!t->model->observer || !sensors_C) return 0;
  tt_finish_job(t);
  tt_observer_read(&t->observer, sensors_C, t->row);
  const tt_moment now = tt_moment_of(t);
  return tt_observer_is_contradicted(&t->observer, &now);
}
