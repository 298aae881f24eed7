/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_PAUSE_H
#define THERMOTWIN_PAUSE_H
/* A time without rows, such as a night with the power off: the machine is off, its axes stay where they are, and its
 * surroundings are as they were last told. Deviations grow, because no sensor says otherwise. */

#include "compensation/control/twin.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { TT_LONGEST_PAUSE_S = 7 * 86400 }; /* a state that is older says less than a cold start */

/* Rows of a machine that is off, from the last row up to a millisecond before the time. */
void tt_twin_pass_pause(tt_twin* twin, double until);

/* Whether readings contradict such a pause: the machine was at work then, and the caller starts anew from the readings.
 * sensors_C: as of tt_twin_row, of the row after the pause. */
int tt_twin_contradicts_pause(tt_twin* twin, const double* sensors_C);

#ifdef __cplusplus
}
#endif
#endif
