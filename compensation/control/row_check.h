/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_ROW_CHECK_H
#define THERMOTWIN_ROW_CHECK_H
/* Values of a row that cannot be: not finite, beyond the machine's limits (compensation/online/input_limits.h), or no
 * temperature of this machine in degC (compensation/online/reading_check.h). */

#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Sets such values to NaN and says why. given, fault (channels). Returns how many. */
int tt_check_row(const tt_model* m, double* given, int32_t* fault);

#ifdef __cplusplus
}
#endif
#endif
