/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_DEVIATION_H
#define THERMOTWIN_DEVIATION_H
/* Variance of the offsets from the covariance Sigma of the uncertain quantities, as compensation/online/output_map.h
 * states it: with S what the state owes to them and r the row of an axis' offset at a pose of the workspace grid,
 *   var = (S^T r)^T Sigma (S^T r),
 * the mean over angles of the table's own axis, interpolated between the poses. After a probing, Sigma and S^T r hold
 * the shares of the tool side and the table side and the remainder too. Cut into slices: outputs of S at all stored
 * poses of the grid, then the variances place by place. */

#include "compensation/control/arena.h"
#include "compensation/control/errors.h"
#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tt_deviation {
  double *variance, *smallest; /* (linear_axes x tables x poses) m^2, of the grid; (linear_axes) least of these */
  double* next;                /* as variance, of the slices in progress */
  /* What follows from the model or the slices in progress. */
  double* columns; /* (linear_axes x 19) of each angle, table and pose: offsets by the outputs of unit size */
  double* outputs; /* (columns x outputs) of S at the grid */
  double *influence, *product; /* (columns + tt_outputs) */
  double *at_poses, *at_tables;
} tt_deviation;

/* The values, then what need not be saved. */
void tt_deviation_lay(tt_deviation* d, const tt_model* m, const tt_sensor_model* sensors, tt_arena* state,
                      tt_arena* work);
void tt_deviation_prepare(tt_deviation* d, const tt_model* m);

int tt_deviation_slices(const tt_model* m, const tt_sensor_model* sensors);
/* At most so many slices from one on; returns how many it did. outputs: of the present state at all stored poses
 * (outputs.h), that shares of the sides count from */
int tt_deviation_work(tt_deviation* d, const tt_model* m, const tt_errors* errors, const double* outputs, int slice,
                      int slices);
void tt_deviation_finish(tt_deviation* d, const tt_model* m); /* next takes effect */
/* (linear_axes) variance at a pose, m^2; never below the smallest of the grid */
void tt_deviation_at(const tt_deviation* d, const tt_model* m, const double* pose, double* variance);

#ifdef __cplusplus
}
#endif
#endif
