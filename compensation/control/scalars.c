/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/scalars.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

static uint64_t bits_of(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

static double of_bits(uint64_t bits) {
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

double tt_nan(void) { return of_bits(UINT64_C(0x7FF8000000000000)); }
int tt_is_nan(double x) { return (bits_of(x) & UINT64_C(0x7FFFFFFFFFFFFFFF)) > UINT64_C(0x7FF0000000000000); }
int tt_is_finite(double x) { return (bits_of(x) & UINT64_C(0x7FF0000000000000)) != UINT64_C(0x7FF0000000000000); }
double tt_min(double a, double b) { return b < a ? b : a; }
double tt_max(double a, double b) { return a < b ? b : a; }
double tt_clamp(double x, double low, double high) { return x < low ? low : high < x ? high : x; }

/* A sum hi + lo with |lo| at most half a unit in the last place of hi. */
typedef struct pair {
  double hi, lo;
} pair;

static pair two_sum(double a, double b) {
  pair r;
  r.hi = a + b;
  const double of_b = r.hi - a;
  r.lo = (a - (r.hi - of_b)) + (b - of_b);
  return r;
}

/* The upper 26 bits; the rest has 26 as well. */
static double upper(double a) {
  const double far = 134217729.0 * a; /* 2^27 + 1 */
  return far - (far - a);
}

static pair two_product(double a, double b) {
  const double a1 = upper(a), a2 = a - a1, b1 = upper(b), b2 = b - b1;
  pair r;
  r.hi = a * b;
  r.lo = a2 * b2 - (((r.hi - a1 * b1) - a2 * b1) - a1 * b2);
  return r;
}

static const double ln2_hi = 0x1.62e42fef8p-1, ln2_lo = 0x1.1cf79abc9e3b4p-36; /* hi: 34 bits */

/* e^(hi + lo) for |lo| far below |hi| or 1. */
static double exp_of(double hi, double lo) {
  if (tt_is_nan(hi)) return hi;
  if (hi > 709.0) return of_bits(UINT64_C(0x7FF0000000000000));
  if (hi < -708.0) return 0.0;
  const double k = floor(hi * 1.4426950408889634 + 0.5);
  const double r = ((hi - k * ln2_hi) - k * ln2_lo) + lo; /* |r| <= 0.35: the term after r^14 / 14! is below 4e-19 */
  static const double inverse[] = {1.0 / 6227020800.0, 1.0 / 479001600.0, 1.0 / 39916800.0, 1.0 / 3628800.0,
                                   1.0 / 362880.0,     1.0 / 40320.0,     1.0 / 5040.0,     1.0 / 720.0,
                                   1.0 / 120.0,        1.0 / 24.0,        1.0 / 6.0,        0.5};
  double sum = 1.0 / 87178291200.0;
  for (int i = 0; i < 12; ++i) sum = sum * r + inverse[i];
  const double value = 1.0 + (r + r * r * sum);
  const uint64_t exponent = 1023 + (int64_t)k;
  return value * of_bits(exponent << 52);
}

double tt_exp(double x) { return exp_of(x, 0.0); }

/* ln x = 2 artanh(s) + k ln 2,   s = (m - 1) / (m + 1),   x = m 2^k,   m from sqrt(1/2) to sqrt(2) */
static pair log_of(double x) {
  uint64_t bits = bits_of(x);
  double k = (int)(bits >> 52) - 1023;
  double m = of_bits((bits & UINT64_C(0x000FFFFFFFFFFFFF)) | UINT64_C(0x3FF0000000000000));
  if (m > 1.4142135623730951) {
    m *= 0.5;
    k += 1.0;
  }
  const double f = m - 1.0;
  const pair d = two_sum(2.0, f);
  const double s = f / d.hi;
  const pair back = two_product(s, d.hi);
  const double s_lo = (((f - back.hi) - back.lo) - s * d.lo) / d.hi;
  const double z = s * s; /* <= 0.0295: the term after z^11 is below 1e-18 */
  double sum = 2.0 / 25.0;
  for (int i = 23; i >= 3; i -= 2) sum = sum * z + 2.0 / i;
  const pair first = two_sum(k * ln2_hi, 2.0 * s);
  const double rest = first.lo + (k * ln2_lo + (2.0 * s_lo + s * z * sum));
  return two_sum(first.hi, rest);
}

double tt_log(double x) {
  if (!(x > 0.0) || !tt_is_finite(x)) return tt_nan();
  const pair l = log_of(x);
  return l.hi + l.lo;
}

double tt_pow(double x, double y) {
  if (x == 0.0 && y > 0.0) return 0.0;
  if (y == 0.0 || x == 1.0) return 1.0;
  if (!(x > 0.0) || !tt_is_finite(x) || !tt_is_finite(y)) return tt_nan();
  const pair l = log_of(x), p = two_product(y, l.hi);
  return exp_of(p.hi, p.lo + y * l.lo);
}

double tt_cbrt(double x) {
  if (x == 0.0 || !tt_is_finite(x)) return x;
  static const double third = 0x1.5555555555555p-2, third_lo = 0x1.5555555555555p-56;
  const pair l = log_of(fabs(x)), p = two_product(third, l.hi);
  const double root = exp_of(p.hi, p.lo + (third * l.lo + third_lo * l.hi));
  return x < 0.0 ? -root : root;
}

/* sin(r) and cos(r) for |r| <= pi / 4 */
static double sin_near(double r) {
  static const double inverse[] = {
      1.0 / 355687428096000.0, -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0,
      1.0 / 362880.0,          -1.0 / 5040.0,          1.0 / 120.0,        -1.0 / 6.0};
  const double z = r * r;
  double sum = 0.0;
  for (int i = 0; i < 8; ++i) sum = sum * z + inverse[i];
  return r + r * z * sum;
}

static double cos_near(double r) {
  static const double inverse[] = {1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0,
                                   1.0 / 40320.0,          -1.0 / 720.0,         1.0 / 24.0};
  const double z = r * r;
  double sum = 0.0;
  for (int i = 0; i < 7; ++i) sum = sum * z + inverse[i];
  const double half = 0.5 * z, one = 1.0 - half;
  return one + ((1.0 - one) - half + z * z * sum);
}

static double turned(double x, int quarter) {
  if (!tt_is_finite(x)) return tt_nan();
  /* pi / 2 in pieces of 33 bits: products with k are exact */
  const double k = floor(x * 0.63661977236758134 + 0.5);
  const double r = ((x - k * 0x1.921fb544p+0) - k * 0x1.0b4611a6p-34) - k * 0x1.3198a2e037073p-69;
  switch ((int)(k - 4.0 * floor(0.25 * k)) + quarter) {
    case 0:
    case 4: return sin_near(r);
    case 1: return cos_near(r);
    case 2: return -sin_near(r);
    default: return -cos_near(r);
  }
}

double tt_sin(double x) { return turned(x, 0); }
double tt_cos(double x) { return turned(x, 1); }
