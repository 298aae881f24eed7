/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_SENSOR_TRUST_H
#define THERMOTWIN_SENSOR_TRUST_H
/* Decides which readings are used: none that is implausible, of a failed or of a drifting sensor. */

#include "compensation/control/drift_watch.h"
#include "compensation/control/errors.h"
#include "compensation/control/reading_check.h"
#include "compensation/control/sensor_monitor.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tt_trust {
  tt_reading_check check;
  tt_monitor monitor;
  tt_drift_watch drift;
  int32_t *named, *named_check; /* (sensors) tt_sensor_fault of each; that of the check at that time */
  int32_t* biased;              /* (sensors) 1: has a constant offset since the start, and is used without it */
  double *offset, *offset_std;  /* (sensors) scratch */
} tt_trust;

/* std: (sensors) stated standard deviation of a reading. */
void tt_trust_lay(tt_trust* trust, const tt_reading_model* model, const double* std, tt_arena* arena);
void tt_trust_start(tt_trust* trust);
int tt_trusted(const tt_trust* trust, int sensor); /* whether the last reading may correct the model */

/* Finds sensors that have failed, see tt_monitor_judge. */
void tt_trust_watch(tt_trust* trust, double time, const double* reading_K, const double* expected_K, int inputs_leapt,
                    const double* unsure_K_s);
/* Finds a sensor that drifts, and removes its influence from the estimate; names offsets of sensors in doubt. */
void tt_trust_watch_drift(tt_trust* trust, double time, tt_errors* errors);

#ifdef __cplusplus
}
#endif
#endif
