/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_GUARD_H
#define THERMOTWIN_GUARD_H
/* Limits size and rate of the offsets, as compensation/online/offset_guard.h and offset_limits.h state them. */

#include "compensation/control/twin.h"

#ifdef __cplusplus
extern "C" {
#endif

/* From wanted_um to offset_um at a row. duration s since the row before, 0 in the first; pose (axes) of this row.
 * Updates last_um, valid_at, pose and guard. */
void tt_guard(tt_twin* twin, double time, double duration, int first, const double* pose);

#ifdef __cplusplus
}
#endif
#endif
