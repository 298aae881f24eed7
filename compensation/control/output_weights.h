/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_OUTPUT_WEIGHTS_H
#define THERMOTWIN_OUTPUT_WEIGHTS_H
/* Weights of the stored poses at a pose, as reduction/model/output_grid.h states them. */

#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { TT_MOST_POSITIONS = 64 }; /* of one axis of a grid */

/* pose (axes) m and rad; weights (tool_poses) and (table_poses) */
void tt_tool_weights(const tt_model* m, const double* pose, double* weights);
void tt_table_weights(const tt_model* m, const double* pose, double* weights);
/* The same on the workspace grid alone, (grid_poses) and (grid_tables). */
void tt_grid_weights(const tt_model* m, const double* pose, double* weights);
void tt_grid_table_weights(const tt_model* m, const double* pose, double* weights);

#ifdef __cplusplus
}
#endif
#endif
