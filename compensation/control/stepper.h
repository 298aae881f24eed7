/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_STEPPER_H
#define THERMOTWIN_STEPPER_H
/* A step of the state (SDIRK2 as in solver/thermal/integrator.h), cut into slices of about the same work:
 *   M = 1 + gamma h (K0 + sum_j p_j K_j)   some entries a slice
 *   M = L U                                 some columns a slice
 *   M x1 = x + gamma h q,   M x2 = x + (1 - gamma) / gamma (x1 - x) + gamma h q
 *   sensors and outputs at all stored poses of x2 and x2 - x
 * All of it is a function of x, p, q and h, so a step that was interrupted can be done again from them.
 *
 * Terms are stored in low rank; at the start the triangles of the symmetric ones are expanded, because a sum of them is
 * bound by memory. They are floats, with an error of 6e-8 as small as that of the low rank, since half the memory is
 * half the time of a sum: 18 MB at order 240 with 152 terms. Between two rows of a control the caches are lost, so a
 * slice reads as little as it can: the same part of the triangles of all terms, which lie one after the other. */

#include "compensation/control/arena.h"
#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tt_work {
  float* triangles; /* lower triangles of all symmetric terms, a part of all of them after the other */
  double* triangle; /* their sum */
  double *matrix, *factor_p, *stage, *right, *heat;
  double *next_sensors, *next_base, *next_slope, *difference;
  double *corrected, *corrected_change; /* x2 and x2 - x with the correction */
  double* operator_matrix;              /* (order x order) of tt_operator_slice */
  double* scratch;                      /* weights of poses */
  int32_t *symmetric, *pivots, *lu_first;
  int symmetric_terms, constant_symmetric;
  int sum_slices, build_slices, flow_slices, lu_slices, project_slices; /* beside 2 stages and 1 for sensors */
  double factor_step; /* the factor belongs to factor_p and this; 0: none */
} tt_work;

typedef struct tt_step {
  double step_s;
  const double *p, *q, *state; /* (terms), (inputs), (order) */
  /* Outputs are those of x2 + correction + since rate, (order) each; NULL: of x2. */
  const double *correction, *rate;
  double since; /* s */
} tt_step;

tt_work tt_work_in(tt_arena* arena, const tt_model* m);
/* Expands the terms and counts the slices. */
void tt_work_prepare(const tt_model* m, tt_work* w);

int tt_slices(const tt_work* w); /* of a step */
/* One slice of a step, 0 to tt_slices - 1 in this order; the step stays as it is.
 * Returns 0, or 1 if the numerics failed. The result of the last: stage, next_sensors, next_base, next_slope. */
int tt_slice(const tt_model* m, tt_work* w, const tt_step* step, int slice);

/* operator_matrix = K0 + sum_j p_j K_j. Not while a step is under way. */
int tt_operator_slices(const tt_work* w);
void tt_operator_slice(const tt_model* m, tt_work* w, const double* p, int slice);
/* next_base and next_slope: outputs at all stored poses of a state and a change. */
int tt_project_slices(const tt_work* w);
void tt_project_slice(const tt_model* m, tt_work* w, const double* state, const double* change, int slice);

/* y += factor (K0 + sum_j p_j K_j) x, by low-rank terms */
void tt_apply_operator(const tt_model* m, double factor, const double* p, const double* x, double* y);
/* matrix (order x order) += factor K_j */
void tt_add_term(const tt_model* m, int term, double factor, double* matrix);

#ifdef __cplusplus
}
#endif
#endif
