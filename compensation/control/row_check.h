/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_ROW_CHECK_H
#define THERMOTWIN_ROW_CHECK_H
/* Check of a row for impossible values: infinite or above 1e10, a state outside 0 to 1, beyond the machine's limits
 * (compensation/online/input_limits.h), or no temperature of this machine in degC
 * (compensation/online/reading_check.h). NaN is a missing value and no fault. */

#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Sets such values of given (channels) to NaN and writes the reason, TT_FAULT_..., to fault (channels). Returns the
 * number of such values. */
int tt_check_row(const tt_model* m, double* given, int32_t* fault);

#ifdef __cplusplus
}
#endif
#endif
