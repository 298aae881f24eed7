/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_OBSERVER_H
#define THERMOTWIN_OBSERVER_H
/* Corrects the thermal state by the sensors (the C++ class, with the equations: online/observer.h). The nominal state
 * is advanced by the caller; it is shown to each call as a tt_moment.
 *
 * The start and a correction are jobs of slices. A correction takes effect at tt_observer_finish_correction, at a time
 * that the caller fixes; until then rows use the correction before it. The order at a start:
 *   heats and modes (work_before.h), tt_observer_begin_start, slices, then the caller sets the state to the uniform
 *   temperature and starts its clock; tt_observer_begin_taking, slices; tt_observer_begin_foresight, slices,
 *   tt_observer_finish_foresight. */

#include "compensation/control/errors.h"
#include "compensation/control/sensor_trust.h"
#include "compensation/control/work_before.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tt_observer_model {
  const tt_sensor_model* sensors;
  const tt_reading_model* readings;
  int32_t heats;                  /* of earlier work */
  int32_t ambients, air_channel;  /* -1: none */
  const int32_t* ambient_channel; /* (ambients) of every ambient; -1: none */
  const double* sensor_offset;    /* (sensors) reading in K above the reference minus the state's temperature */
  double step_s, correction_s;    /* longest step of the state; longest time between corrections */
  int32_t start_from_sensors;
} tt_observer_model;

/* The nominal run at the last row (online/state_clock.h). */
typedef struct tt_moment {
  double time, step_end, started_at, last_step; /* s */
  double interval_s;                            /* since the last correction began */
  const double *state, *change;                 /* (order) at the end of the last step; change over that step */
  const double *seen, *seen_change;             /* (sensors) the same, of the predicted readings */
} tt_moment;

typedef struct tt_observer {
  const tt_observer_model* model;
  tt_past_model past_model;
  tt_past past;
  tt_trust trust;
  tt_errors errors;
  double *reading_C, *reading_K, *guide_K; /* (measured), (measured), (sensors) */
  double *seen_one, *seen_start, *shift;   /* (sensors) state of 1 K; at the start; correction before the last one */
  double *bias, *bias_rate, *unsure_rate;  /* (sensors) correction of predicted readings; its rate; its deviation */
  double* own_offset;                      /* (sensors) of the readings themselves */
  double *correction, *correction_rate, *corrected;       /* (order) */
  double *innovation_sum, *moment_sum, *innovation_count; /* (measured) since the last correction began */
  double *value, *mean_moment, *deviation;                /* (measured) innovations of the correction in progress */
  int32_t *has_value, *explained;                         /* (measured) */
  double *energy, *way;                /* (order x drives), (drives) of unrecorded drives: see add_drive */
  int32_t* unrecorded;                 /* (drives) */
  int32_t* first_sensor;               /* (measured) scratch of first readings */
  double *first_value, *scratch, *gap; /* (measured), (2 sensors), (ambients) */
  double* row;                         /* (channels) of the start */
  double* numbers;
  int32_t* flags;
} tt_observer;

void tt_observer_lay(tt_observer* o, const tt_observer_model* model, tt_arena* arena);
void tt_observer_reset(tt_observer* o); /* before the first row */

/* Takes the readings of a row, (measured) degC, NaN where missing; NULL: none. row: (channels) as it holds. */
void tt_observer_read(tt_observer* o, const double* sensors_C, const double* row);
int tt_observer_any_reading(const tt_observer* o);
/* Whether the readings that were taken last contradict the state: two of them, or one of one or two, are more than four
 * standard deviations off. Not while a correction is in progress. */
int tt_observer_is_contradicted(tt_observer* o, const tt_moment* now);

/* Finds the uniform temperature, which sensors the others explain, and what earlier work has left. now: the time, and
 * the state that holds without sensors. */
void tt_observer_begin_start(tt_observer* o, const tt_moment* now, const double* row);
/* Returns 0: more to do, 1: done, 2: eigenvalues did not converge, earlier work is left out. */
int tt_observer_start_slice(tt_observer* o);
/* After the slices. Returns whether the sensors determine the initial temperature: uniform, K above the reference. */
int tt_observer_uniform(const tt_observer* o, double* temperature_K);
/* The uncertainty of this state, and what the first readings say of it. Returns 1 after the last reading. */
void tt_observer_begin_taking(tt_observer* o, const tt_moment* now);
int tt_observer_take_slice(tt_observer* o);
/* How what the start left changes at first; slices: tt_sensitivities_slice(&o->errors.sensitivities). */
void tt_observer_begin_foresight(tt_observer* o, const double* operator_matrix);
void tt_observer_finish_foresight(tt_observer* o, const tt_moment* now);

/* Readings that chillers use, (sensors) K: measured ones where present and trusted, else predicted ones. */
const double* tt_observer_guide(tt_observer* o, const tt_moment* now);
void tt_observer_add_readings(tt_observer* o, const tt_moment* now, int inputs_leapt);

/* Each row: its duration, then its unrecorded drives with their heat at half speed, (order) W on the basis, and the
 * speed of the nominal run over half speed. */
void tt_observer_add_row(tt_observer* o, double duration);
void tt_observer_add_drive(tt_observer* o, int drive, double duration, const double* heat, double speed);

/* Whether a correction is due at this end of a step; never while one is in progress. */
int tt_observer_due(const tt_observer* o, const tt_moment* now);
void tt_observer_begin_correction(tt_observer* o, const tt_moment* now, const tt_interval* interval);
int tt_observer_correction_slice(tt_observer* o); /* as tt_sensitivities_slice and tt_sensitivities_work */
int tt_observer_correction_work(tt_observer* o, int* slices);
int tt_observer_correction_slices(const tt_observer_model* model);
void tt_observer_finish_correction(tt_observer* o, const tt_moment* now);

/* A probed TCP error, see tt_errors_learn; not while a correction is in progress. state: (order) nominal, at now. */
void tt_observer_learn(tt_observer* o, const tt_moment* now, const double* tool, const double* table,
                       const double* state, const double* error, double std_m);
void tt_observer_show(tt_observer* o, double duration);
void tt_observer_set_corrected(tt_observer* o, const tt_moment* now); /* after a step of the state */
double tt_observer_corrected_at(const tt_observer* o);                /* s, time since which correction_rate counts */
void tt_observer_predicted_C(const tt_observer* o, const tt_moment* now, double* readings_C); /* (measured) */

#ifdef __cplusplus
}
#endif
#endif
