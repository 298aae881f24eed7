/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_SCALARS_H
#define THERMOTWIN_SCALARS_H
/* Elementary functions of the online core. Those of libm differ from system to system in the last bit; these consist of
 * IEEE additions, products and divisions in a fixed order and give the same bits everywhere. Errors lie below 1.5 units
 * in the last place (sine and cosine beyond 20 rad: 3). Logarithms are carried as a sum of two doubles (T. J. Dekker
 * 1971), so that a power loses nothing by the size of its exponent. */

#ifdef __cplusplus
extern "C" {
#endif

#define TT_PI 3.14159265358979323846

double tt_nan(void);
int tt_is_nan(double x);
int tt_is_finite(double x);
double tt_min(double a, double b);
double tt_max(double a, double b);
double tt_clamp(double x, double low, double high); /* low <= high */

double tt_exp(double x);           /* 0 below -708, infinite above 709 */
double tt_log(double x);           /* x > 0, normal numbers; else NaN */
double tt_pow(double x, double y); /* x >= 0; 0 for x = 0 and y > 0 */
double tt_cbrt(double x);
double tt_sin(double x); /* |x| <= 1e5 rad */
double tt_cos(double x);

#ifdef __cplusplus
}
#endif
#endif
