/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_CHILLER_H
#define THERMOTWIN_CHILLER_H
/* Outlet temperatures of the chillers, as solver/operation/chiller.h states them, for readings that stand over a
 * step. */

#include "compensation/control/arena.h"
#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* (coolants) each; K above the reference */
typedef struct tt_chiller {
  double *outlet, *inlet, *integral; /* inlet: mean over the last step */
  int32_t* running;                  /* 1: the compressor runs */
} tt_chiller;

tt_chiller tt_chiller_in(tt_arena* arena, const tt_model* m);
/* Outlets at the set points. readings_K (readings), guide_K (coolants): tt_guide_K */
void tt_chiller_start(const tt_model* m, const double* readings_K, const double* guide_K, tt_chiller* c);
/* A step of the mean row; compressors switch within it. */
void tt_chiller_advance(const tt_model* m, const double* row, const double* readings_K, const double* guide_K,
                        double step_s, tt_chiller* c);

#ifdef __cplusplus
}
#endif
#endif
