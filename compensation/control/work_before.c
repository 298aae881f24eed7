/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/work_before.h"

#include <math.h>
#include <stddef.h>

#include "compensation/control/errors.h"
#include "compensation/control/linear.h"
#include "compensation/control/scalars.h"
#include "compensation/control/special.h"

static const double hour = 3600.0;
static const double on_h[tt_past_hours] = {0.5, 2.0, 6.0, 24.0};
static const double idle_h[tt_past_idles] = {0.0, 0.25, 1.0, 3.0, 8.0, 24.0};
static const double start_sizes[tt_past_sizes] = {0.03, 0.1, 0.3, 1.0, 3.0};
static const double unmeasured_start_K = 2.0;
static const double least_pattern = 0.01; /* of the largest pattern */

enum { slice_products = 15000 }; /* multiplications of a slice of offers, about; the rest of an offer is logarithms */
enum { job_none, job_modes, job_left, job_offers, job_gram, job_patterns, job_done, job_failed };
enum { at_job, at_item, at_kind, at_count, at_predicts, at_start, at_shapes, progress_count };
enum { offers = tt_past_idles * tt_past_sizes };
enum { first_idle = 3, leave_parts = first_idle + tt_past_idles }; /* of leave() */
enum { gram_rows = 8, gram_columns = 30 }; /* of a slice: 2 n^2 multiplications where n is 240 */

static int order_of(const tt_past* w) { return w->model->sensors->order; }
static int measured_of(const tt_past* w) { return w->model->sensors->measured; }
static int wide_of(const tt_past* w) { return tt_past_kinds * w->model->heats; }
static int offers_of(const tt_past_model* model) { return offers * (model->heats + 1); }

void tt_past_lay(tt_past* w, const tt_past_model* model, tt_arena* arena) {
  const ptrdiff_t n = model->sensors->order, measured = model->sensors->measured, heats = model->heats;
  const ptrdiff_t columns = tt_past_kinds * heats * tt_past_idles;
  w->model = model;
  w->heats = tt_doubles(arena, n * heats);
  w->left = tt_doubles(arena, n * columns);
  w->seen = tt_doubles(arena, measured * columns);
  w->cooling = tt_doubles(arena, n * n);
  w->cooling_decay = tt_doubles(arena, n);
  w->modes = tt_doubles(arena, n * n);
  w->decay = tt_doubles(arena, n);
  w->eigen_work = tt_doubles(arena, tt_eigen_work(model->sensors->order));
  w->warm = tt_doubles(arena, 3 * n);
  w->modal = tt_doubles(arena, n * tt_past_idles);
  w->eigen_progress = tt_ints(arena, tt_eigen_progress);
  w->sizes = tt_doubles(arena, heats * tt_past_idles);
  w->patterns = tt_doubles(arena, n * tt_most_patterns);
  w->chosen = tt_ints(arena, measured);
  w->values = tt_doubles(arena, 2 * measured);
  w->rest = tt_doubles(arena, measured * measured);
  w->whole = tt_doubles(arena, measured * measured);
  w->alone = tt_doubles(arena, measured * measured);
  w->spread = tt_doubles(arena, measured * measured);
  w->factor = tt_doubles(arena, measured * measured);
  w->offered = tt_doubles(arena, tt_most_starts * offers_of(model));
  w->chances = tt_doubles(arena, tt_most_starts * offers_of(model));
  w->progress = tt_ints(arena, progress_count);
}

void tt_past_set_heats(tt_past* w, const double* heats) { tt_copy(order_of(w) * w->model->heats, heats, w->heats); }

static void begin(tt_past* w, int job) {
  w->progress[at_job] = job;
  w->progress[at_item] = 0;
}

static tt_eigen eigen_job(tt_past* w, int kind) {
  const int cools = kind == TT_MODES_COOLING;
  const tt_eigen job = {order_of(w), cools ? w->cooling : w->modes, cools ? w->cooling_decay : w->decay, w->eigen_work,
                        w->eigen_progress};
  return job;
}

void tt_past_begin_modes(tt_past* w, int kind, const double* operator_matrix) {
  const ptrdiff_t n = order_of(w);
  const tt_eigen job = eigen_job(w, kind);
  for (ptrdiff_t j = 0; j < n; ++j) {
    for (ptrdiff_t i = j; i < n; ++i)
      job.a[i + j * n] = 0.5 * (operator_matrix[i + j * n] + operator_matrix[j + i * n]);
  }
  tt_eigen_begin(&job);
  w->progress[at_kind] = kind;
  begin(w, job_modes);
}

/* What a heat has left some times after the work, from its amounts in modes of the cooling machine. These are read
 * once for all of the times, some modes after the other. */
static void leave_after(tt_past* w, ptrdiff_t column, int first, int last) {
  const tt_sensor_model* m = w->model->sensors;
  const ptrdiff_t n = m->order, wide = wide_of(w), modes = 4;
  const double* warm = w->warm + 2 * n;
  for (int idle = first; idle < last; ++idle) {
    double* modal = w->modal + idle * n;
    for (int k = 0; k < n; ++k)
      modal[k] = warm[k] * tt_exp(-w->cooling_decay[k] * idle_h[idle] * hour) / sqrt(tt_past_kinds);
    tt_zero(n, w->left + (idle * wide + column) * n);
  }
  for (ptrdiff_t j = 0; j < n; j += modes) {
    for (int idle = first; idle < last; ++idle)
      tt_gemv(n, n - j < modes ? n - j : modes, 1.0, w->cooling + j * n, w->modal + idle * n + j,
              w->left + (idle * wide + column) * n);
  }
  for (int idle = first; idle < last; ++idle) {
    const ptrdiff_t at = idle * wide + column;
    tt_zero(m->measured, w->seen + at * m->measured);
    tt_gemv_t(n, m->measured, 1.0, m->sensor_rows, w->left + at * n, w->seen + at * m->measured);
  }
}

/* What one heat leaves after some hours of work, at all times since; in parts of one product with a matrix each. At
 * most so many parts from one on; returns how many it did. */
static int leave(tt_past* w, int heat, int on, int part, int slices) {
  const ptrdiff_t n = order_of(w);
  const int swept = w->progress[at_kind] == TT_MODES_SWEPT;
  const int column = heat * tt_past_kinds + swept * tt_past_hours + on;
  double *modal = w->warm, *state = modal + n, *warm = state + n;
  if (part == 0) {
    tt_zero(n, modal);
    tt_gemv_t(n, n, 1.0, w->modes, w->heats + heat * n, modal);
    for (int k = 0; k < n; ++k) {
      /* (1 - exp(-d t)) / d, also for a part that keeps its heat */
      const double d = w->decay[k], t = on_h[on] * hour;
      modal[k] *= d * t > 1e-9 ? -tt_expm1(-d * t) / d : t;
    }
  } else if (part == 1) {
    tt_zero(n, state);
    tt_gemv(n, n, 1.0, w->modes, modal, state);
  } else if (part == 2) {
    tt_zero(n, warm);
    tt_gemv_t(n, n, 1.0, w->cooling, state, warm);
  } else {
    const int idle = part - first_idle, done = slices < tt_past_idles - idle ? slices : tt_past_idles - idle;
    leave_after(w, column, idle, idle + done);
    return done;
  }
  return 1;
}

/* Standard deviations of readings and of the uniform temperature. */
static void set_rest(tt_past* w, double uniform_K) {
  const int count = w->progress[at_count];
  for (int i = 0; i < count * count; ++i) w->rest[i] = uniform_K * uniform_K;
  for (int i = 0; i < count; ++i) {
    const double own = w->model->sensors->sensor_std[w->chosen[i]], noise = tt_reading_std(own, w->values[i]);
    w->rest[i + i * count] += own * own + noise * noise;
  }
}

void tt_past_begin_offers(tt_past* w, const tt_first_readings* readings, int predicts, int start) {
  w->progress[at_count] = readings->count;
  w->progress[at_predicts] = predicts;
  w->progress[at_start] = start;
  for (int i = 0; i < readings->count; ++i) {
    w->chosen[i] = readings->sensor[i];
    w->values[i] = readings->value_K[i] - readings->zero_K;
  }
  set_rest(w, readings->uniform_K);
  begin(w, job_offers);
}

/* matrix += S S^T over some columns of what the chosen sensors see. */
static void add_spread(const tt_past* w, ptrdiff_t first, int columns, double* matrix) {
  const int count = w->progress[at_count], measured = measured_of(w);
  for (int c = 0; c < columns; ++c) {
    const double* seen = w->seen + (first + c) * measured;
    for (int j = 0; j < count; ++j) {
      const double own = seen[w->chosen[j]];
      for (int i = 0; i < count; ++i) matrix[i + j * count] += seen[w->chosen[i]] * own;
    }
  }
}

/* One covariance of the readings: its evidence and, where the last reading is judged, that one's probability. */
static void offer(tt_past* w, double log_prior, double* offered, double* chance) {
  const int all = w->progress[at_count], predicts = w->progress[at_predicts], count = all - predicts;
  double *solved = w->values + measured_of(w), log_size = 0.0;
  for (int j = 0; j < count; ++j) tt_copy(count, w->spread + j * all, w->factor + j * count);
  tt_cholesky_columns(count, w->factor, 0, count);
  for (int j = 0; j < count; ++j) log_size += tt_log(w->factor[j + j * count]);
  tt_copy(count, w->values, solved);
  tt_cholesky_solve(count, w->factor, solved);
  *offered = log_prior - 0.5 * tt_dot(count, w->values, solved) - log_size;
  if (!predicts) return;
  const double* with_others = w->spread + (all - 1) * all;
  tt_copy(count, with_others, solved);
  tt_cholesky_solve(count, w->factor, solved);
  const double variance = with_others[all - 1] - tt_dot(count, with_others, solved);
  const double off = fabs(w->values[all - 1] - tt_dot(count, solved, w->values));
  *chance = tt_erfc(off / sqrt(2.0 * tt_max(variance, 1e-12)));
}

/* All heats alike (heat -1) or one alone, in each size. */
static void offer_heat(tt_past* w, int idle, int heat) {
  const int heats = w->model->heats, entries = w->progress[at_count] * w->progress[at_count];
  const ptrdiff_t wide = wide_of(w), first = idle * wide;
  const int place = w->progress[at_start] * offers_of(w->model) + (idle * (heats + 1) + heat + 1) * tt_past_sizes;
  double* own = w->alone;
  if (heat < 0) {
    tt_zero(entries, w->whole);
    add_spread(w, first, wide_of(w), w->whole);
  } else {
    tt_zero(entries, own);
    add_spread(w, first + heat * tt_past_kinds, tt_past_kinds, own);
  }
  const double log_prior = heat < 0 ? 0.0 : -tt_log(heats);
  for (int size = 0; size < tt_past_sizes; ++size) {
    const double square = start_sizes[size] * start_sizes[size], least = start_sizes[0] * start_sizes[0];
    for (int i = 0; i < entries; ++i)
      w->spread[i] = heat < 0 ? w->rest[i] + square * w->whole[i] : w->rest[i] + square * own[i] + least * w->whole[i];
    offer(w, log_prior, w->offered + place + size, w->chances + place + size);
  }
}

static int items_of_offers(const tt_past_model* model) {
  const int count = model->sensors->measured;
  const int items = slice_products / (tt_past_sizes * (count * count * count / 6 + 4 * count * count + 200));
  return items < 1 ? 1 : items;
}

void tt_past_begin_patterns(tt_past* w) { begin(w, job_gram); }

static int columns_of(const tt_past_model* model) { return tt_past_kinds * model->heats * tt_past_idles; }

static int in_parts(int size, int of) { return (size + of - 1) / of; }

static int gram_parts(const tt_past_model* model) { return in_parts(columns_of(model), gram_columns); }

static int gram_slices(const tt_past_model* model) {
  return in_parts(model->sensors->order, gram_rows) * gram_parts(model);
}

/* sum_c size_c^2 l_c l_c^T, whose eigenvectors are the left singular vectors of the columns size_c l_c: some of its
 * columns, below the diagonal, from some of the columns l_c. */
static void gram_slice(tt_past* w, int item) {
  const ptrdiff_t n = order_of(w), wide = wide_of(w), parts = gram_parts(w->model);
  const ptrdiff_t first = item / parts * gram_rows, end = first + gram_rows < n ? first + gram_rows : n;
  const ptrdiff_t from = item % parts * gram_columns, all = columns_of(w->model);
  const ptrdiff_t to = from + gram_columns < all ? from + gram_columns : all;
  for (ptrdiff_t j = first; j < end && from == 0; ++j) tt_zero(n, w->modes + j * n);
  for (ptrdiff_t c = from; c < to; ++c) {
    const double size = w->sizes[c % wide / tt_past_kinds + c / wide * w->model->heats], *left = w->left + c * n;
    for (ptrdiff_t j = first; j < end; ++j) tt_axpy(n - j, size * size * left[j], left + j, w->modes + j * n + j);
  }
}

static void keep_patterns(tt_past* w) {
  const ptrdiff_t n = order_of(w);
  const double largest = w->decay[n - 1];
  int kept = 0;
  for (; kept < tt_most_patterns && kept < n; ++kept) {
    const double square = w->decay[n - 1 - kept];
    if (!(square > least_pattern * least_pattern * largest)) break;
    const double* mode = w->modes + (n - 1 - kept) * n;
    for (int i = 0; i < n; ++i) w->patterns[i + kept * n] = mode[i] * sqrt(square);
  }
  w->progress[at_shapes] = kept;
}

int tt_past_shapes(const tt_past* w) { return w->progress[at_shapes]; }

static int leave_slices(const tt_past_model* model) { return leave_parts * tt_past_hours * model->heats; }

static int offer_slices(const tt_past_model* model) {
  return in_parts(tt_past_idles * (model->heats + 1), items_of_offers(model));
}

int tt_past_slices(const tt_past_model* model) {
  const int kinds = TT_MODES_SWEPT + 1, own = tt_eigen_slices(model->sensors->order) + 1;
  const int weighed = 2 * tt_most_starts + model->sensors->measured * tt_most_starts + 1;
  return (kinds + 1) * own + (kinds - 1) * leave_slices(model) + gram_slices(model) + weighed * offer_slices(model);
}

static void slice_of_modes(tt_past* w) {
  const int n = order_of(w), kind = w->progress[at_kind], patterns = w->progress[at_job] == job_patterns;
  const tt_eigen job = eigen_job(w, patterns ? TT_MODES_STILL : kind);
  const int state = tt_eigen_slice(&job);
  if (state == 2) w->progress[at_job] = job_failed;
  if (state != 1) return;
  if (patterns) {
    keep_patterns(w);
    w->progress[at_job] = job_done;
    return;
  }
  for (int k = 0; k < n; ++k) job.values[k] = tt_max(job.values[k], 0.0);
  begin(w, kind == TT_MODES_COOLING ? job_done : job_left);
}

static void slice_of_offers(tt_past* w) {
  const int heats = w->model->heats + 1;
  int* item = &w->progress[at_item];
  for (int k = items_of_offers(w->model); k > 0 && *item < tt_past_idles * heats; --k, ++*item)
    offer_heat(w, *item / heats, *item % heats - 1);
  if (*item == tt_past_idles * heats) w->progress[at_job] = job_done;
}

int tt_past_work(tt_past* w, int* slices) {
  int *job = &w->progress[at_job], *item = &w->progress[at_item];
  const int each = leave_parts * tt_past_hours, most = *slices;
  *slices = 1;
  switch (*job) {
    case job_modes:
    case job_patterns: slice_of_modes(w); break;
    case job_left:
      if (*item < leave_slices(w->model))
        *slices = leave(w, *item / each, *item % each / leave_parts, *item % leave_parts, most);
      *item += *slices;
      if (*item >= leave_slices(w->model)) *job = job_done;
      break;
    case job_offers: slice_of_offers(w); break;
    case job_gram:
      gram_slice(w, (*item)++);
      if (*item == gram_slices(w->model)) {
        const tt_eigen eigen = eigen_job(w, TT_MODES_STILL);
        tt_eigen_begin(&eigen);
        *job = job_patterns;
      }
      break;
    default: break;
  }
  return *job == job_done ? 1 : *job == job_failed ? 2 : 0;
}

int tt_past_slice(tt_past* w) {
  int one = 1;
  return tt_past_work(w, &one);
}

double tt_past_weigh(tt_past* w) {
  const int heats = w->model->heats, all = offers_of(w->model);
  double best = -HUGE_VAL, sum = 0.0;
  for (int i = 0; i < all; ++i) best = tt_max(best, w->offered[i]);
  /* Mean squares over all that was offered are what columns of one heat and time stand for. */
  tt_zero(heats * tt_past_idles, w->sizes);
  for (int i = 0; i < all; ++i) {
    const int size = i % tt_past_sizes, heat = i / tt_past_sizes % (heats + 1) - 1;
    const double weight = tt_exp(w->offered[i] - best), least = start_sizes[0] * start_sizes[0];
    const double square = weight * start_sizes[size] * start_sizes[size];
    double* column = w->sizes + i / tt_past_sizes / (heats + 1) * heats;
    sum += weight;
    for (int k = 0; k < heats; ++k) column[k] += heat < 0 ? square : weight * least;
    if (heat >= 0) column[heat] += square;
  }
  for (int i = 0; i < heats * tt_past_idles; ++i) w->sizes[i] = sqrt(w->sizes[i] / sum);
  return best + tt_log(sum);
}

void tt_past_unmeasured(tt_past* w) {
  const int heats = w->model->heats, measured = measured_of(w);
  const double square =
      tt_dot(measured * wide_of(w) * tt_past_idles, w->seen, w->seen) / tt_past_idles / tt_max(1.0, measured);
  const double size = square > 0.0 ? tt_min(1.0, unmeasured_start_K / sqrt(square)) : 1.0;
  for (int i = 0; i < heats * tt_past_idles; ++i) w->sizes[i] = size / sqrt(tt_past_idles);
}

double tt_past_chance(const tt_past* w, int starts) {
  const int all = starts * offers_of(w->model);
  double best = -HUGE_VAL, sum = 0.0, chance = 0.0;
  for (int i = 0; i < all; ++i) best = tt_max(best, w->offered[i]);
  for (int i = 0; i < all; ++i) {
    const double weight = tt_exp(w->offered[i] - best);
    sum += weight;
    chance += weight * w->chances[i];
  }
  return chance / sum;
}
