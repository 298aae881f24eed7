/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_SENSITIVITIES_H
#define THERMOTWIN_SENSITIVITIES_H
/* How the state follows the uncertain quantities theta_k of a machine: x changes by S theta, where
 *   dS_k/dt + K(p) S_k = ds/dtheta_k q - dK/dtheta_k x
 * is advanced by backward Euler over the intervals between corrections (the C++ class: online/error_model.h). The
 * columns of S are the quantities, the heats of drives without a recorded speed, and the start: a uniform temperature
 * and the patterns of earlier work. Columns of a drive or pattern that is not there are 0.
 *
 * An advance is cut into slices (a column of a factor, a term, a right-hand side): tt_sensitivities_begin copies what
 * it needs, S stays as it is until tt_sensitivities_finish. */

#include <stdint.h>

#include "compensation/control/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { tt_most_patterns = 16, tt_start_modes = 1 + tt_most_patterns };

/* What the estimation by sensors needs of a reduced model with capacity 1. Terms and inputs are laid out as in a model:
 * K_j = sum_c w_c u_c u_c^T, or sum_c u_c v_c^T. Lists of a quantity start at `..._first` (quantities + 1). */
typedef struct tt_sensor_model {
  int32_t order, terms, inputs;
  int32_t sensors;  /* readings that the model predicts */
  int32_t measured; /* the first of these are sensors, the others are never read */
  int32_t quantities, drives;
  int32_t air;                            /* quantity that is the temperature of the air; -1: none */
  const double *one_kelvin, *sensor_rows; /* (order), (order x sensors) */
  const double* sensor_std;               /* (measured) stated standard deviation of a reading, K */
  const double *term_left, *term_right, *term_weight;
  const int32_t *term_first, *term_right_first;       /* (terms + 1); (terms) -1: symmetric */
  const double* input_columns;                        /* (order x inputs) */
  const int32_t* input_term;                          /* (inputs) -1: a source */
  const double *quantity_std, *quantity_memory;       /* (quantities) a share or K; s, 0: does not fade */
  const int32_t* quantity_ambient;                    /* (quantities) ambient that it is the temperature of; -1: none */
  const int32_t *quantity_term_first, *quantity_term; /* terms, and what they drive, that scale with 1 + theta */
  const int32_t *quantity_input_first, *quantity_input; /* inputs that scale with 1 + theta */
  const int32_t *quantity_warm_first, *quantity_warm;   /* inputs that get p of their term times theta */
} tt_sensor_model;

/* Means over an interval of the nominal model's run. */
typedef struct tt_interval {
  double duration;               /* s */
  const double *p, *q, *state;   /* (terms), (inputs), (order) */
  const double* operator_matrix; /* (order x order) K0 + sum p K; NULL: follows by tt_sensitivities_set_operator */
} tt_interval;

typedef struct tt_sensitivities {
  const tt_sensor_model* model;
  double *directions, *next;            /* (order x columns) S, and S at the end of the interval */
  double* start_rate;                   /* (order x tt_start_modes) of the start's columns, 1/s */
  double *seen, *seen_last, *seen_next; /* (columns x sensors) H S now and an interval before; H of next */
  double* seen_rate;                    /* (columns x sensors) 1/s */
  double* heat;                         /* (order x drives) W on the basis, of a drive whose speed is not recorded */
  double* heat_seen;                    /* (sensors x drives) K/s at which readings rise when it starts */
  int32_t *unrecorded, *drive_known;    /* (drives) now; since the start */
  double *p, *q, *state, *scratch;
  double *factor, *factor_p; /* LU of 1 + h A; (terms) its coefficients */
  int32_t* pivots;
  double* numbers; /* duration of the job, duration of the factor */
  int32_t* progress;
} tt_sensitivities;

int tt_columns(const tt_sensor_model* model);     /* of S */
int tt_first_start(const tt_sensor_model* model); /* first column of the start */

void tt_sensitivities_lay(tt_sensitivities* s, const tt_sensor_model* model, tt_arena* arena);
/* The state at the start: uniform, and (order x shapes) patterns, at most tt_most_patterns. */
void tt_sensitivities_start(tt_sensitivities* s, int shapes, const double* patterns);
/* The heat of an unrecorded drive over the interval of the next advance; NULL: recorded. */
void tt_sensitivities_set_heat(tt_sensitivities* s, int drive, const double* heat);

/* An advance over an interval, linearised about the interval's state plus S theta. */
void tt_sensitivities_begin(tt_sensitivities* s, const tt_interval* interval, const double* theta);
void tt_sensitivities_set_operator(tt_sensitivities* s, const double* operator_matrix);
/* How what the start left changes from now on, until the next advance; only duration and operator count. */
void tt_sensitivities_begin_foresight(tt_sensitivities* s, double duration, const double* operator_matrix);
int tt_sensitivities_slices(const tt_sensor_model* model); /* no job takes more */
/* Returns 0: more to do, 1: done, 2: 1 + h A is singular. */
int tt_sensitivities_slice(tt_sensitivities* s);
/* At most so many slices at once, to the same bits: the factor is read once for them. slices: then as many as done. */
int tt_sensitivities_work(tt_sensitivities* s, int* slices);
double tt_sensitivities_duration(const tt_sensitivities* s); /* s, of the job */
/* Takes over what the slices computed; nothing unless they are done. */
void tt_sensitivities_finish(tt_sensitivities* s);

#ifdef __cplusplus
}
#endif
#endif
