/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_DAY_OF_WORK_H
#define THERMOTWIN_DAY_OF_WORK_H
/* Heats of the size of a day's work, and the operating points at which a machine keeps or loses them: what
 * work_before.h begins with. The heats are those of the standing machine, of each drive at half speed, and of
 * surroundings that are warmer than the hall (the C++ classes: online/work_before.h, online/drive_heats.h). */

#include "compensation/control/sensitivities.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { TT_DAY_OFF, TT_DAY_STANDING, TT_DAY_SWEPT, TT_DAY_ROWS }; /* as TT_MODES_... of work_before.h */

/* Channels are in the units of their names; -1: the machine has none. */
typedef struct tt_day_model {
  const tt_sensor_model* sensors;
  int32_t channels, axes, coolants, drives, warm;
  int32_t machine_on, fluid_on;
  const double* channel_default;                       /* (channels) */
  const int32_t *axis_position, *axis_low, *axis_high; /* (axes) channels */
  const double *travel_low, *travel_high;              /* (axes) */
  const int32_t* coolant_on;                           /* (coolants) channels */
  const int32_t* drive_channel;                        /* (drives) of speed or feed: the spindle, then the axes */
  const double* drive_half_speed;                      /* (drives) */
  const int32_t* warm_quantity;                        /* (warm) quantities that are surroundings */
  const double* warm_K;                                /* (warm) */
  /* p (terms) and q (inputs) at a row, with coolant inlets at the reference and laws at nominal temperatures */
  void (*coefficients)(const void* with, const double* row, double* p, double* q);
  const void* with;
} tt_day_model;

typedef struct tt_day {
  const tt_day_model* model;
  double* rows;        /* (channels x TT_DAY_ROWS) */
  double *p, *q, *row; /* scratch */
} tt_day;

int tt_day_heats(const tt_day_model* model); /* standing, drives, surroundings */
void tt_day_lay(tt_day* day, const tt_day_model* model, tt_arena* arena);
void tt_day_set(tt_day* day, const double* row); /* where the axes stand */
/* (terms) p of one of the rows: the operator is K0 + sum p K */
void tt_day_coefficients(tt_day* day, int kind, double* p);
/* (order) one heat, W on the basis; a piece of work of less than 0.1 ms at order 240 */
void tt_day_heat(tt_day* day, int heat, double* watts);
/* (order) what half speed adds to the standing drive, other inputs as in the row; 0 while the machine is off */
void tt_day_drive_heat(tt_day* day, int drive, const double* row, double* watts);

#ifdef __cplusplus
}
#endif
#endif
