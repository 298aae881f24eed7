/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_ERRORS_H
#define THERMOTWIN_ERRORS_H
/* The uncertain quantities theta of a machine and their estimation from sensors and probing: a Kalman filter in a few
 * parameters on top of the sensitivities S (the C++ class, with the reasons: online/error_model.h). theta holds, in
 * this order: the columns of S (sensitivities.h), a constant offset of each reading, and nine quantities of the outputs
 * that only probing estimates: relative excess of the motion of the tool side and the table side along x, y, z, and a
 * remainder in x, y, z (m). A quantity that is not there (a drive that was always recorded, a pattern beyond those of
 * the start) has the standard deviation 0. */

#include "compensation/control/sensitivities.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { tt_outputs = 9 };

typedef struct tt_errors {
  tt_sensitivities sensitivities;
  double *theta, *prior, *mean, *memory; /* (all); prior: standard deviation; memory: s, 0: does not fade */
  double *withheld, *shown, *row, *gain; /* (all) part of theta that is not shown yet; the rest; scratch */
  double* sigma;                         /* (all x all) covariance of theta */
  double* least;                         /* (drives) of theta: minus what the nominal run has already */
  double* scratch;                       /* (order) */
  int32_t* flags;                        /* learns, air_is_untold, shapes */
} tt_errors;

/* A mean of reading minus nominal prediction over an interval. */
typedef struct tt_innovation {
  int32_t sensor;
  double value;     /* K */
  double moment;    /* mean time in the interval, 0 start .. 1 end */
  double deviation; /* K, how far the sensor is from the start: scales the model error */
} tt_innovation;

typedef struct tt_sensor_offset {
  double value, std; /* K; std is infinite where nothing else tells */
} tt_sensor_offset;

int tt_errors_count(const tt_sensor_model* model);        /* all: size of theta */
int tt_errors_first_bias(const tt_sensor_model* model);   /* of the sensors' offsets */
int tt_errors_first_output(const tt_sensor_model* model); /* of the outputs */

void tt_errors_lay(tt_errors* e, const tt_sensor_model* model, tt_arena* arena);
/* To be told before the start. */
void tt_errors_air_is_untold(tt_errors* e);
/* uniform_K: standard deviation of the mean initial temperature. patterns: (order x shapes) of unit deviation.
 * ambient_gap_K: (ambients) temperature by the sensors minus the default of an ambient that nobody measures, else 0. */
void tt_errors_start(tt_errors* e, double uniform_K, int shapes, const double* patterns, const double* ambient_gap_K);
/* To be told after the start: the offset of a sensor has this deviation (K), and stays as it is. Does nothing where the
 * stated deviation is larger. */
void tt_errors_doubt(tt_errors* e, int sensor, double std_K);
int tt_errors_doubts(const tt_errors* e, int sensor);
/* The heat of an unrecorded drive over the interval of the next advance, (order); NULL: recorded. It is a quantity from
 * then on, with deviation 1. nominal: speed of the nominal run over half speed. */
void tt_errors_set_untold(tt_errors* e, int drive, const double* heat, double nominal);

/* Slices: tt_sensitivities_slice(&e->sensitivities), then finish. */
void tt_errors_begin_advance(tt_errors* e, const tt_interval* interval);
void tt_errors_finish_advance(tt_errors* e); /* the uncertainty has grown, too */

/* independent_s > 0: time that the readings stand for; 0: one independent sample. */
void tt_errors_observe(tt_errors* e, const tt_innovation* innovation, double independent_s);
void tt_errors_settle(tt_errors* e); /* after the last observation */
/* Standard deviations, of the estimate and of the reading together, by which a reading is off. Changes scratch only. */
double tt_errors_surprise(tt_errors* e, const tt_innovation* innovation);
/* A probed TCP error. tool, table: (order x 3) rows of its translations, m; nominal: (order) state; error: (3) m, NaN
 * where not measured. */
void tt_errors_learn(tt_errors* e, const double* tool, const double* table, const double* nominal, const double* error,
                     double std_m);
void tt_errors_show(tt_errors* e, double duration); /* what was learnt comes into effect by and by */

/* Each writes (order) or (sensors) values. */
void tt_errors_correction(tt_errors* e, double* correction);
void tt_errors_correction_rate(tt_errors* e, double* rate);
void tt_errors_sensor_correction(tt_errors* e, double* correction);
void tt_errors_sensor_correction_rate(const tt_errors* e, double* rate);
void tt_errors_sensor_rate_std(tt_errors* e, double* std);
void tt_errors_output_shares(const tt_errors* e, double* shares); /* (tt_outputs) */
int tt_errors_learns(const tt_errors* e);                         /* whether anything was probed */
int tt_errors_shapes(const tt_errors* e);                         /* patterns of earlier work */
int tt_errors_air_untold(const tt_errors* e);                     /* see tt_errors_air_is_untold */

/* Standard deviation of noise and model error of a mean reading, K. */
double tt_reading_std(double uncertainty_K, double deviation_K);
tt_sensor_offset tt_errors_offset(const tt_errors* e, int sensor);
tt_sensor_offset tt_errors_own_offset(const tt_errors* e, int sensor); /* with its own prior */
void tt_errors_release(tt_errors* e, int sensor); /* of a sensor that drifts: only its own offset follows it */

#ifdef __cplusplus
}
#endif
#endif
