/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_DRIFT_WATCH_H
#define THERMOTWIN_DRIFT_WATCH_H
/* Detects sensors that drift slowly, by the offsets that the others and the model see (the C++ class, with the rules:
 * online/drift_watch.h). */

#include "compensation/control/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Samples of sixteen hours, ten minutes apart: 96, the one before, the newest, and room. */
enum { tt_drift_samples = 100 };

typedef struct tt_drift_watch {
  int32_t sensors;
  const double* std;               /* (sensors) stated standard deviation of a reading, K */
  double *time, *value;            /* (tt_drift_samples x sensors) */
  int32_t *first, *count, *drifts; /* (sensors) */
} tt_drift_watch;

void tt_drift_lay(tt_drift_watch* watch, int sensors, const double* std, tt_arena* arena);
void tt_drift_start(tt_drift_watch* watch);
/* Offsets and their deviations, K, NaN if unknown. Returns the sensor that drifts, at its first naming; -1: none. */
int tt_drift_judge(tt_drift_watch* watch, double time, const double* value, const double* std);

#ifdef __cplusplus
}
#endif
#endif
