/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_PROBING_H
#define THERMOTWIN_PROBING_H
/* A TCP error that was measured on the machine re-identifies it (the C++ class: online/compensator.h). Beside the
 * machine's quantities it tells how much more each side moves than the model says, and a remainder (errors.h). What it
 * finds comes into effect over some minutes. */

#include "compensation/control/twin.h"

#ifdef __cplusplus
extern "C" {
#endif

/* error: (3) m, tool against table without any offset, NaN where not measured; std_m: of each. pose: (axes) m and rad.
 * The work of a correction is done at once: this is no part of a row. Returns the number of values that it took: 0
 * before the first row, while the start is under way, and without observer. */
int tt_twin_probe(tt_twin* twin, const double* pose, const double error[3], double std_m);

#ifdef __cplusplus
}
#endif
#endif
