/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_SPECIAL_H
#define THERMOTWIN_SPECIAL_H
/* Functions of the observer's statistics, on the exponential of scalars.h: the same bits everywhere. Relative errors
 * lie below 1e-13. */

#ifdef __cplusplus
extern "C" {
#endif

double tt_expm1(double x); /* exp(x) - 1 without the loss near 0 */
/* 1 - erf(x), x >= 0: the probability that a normal number lies further than x sqrt(2) deviations from its mean. Series
 * below 1.5, continued fraction above (Abramowitz and Stegun, 7.1.6 and 7.1.14). */
double tt_erfc(double x);

/* Of n values, without changing them: the one that n_th others lie below (0: the smallest); equal ones count in their
 * order. NaN if there are fewer. */
double tt_nth_smallest(int n, const double* values, int nth);
/* The larger middle one of an even number of values. */
double tt_median(int n, const double* values);

#ifdef __cplusplus
}
#endif
#endif
