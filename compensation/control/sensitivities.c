/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/sensitivities.h"

#include <stddef.h>

#include "compensation/control/linear.h"

enum { slice_products = 60000 }; /* multiplications of a slice, about */
enum { stage_idle, stage_wait, stage_factor, stage_rates, stage_solve, stage_done, stage_failed };
enum { at_stage, at_item, at_quantity, at_foresight, progress_count };
enum { job_duration, factor_duration, number_count };

int tt_first_start(const tt_sensor_model* model) { return model->quantities + model->drives; }
int tt_columns(const tt_sensor_model* model) { return tt_first_start(model) + tt_start_modes; }

static int largest_rank(const tt_sensor_model* m) {
  int most = 0;
  for (int t = 0; t < m->terms; ++t) {
    const int rank = m->term_first[t + 1] - m->term_first[t];
    if (rank > most) most = rank;
  }
  return most;
}

void tt_sensitivities_lay(tt_sensitivities* s, const tt_sensor_model* model, tt_arena* arena) {
  const ptrdiff_t n = model->order, columns = tt_columns(model), sensors = model->sensors;
  s->model = model;
  s->directions = tt_doubles(arena, n * columns);
  s->next = tt_doubles(arena, n * columns);
  s->start_rate = tt_doubles(arena, n * tt_start_modes);
  s->seen = tt_doubles(arena, columns * sensors);
  s->seen_last = tt_doubles(arena, columns * sensors);
  s->seen_next = tt_doubles(arena, columns * sensors);
  s->seen_rate = tt_doubles(arena, columns * sensors);
  s->heat = tt_doubles(arena, n * model->drives);
  s->heat_seen = tt_doubles(arena, sensors * model->drives);
  s->unrecorded = tt_ints(arena, model->drives);
  s->drive_known = tt_ints(arena, model->drives);
  s->p = tt_doubles(arena, model->terms);
  s->q = tt_doubles(arena, model->inputs);
  s->state = tt_doubles(arena, n);
  s->scratch = tt_doubles(arena, largest_rank(model));
  s->factor = tt_doubles(arena, n * n);
  s->factor_p = tt_doubles(arena, model->terms);
  s->pivots = tt_ints(arena, n);
  s->numbers = tt_doubles(arena, number_count);
  s->progress = tt_ints(arena, progress_count);
}

/* (columns x sensors) H times (order x columns), one column. */
static void see(const tt_sensor_model* m, const double* directions, ptrdiff_t column, double* seen) {
  const double* own = directions + column * m->order;
  for (ptrdiff_t i = 0; i < m->sensors; ++i)
    seen[i * tt_columns(m) + column] = tt_dot(m->order, m->sensor_rows + i * m->order, own);
}

void tt_sensitivities_start(tt_sensitivities* s, int shapes, const double* patterns) {
  const tt_sensor_model* m = s->model;
  const ptrdiff_t n = m->order, columns = tt_columns(m), first = tt_first_start(m);
  tt_zero(n * columns, s->directions);
  tt_copy(n, m->one_kelvin, s->directions + first * n);
  tt_copy(n * shapes, patterns, s->directions + (first + 1) * n);
  tt_zero(columns * m->sensors, s->seen);
  for (ptrdiff_t k = first; k <= first + shapes; ++k) see(m, s->directions, k, s->seen);
  tt_copy(columns * m->sensors, s->seen, s->seen_last);
  tt_zero(n * tt_start_modes, s->start_rate);
  tt_zero(columns * m->sensors, s->seen_rate);
  s->numbers[factor_duration] = 0.0;
  s->progress[at_stage] = stage_idle;
}

void tt_sensitivities_set_heat(tt_sensitivities* s, int drive, const double* heat) {
  const tt_sensor_model* m = s->model;
  const ptrdiff_t n = m->order, sensors = m->sensors;
  s->unrecorded[drive] = heat != NULL;
  if (heat == NULL) return;
  s->drive_known[drive] = 1;
  tt_copy(n, heat, s->heat + drive * n);
  double* seen = s->heat_seen + drive * sensors;
  tt_zero(sensors, seen);
  tt_gemv_t(n, sensors, 1.0, m->sensor_rows, heat, seen);
}

/* The matrix 1 + h A, in place of the factor; the slices factorise it. */
static void set_matrix(tt_sensitivities* s, double duration, const double* operator_matrix) {
  const ptrdiff_t n = s->model->order;
  for (ptrdiff_t i = 0; i < n * n; ++i) s->factor[i] = duration * operator_matrix[i];
  for (ptrdiff_t i = 0; i < n; ++i) s->factor[i + i * n] += 1.0;
}

static int same(int n, const double* a, const double* b) {
  for (int i = 0; i < n; ++i) {
    if (a[i] != b[i]) return 0;
  }
  return 1;
}

void tt_sensitivities_begin(tt_sensitivities* s, const tt_interval* interval, const double* theta) {
  const tt_sensor_model* m = s->model;
  const double h = interval->duration;
  tt_copy(m->terms, interval->p, s->p);
  tt_copy(m->inputs, interval->q, s->q);
  /* The true state is nearer to the corrected one than to the nominal one. */
  tt_copy(m->order, interval->state, s->state);
  tt_gemv(m->order, tt_columns(m), 1.0, s->directions, theta, s->state);
  tt_copy(m->order * tt_columns(m), s->directions, s->next);
  s->numbers[job_duration] = h;
  s->progress[at_item] = s->progress[at_quantity] = s->progress[at_foresight] = 0;
  if (s->numbers[factor_duration] == h && same(m->terms, s->factor_p, s->p)) {
    s->progress[at_stage] = stage_rates;
    return;
  }
  tt_copy(m->terms, s->p, s->factor_p);
  s->numbers[factor_duration] = 0.0; /* until it is whole */
  s->progress[at_stage] = stage_wait;
  if (interval->operator_matrix) tt_sensitivities_set_operator(s, interval->operator_matrix);
}

void tt_sensitivities_set_operator(tt_sensitivities* s, const double* operator_matrix) {
  if (s->progress[at_stage] != stage_wait) return;
  set_matrix(s, s->numbers[job_duration], operator_matrix);
  s->progress[at_stage] = stage_factor;
}

void tt_sensitivities_begin_foresight(tt_sensitivities* s, double duration, const double* operator_matrix) {
  const tt_sensor_model* m = s->model;
  const ptrdiff_t n = m->order, first = tt_first_start(m) * n;
  tt_copy(n * tt_start_modes, s->directions + first, s->next + first);
  set_matrix(s, duration, operator_matrix);
  s->numbers[job_duration] = duration;
  s->numbers[factor_duration] = 0.0;
  s->progress[at_item] = s->progress[at_quantity] = 0;
  s->progress[at_foresight] = 1;
  s->progress[at_stage] = stage_factor;
}

static int items_of_a_slice(const tt_sensor_model* m) {
  const int items = slice_products / (m->order * m->order + 1);
  return items < 1 ? 1 : items;
}

/* Items of the solution: the exchange of all rows, the elimination by each column of the factor, the substitution by
 * each from the last on, and what the sensors see of each column. A slice takes items of one of these four kinds. */
static int solve_items(const tt_sensor_model* m, int columns) { return 1 + 2 * m->order + columns; }

static int kind_end(const tt_sensor_model* m, int columns, int item) {
  const int n = m->order;
  return item == 0 ? 1 : item <= n ? n + 1 : item <= 2 * n ? 2 * n + 1 : solve_items(m, columns);
}

static ptrdiff_t products_of(const tt_sensor_model* m, ptrdiff_t columns, ptrdiff_t item) {
  const ptrdiff_t n = m->order;
  if (item == 0) return columns * n;
  if (item <= n) return columns * (n - item + 1);
  if (item <= 2 * n) return columns * (2 * n - item + 1);
  return m->sensors * n;
}

/* First item behind a slice. */
static int slice_end(const tt_sensor_model* m, int columns, int item) {
  const int last = kind_end(m, columns, item);
  ptrdiff_t products = 0;
  do products += products_of(m, columns, item++);
  while (item < last && products < slice_products);
  return item;
}

int tt_sensitivities_slices(const tt_sensor_model* m) {
  const int each = items_of_a_slice(m), terms = m->quantity_term_first[m->quantities];
  const ptrdiff_t n = m->order, columns = tt_columns(m);
  /* Each slice of the solution but the last of its kind has at least its products. */
  const ptrdiff_t solve =
      1 + 2 * (1 + columns * n * (n + 1) / 2 / slice_products) + (1 + columns * m->sensors * n / slice_products);
  return (m->order + each - 1) / each + (terms + 1 + each - 1) / each + (int)solve;
}

static void add_input(tt_sensitivities* s, ptrdiff_t input, double amount, double* column) {
  const tt_sensor_model* m = s->model;
  if (amount != 0.0) tt_axpy(m->order, amount, m->input_columns + input * m->order, column);
}

/* column += h d(rate)/dtheta of one term: -p K x, and what the term's own inputs bring. */
static void add_term(tt_sensitivities* s, int term, double* column) {
  const tt_sensor_model* m = s->model;
  const ptrdiff_t n = m->order, first = m->term_first[term], rank = m->term_first[term + 1] - first,
                  right = m->term_right_first[term];
  const double h = s->numbers[job_duration], p = s->p[term];
  if (p == 0.0) return;
  const double* left = m->term_left + first * n;
  tt_zero(rank, s->scratch);
  tt_gemv_t(n, rank, 1.0, right < 0 ? left : m->term_right + right * n, s->state, s->scratch);
  for (int c = 0; c < rank; ++c) s->scratch[c] *= m->term_weight[first + c];
  tt_gemv(n, rank, -h * p, left, s->scratch, column);
  for (int input = 0; input < m->inputs; ++input) {
    if (m->input_term[input] == term) add_input(s, input, h * s->q[input], column);
  }
}

/* What scales with no term: sources, surroundings, drives. */
static void add_heats(tt_sensitivities* s) {
  const tt_sensor_model* m = s->model;
  const ptrdiff_t n = m->order;
  const double h = s->numbers[job_duration];
  for (int k = 0; k < m->quantities; ++k) {
    double* column = s->next + k * n;
    for (int i = m->quantity_input_first[k]; i < m->quantity_input_first[k + 1]; ++i)
      add_input(s, m->quantity_input[i], h * s->q[m->quantity_input[i]], column);
    for (int i = m->quantity_warm_first[k]; i < m->quantity_warm_first[k + 1]; ++i)
      add_input(s, m->quantity_warm[i], h * s->p[m->input_term[m->quantity_warm[i]]], column);
  }
  for (int d = 0; d < m->drives; ++d) {
    if (s->unrecorded[d]) tt_axpy(n, h, s->heat + d * n, s->next + (m->quantities + d) * n);
  }
}

/* Each returns 1 after the last item. */
static int factorise(tt_sensitivities* s, int items) {
  const int n = s->model->order, first = s->progress[at_item];
  const int last = first + items < n ? first + items : n;
  if (tt_lu_columns(n, s->factor, s->pivots, first, last) != 0) {
    s->progress[at_stage] = stage_failed;
    return 0;
  }
  s->progress[at_item] = last;
  return last == n;
}

static int add_rates(tt_sensitivities* s, int items) {
  const tt_sensor_model* m = s->model;
  const ptrdiff_t n = m->order;
  const int terms = m->quantity_term_first[m->quantities];
  int *item = &s->progress[at_item], *quantity = &s->progress[at_quantity];
  for (; items > 0; --items, ++*item) {
    if (*item == terms) {
      add_heats(s);
      return 1;
    }
    while (*item >= m->quantity_term_first[*quantity + 1]) ++*quantity;
    add_term(s, m->quantity_term[*item], s->next + *quantity * n);
  }
  return 0;
}

/* At most so many slices of one kind. All columns pass once, by the few columns of the factor that these slices need:
 * together they are less to read than the factor. Returns whether it was the last; slices: then as many as it did. */
static int solve(tt_sensitivities* s, int* slices) {
  const tt_sensor_model* m = s->model;
  const int n = m->order, first = s->progress[at_foresight] ? tt_first_start(m) : 0, columns = tt_columns(m) - first;
  const int begin = s->progress[at_item], last = kind_end(m, columns, begin);
  int end = begin, done = 0;
  while (end < last && done < *slices) {
    end = slice_end(m, columns, end);
    ++done;
  }
  if (begin > 2 * n) {
    for (int item = begin; item < end; ++item) see(m, s->next, first + item - 2 * n - 1, s->seen_next);
  } else {
    for (ptrdiff_t k = first; k < first + columns; ++k) {
      double* x = s->next + k * n;
      if (begin == 0)
        tt_lu_exchange(n, s->pivots, x);
      else if (begin <= n)
        tt_lu_eliminate(n, s->factor, begin - 1, end - 1, x);
      else
        tt_lu_substitute(n, s->factor, 2 * n + 1 - end, 2 * n + 1 - begin, x);
    }
  }
  *slices = done;
  s->progress[at_item] = end;
  return end == solve_items(m, columns);
}

int tt_sensitivities_work(tt_sensitivities* s, int* slices) {
  const int each = items_of_a_slice(s->model), items = *slices * each, before = s->progress[at_item];
  int *stage = &s->progress[at_stage], *item = &s->progress[at_item], done = 1;
  if (*stage == stage_factor) {
    const int ended = factorise(s, items), foresight = s->progress[at_foresight];
    done = *item - before;
    if (ended) {
      if (!foresight) s->numbers[factor_duration] = s->numbers[job_duration];
      *item = 0;
      *stage = foresight ? stage_solve : stage_rates;
    }
  } else if (*stage == stage_rates) {
    const int ended = add_rates(s, items);
    done = *item - before + ended;
    if (ended) {
      *item = 0;
      *stage = stage_solve;
    }
  } else if (*stage == stage_solve) {
    if (solve(s, slices)) *stage = stage_done;
    return *stage == stage_done;
  }
  *slices = done > each ? (done + each - 1) / each : 1;
  return *stage == stage_done ? 1 : *stage == stage_failed ? 2 : 0;
}

int tt_sensitivities_slice(tt_sensitivities* s) {
  int one = 1;
  return tt_sensitivities_work(s, &one);
}

double tt_sensitivities_duration(const tt_sensitivities* s) { return s->numbers[job_duration]; }

static void finish_foresight(tt_sensitivities* s, double h) {
  const tt_sensor_model* m = s->model;
  const ptrdiff_t n = m->order, columns = tt_columns(m), start = tt_first_start(m), first = start * n;
  for (ptrdiff_t i = 0; i < n * tt_start_modes; ++i)
    s->start_rate[i] = (s->next[first + i] - s->directions[first + i]) / h;
  for (int sensor = 0; sensor < m->sensors; ++sensor) {
    for (ptrdiff_t k = start; k < columns; ++k)
      s->seen_rate[sensor * columns + k] = tt_dot(n, m->sensor_rows + sensor * n, s->start_rate + (k - start) * n);
  }
}

void tt_sensitivities_finish(tt_sensitivities* s) {
  const tt_sensor_model* m = s->model;
  const ptrdiff_t columns = tt_columns(m), n = m->order, first = tt_first_start(m) * n;
  const double h = s->numbers[job_duration];
  if (s->progress[at_stage] != stage_done) return;
  s->progress[at_stage] = stage_idle;
  if (s->progress[at_foresight]) {
    finish_foresight(s, h);
    return;
  }
  for (ptrdiff_t i = 0; i < n * tt_start_modes; ++i)
    s->start_rate[i] = s->next[first + i] / h - s->directions[first + i] / h;
  tt_copy(n * columns, s->next, s->directions);
  tt_copy(columns * m->sensors, s->seen, s->seen_last);
  tt_copy(columns * m->sensors, s->seen_next, s->seen);
  for (ptrdiff_t i = 0; i < columns * m->sensors; ++i) s->seen_rate[i] = (s->seen[i] - s->seen_last[i]) / h;
}
