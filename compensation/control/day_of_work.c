/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/day_of_work.h"

#include "compensation/control/linear.h"
#include "compensation/control/scalars.h"

int tt_day_heats(const tt_day_model* model) { return 1 + model->drives + model->warm; }

void tt_day_lay(tt_day* day, const tt_day_model* model, tt_arena* arena) {
  const ptrdiff_t channels = model->channels;
  day->model = model;
  day->rows = tt_doubles(arena, channels * TT_DAY_ROWS);
  day->p = tt_doubles(arena, model->sensors->terms);
  day->q = tt_doubles(arena, model->sensors->inputs);
  day->row = tt_doubles(arena, channels);
}

static double* row_of(const tt_day* day, ptrdiff_t kind) { return day->rows + kind * day->model->channels; }

static void set(double* row, int channel, double value) {
  if (channel >= 0) row[channel] = value;
}

void tt_day_set(tt_day* day, const double* row) {
  const tt_day_model* m = day->model;
  double *rest = row_of(day, TT_DAY_STANDING), *swept = row_of(day, TT_DAY_SWEPT), *off = row_of(day, TT_DAY_OFF);
  tt_copy(m->channels, m->channel_default, rest);
  for (int a = 0; a < m->axes; ++a) {
    const int position = m->axis_position[a];
    if (position >= 0 && tt_is_finite(row[position])) rest[position] = row[position];
  }
  tt_copy(m->channels, rest, swept);
  tt_copy(m->channels, rest, off);
  for (int a = 0; a < m->axes; ++a) {
    set(swept, m->axis_low[a], m->travel_low[a]);
    set(swept, m->axis_high[a], m->travel_high[a]);
  }
  set(off, m->machine_on, 0.0);
  for (int c = 0; c < m->coolants; ++c) set(off, m->coolant_on[c], 0.0);
}

static void evaluate(tt_day* day, const double* row) {
  day->model->coefficients(day->model->with, row, day->p, day->q);
}

void tt_day_coefficients(tt_day* day, int kind, double* p) {
  evaluate(day, row_of(day, kind));
  tt_copy(day->model->sensors->terms, day->p, p);
}

/* watts += factor times the heat of all sources, or of all inputs, at the row */
static void add_heat(tt_day* day, double factor, int sources_only, const double* row, double* watts) {
  const tt_sensor_model* m = day->model->sensors;
  const ptrdiff_t n = m->order;
  evaluate(day, row);
  for (int k = 0; k < m->inputs; ++k) {
    if (day->q[k] == 0.0 || (sources_only && m->input_term[k] >= 0)) continue;
    tt_axpy(n, factor * day->q[k], m->input_columns + k * n, watts);
  }
}

static void drive_heat(tt_day* day, int drive, const double* row, double standing, double* watts) {
  const tt_day_model* m = day->model;
  const int channel = m->drive_channel[drive];
  if (channel < 0) return;
  tt_copy(m->channels, row, day->row);
  day->row[channel] = m->drive_half_speed[drive];
  add_heat(day, 1.0, 1, day->row, watts);
  day->row[channel] = standing;
  add_heat(day, -1.0, 1, day->row, watts);
}

static void warm_heat(tt_day* day, int warm, double* watts) {
  const tt_day_model* m = day->model;
  const tt_sensor_model* s = m->sensors;
  const ptrdiff_t n = s->order;
  const int quantity = m->warm_quantity[warm];
  tt_copy(m->channels, row_of(day, TT_DAY_STANDING), day->row);
  set(day->row, m->fluid_on, 1.0);
  evaluate(day, day->row);
  for (int i = s->quantity_warm_first[quantity]; i < s->quantity_warm_first[quantity + 1]; ++i) {
    const int input = s->quantity_warm[i];
    tt_axpy(n, m->warm_K[warm] * day->p[s->input_term[input]], s->input_columns + input * n, watts);
  }
}

void tt_day_heat(tt_day* day, int heat, double* watts) {
  const tt_day_model* m = day->model;
  const double* rest = row_of(day, TT_DAY_STANDING);
  tt_zero(m->sensors->order, watts);
  if (heat == 0) {
    /* Standing: its losses, and surroundings that are warmer than the hall. */
    add_heat(day, 1.0, 0, rest, watts);
    add_heat(day, -1.0, 1, row_of(day, TT_DAY_OFF), watts);
  } else if (heat <= m->drives) {
    const int channel = m->drive_channel[heat - 1];
    drive_heat(day, heat - 1, rest, channel < 0 ? 0.0 : rest[channel], watts);
  } else {
    warm_heat(day, heat - 1 - m->drives, watts);
  }
}

void tt_day_drive_heat(tt_day* day, int drive, const double* row, double* watts) {
  const tt_day_model* m = day->model;
  tt_zero(m->sensors->order, watts);
  if (m->machine_on >= 0 && row[m->machine_on] == 0.0) return;
  drive_heat(day, drive, row, 0.0, watts);
}
