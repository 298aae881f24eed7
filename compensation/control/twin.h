/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_TWIN_H
#define THERMOTWIN_TWIN_H
/* The twin of one machine: rows of a control's channels and sensors in, axis offsets with their deviations out, without
 * allocation, files or clocks.
 *
 * The state advances in steps of at most step_s with the means of the rows, as compensation/online/state_clock.h states
 * it. Where the model has an observer, corrections by the sensors follow the steps (observer.h). Both are jobs of
 * slices, one at a time. A step begins in the row that ends it, a correction in the row in which its step has taken
 * effect. A row dt after the row before does ceil(slices dt / latency) slices of the job, latency = step_s / 2, and the
 * job takes effect in the row that does its last one. A row that comes later than the latency does whole jobs, so that
 * rows as far apart as the steps give what compensation/online/compensator.h gives. Until then offsets follow the last
 * step's rate. When a job takes effect depends on machine time alone, not on processor time.
 *
 * The first row finds the initial state (observer_start.h). That work is done in this row, or spread over start_over_s
 * of machine time. Until it is done, offsets are 0 and the status is TT_STARTING; the initial state then counts as that
 * of the row in which it is done.
 *
 * The caller gives two blocks of memory, aligned to 8 bytes. All values of the twin lie in the first one and no pointer
 * does: a copy of it is its state. The second holds what follows from the model and from an unfinished job. */

#include <stddef.h>

#include "compensation/control/chiller.h"
#include "compensation/control/deviation.h"
#include "compensation/control/mean_row.h"
#include "compensation/control/observer_data.h"
#include "compensation/control/stepper.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The status of a row: the last of these that holds. */
enum {
  TT_OK,
  TT_LIMITED,
  TT_SENSOR_FAILED, /* sensors are left out: tt_twin_sensor_fault */
  TT_NO_SENSORS,
  TT_OUTSIDE_WORKSPACE,
  TT_INPUT_MISSING,
  TT_STARTING,
  TT_FAILED
};
/* A row that is refused changes nothing: its time does not rise, or leaps by more than 30 days. */
enum { TT_REFUSED_TIME = -1 };
/* Why a value of a channel is not used. */
enum {
  TT_FAULT_NONE,
  TT_FAULT_UNREADABLE,
  TT_FAULT_BEYOND,
  TT_FAULT_IMPLAUSIBLE,
  TT_FAULT_KELVIN,
  TT_FAULT_FAHRENHEIT
};
enum { TT_FOLLOWING, TT_GUARD_LIMITED, TT_HOLDING_STILL, TT_RETURNING }; /* what the guard does */
/* Why a saved state is refused. */
enum { TT_LOADED, TT_NO_STATE, TT_OTHER_VERSION, TT_OTHER_MODEL, TT_DAMAGED };

enum { TT_JOB_NONE, TT_JOB_STEP, TT_JOB_CORRECTION, TT_JOB_START }; /* see twin_jobs.h */

/* Times in s. */
typedef struct tt_numbers {
  double time;                         /* of the last row */
  double started_at;                   /* of the first row that the model's time begins at */
  double step_end, last_step;          /* end and length of the last step that took effect */
  double job_began, job_end, job_step; /* the row that began the step or the start; the step's end and length */
  double interval_s;                   /* steps since the last correction began */
  double valid_at;                     /* last row with valid offsets, for the guard */
  int32_t started, guarded;            /* whether there was a row; one with offsets */
  int32_t job, phase, slices_done;     /* the job in progress; its phase, and slices of that */
  int32_t modes;                       /* of the start: operating point of a day's work */
  int32_t p_changed;                   /* in this interval */
  int32_t failed;                      /* the last step gave no number */
  int32_t status, guard;
} tt_numbers;

typedef struct tt_twin {
  const tt_model* model;
  tt_numbers* now;
  double *row, *given_at;  /* (channels) values that hold; when each was given */
  int32_t *fault, *untold; /* (channels) of the last row; 1: never given */
  tt_mean_row mean;
  tt_chiller chiller;
  double *p, *q;                        /* of the last step */
  double *state, *before, *change;      /* (order) at step_end, a step before, and their difference */
  double *sensors, *sensors_change;     /* (readings) predicted at step_end, and their change over the step */
  double *base, *slope;                 /* outputs at all stored poses of the corrected state and its change */
  double *pose, *wanted_um, *offset_um; /* (axes) of the last row; (linear_axes) before and after the guard */
  double* std_um;                       /* (linear_axes) one standard deviation of offset_um; NaN without observer */
  double* last_um;                      /* (linear_axes) last valid offsets */
  double *interval_p, *interval_q, *interval_state; /* sums over steps times their length since a correction began */
  double *first_p, *job_p;                          /* of the interval's first step; of the job's operator */
  double* start_row;                                /* (channels) the first row */
  tt_observer observer;
  tt_day day;
  tt_deviation deviation;
  tt_work work;
  double *mean_row, *given, *row_before, *readings, *guide, *occupancy, *offset, *heat, *mean_q, *mean_state, *off_row,
      *pose_rows;        /* scratch */
  tt_observer_data data; /* that observer and day point to */
  unsigned char* block;
  size_t block_bytes;
} tt_twin;

size_t tt_twin_state_bytes(const tt_model* m);
size_t tt_twin_work_bytes(const tt_model* m);
/* Begins at start_C everywhere. Blocks of the sizes above; they and the model must outlive the twin, which must stay
 * where it is. */
void tt_twin_begin(tt_twin* twin, const tt_model* m, void* state, void* work);

/* States a channel that no row will have, before the first row: the deviations include what it may do. */
void tt_twin_never_given(tt_twin* twin, int channel);
/* One row. time s, rising; channels (channels) in the units of their names, NaN where not given; sensors_C (sensors)
 * readings, NaN where missing, NULL: none. Returns the status, or TT_REFUSED_TIME. Offsets: twin->offset_um, std_um */
int tt_twin_row(tt_twin* twin, double time, const double* channels, const double* sensors_C);
/* Why a sensor is left out: tt_sensor_fault of reading_check.h, and its text. */
int tt_twin_sensor_fault(const tt_twin* twin, int sensor);
const char* tt_twin_sensor_fault_text(const tt_twin* twin, int sensor);
/* (sensors) readings that the model expects, before its last correction, degC; NaN without observer */
void tt_twin_predicted_C(const tt_twin* twin, double* readings_C);
/* Values of all channels of a machine that stands and is on; NaN where a law of the model takes over. */
const double* tt_twin_defaults(const tt_model* m);
/* (linear_axes) offsets in um at any pose (axes; m and rad) at the time of the last row, without the guard. */
void tt_twin_offsets_at(const tt_twin* twin, const double* pose, double* offset_um);
/* (linear_axes) one standard deviation of such offsets, um, without what the guard keeps back; NaN without observer. */
void tt_twin_std_at(const tt_twin* twin, const double* pose, const double* offset_um, double* std_um);
const char* tt_status_text(int status);
const char* tt_fault_text(int fault);

/* A saved state: a head with the model's hash and a sum over the block. */
size_t tt_twin_saved_bytes(const tt_model* m);
void tt_twin_save(const tt_twin* twin, void* saved);
/* Goes on from a saved state, of a twin that has begun. Returns TT_LOADED, or why nothing was changed. */
int tt_twin_load(tt_twin* twin, const void* saved, size_t bytes);

#ifdef __cplusplus
}
#endif
#endif
