/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_OPERATING_H
#define THERMOTWIN_OPERATING_H
/* From channels to the coefficients p and q of the equation, as solver/operation/operating_model.h states them, and
 * what rows do to the channels that hold. A value that nobody gives is NaN. */

#include "compensation/control/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Takes what is given over into the row; ranges end as solver/operation/channels.h says. Both (channels). */
void tt_update_row(const tt_model* m, const double* given, double* row);

double tt_ambient_K(const tt_model* m, int ambient, const double* row);
/* (coolants) temperatures of the ambients that guide chillers; 0 where a sensor does */
void tt_guide_K(const tt_model* m, const double* row, double* guide_K);
double tt_source_power(const tt_model* m, int source, const double* row); /* W */
void tt_pose(const tt_model* m, const double* row, double* pose);         /* (axes) m and rad */

/* p (terms), q (inputs), occupancy (terms).
 * row (channels) means over the step; inlet_K (coolants); readings_K (readings), NULL: laws at nominal temperatures */
void tt_coefficients(const tt_model* m, const double* row, const double* inlet_K, const double* readings_K, double* p,
                     double* q, double* occupancy);

#ifdef __cplusplus
}
#endif
#endif
