/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_MEAN_ROW_H
#define THERMOTWIN_MEAN_ROW_H
/* Time-weighted means of the channels over a step, as compensation/online/input_mean.h states them: a channel that does
 * not change keeps its exact value, and the positions of an axis that moves become the range that it swept. */

#include "compensation/control/arena.h"
#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tt_mean_row {
  double* duration;             /* (1) s since the last take */
  double *first, *sum, *weight; /* (channels) */
  double *least, *most;         /* (axes) of the positions, in the channel's unit */
  int32_t* changed;             /* (channels) */
} tt_mean_row;

tt_mean_row tt_mean_row_in(tt_arena* arena, const tt_model* m);
/* Adds a row (channels) that holds for the duration. */
void tt_mean_add(const tt_model* m, const double* row, double duration, tt_mean_row* mean);
/* The mean row (channels) since the last take; begins anew. */
void tt_mean_take(const tt_model* m, tt_mean_row* mean, double* row);

#ifdef __cplusplus
}
#endif
#endif
