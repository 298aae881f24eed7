/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_OUTPUTS_H
#define THERMOTWIN_OUTPUTS_H
/* Axis offsets from outputs at the stored poses, as compensation/online/output_map.h and solver/elastic/tcp.h state
 * them: sum_i a_i offset_i = -(tool - table). */

#include "compensation/control/arena.h"
#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Outputs of one state at all stored poses: 6 tool_poses, 6 and 7 table_poses, one after the other. */
int tt_output_count(const tt_model* m);
/* Outputs [first, last) of two states at once: y = C x, z = C d. x, d (order); y, z (tt_output_count) */
void tt_project(const tt_model* m, int first, int last, const double* x, const double* d, double* y, double* z);

/* Error of the TCP (3), m, of base + share * change at the pose (axes).
 * scratch (tool_poses + table_poses) */
void tt_tcp_error(const tt_model* m, const double* base, const double* change, double share, const double* pose,
                  double* scratch, double error[3]);
/* The outputs at the pose that this error follows from: tool 6, table by its axis 6, table by itself 7. */
void tt_sides_at(const tt_model* m, const double* base, const double* change, double share, const double* pose,
                 double* scratch, double sides[19]);
/* The error of given outputs at the pose. */
void tt_error_of_sides(const tt_model* m, const double* pose, const double sides[19], double error[3]);
/* (linear_axes) offsets, m, that cancel it */
void tt_offsets(const tt_model* m, const double error[3], double* offsets);
/* Whether an axis stands outside the workspace of the model. */
int tt_outside(const tt_model* m, const double* pose);

#ifdef __cplusplus
}
#endif
#endif
