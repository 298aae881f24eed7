/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_OCCUPANCY_H
#define THERMOTWIN_OCCUPANCY_H
/* Weights of a joint's grid nodes by where an axis spends its time, as solver/operation/grid_occupancy.h states
 * them. */

#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* low, high: range of the axis, m or rad, equal for a standing axis; weights (nodes of the joint), sum 1 */
void tt_grid_occupancy(const tt_model* m, int joint, double low, double high, double* weights);

#ifdef __cplusplus
}
#endif
#endif
