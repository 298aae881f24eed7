/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/stepper.h"

#include "compensation/control/linear.h"
#include "compensation/control/outputs.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

#define TT_GAMMA 0.29289321881345254 /* 1 - 1 / sqrt(2) */
enum { slice_work = 60000 };         /* products and sums of a slice: about 20 us */

static int triangle_size(int n) { return n * (n + 1) / 2; }
static int columns_of(const tt_model* m, int t) { return m->term_first[t + 1] - m->term_first[t]; }

static int right_columns(const tt_model* m) {
  int columns = 0;
  for (int t = 0; t < m->terms; ++t) columns += m->term_right_first[t] >= 0 ? columns_of(m, t) : 0;
  return columns;
}

static int symmetric_count(const tt_model* m) {
  int count = 0;
  for (int t = 0; t < m->terms; ++t) count += m->term_right_first[t] < 0;
  return count;
}

tt_work tt_work_in(tt_arena* arena, const tt_model* m) {
  tt_work w = {0};
  const ptrdiff_t n = m->order, outputs = tt_output_count(m), triangle = triangle_size(m->order),
                  symmetric = symmetric_count(m);
  w.triangles = tt_floats(arena, triangle * symmetric);
  w.triangle = tt_doubles(arena, triangle);
  w.matrix = tt_doubles(arena, n * n);
  w.factor_p = tt_doubles(arena, m->terms);
  w.stage = tt_doubles(arena, n);
  w.right = tt_doubles(arena, n);
  w.heat = tt_doubles(arena, n);
  w.difference = tt_doubles(arena, n);
  w.corrected = tt_doubles(arena, n);
  w.corrected_change = tt_doubles(arena, n);
  w.operator_matrix = tt_doubles(arena, m->observer ? n * n : 0);
  w.next_sensors = tt_doubles(arena, m->readings);
  w.next_base = tt_doubles(arena, outputs);
  w.next_slope = tt_doubles(arena, outputs);
  w.scratch = tt_doubles(arena, m->tool_poses + m->table_poses);
  w.symmetric = tt_ints(arena, symmetric);
  w.pivots = tt_ints(arena, n);
  w.lu_first = tt_ints(arena, n + 1);
  return w;
}

/* triangle += factor u u^T */
static void add_square(ptrdiff_t n, double factor, const double* u, double* triangle) {
  for (int j = 0; j < n; ++j) {
    tt_axpy(n - j, factor * u[j], u + j, triangle);
    triangle += n - j;
  }
}

static int is_symmetric(ptrdiff_t n, const double* a) {
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < j; ++i) {
      if (a[i + j * n] != a[j + i * n]) return 0;
    }
  }
  return 1;
}

/* Columns of the factor a slice: column j costs about j n - j^2 / 2. */
static void plan_factor(int n, tt_work* w) {
  const double rows = n;
  double work = 0.0;
  w->lu_slices = 0;
  w->lu_first[0] = 0;
  for (int j = 0; j < n; ++j) {
    work += j * rows - 0.5 * j * j + rows;
    if (work < slice_work && j + 1 < n) continue;
    w->lu_first[++w->lu_slices] = j + 1;
    work = 0.0;
  }
}

static int terms_a_slice(int n) {
  const int terms = slice_work / (2 * triangle_size(n)); /* from memory, where factors come from a cache */
  return terms > 1 ? terms : 1;
}

static int flows_a_slice(int n) {
  const int columns = slice_work / (n * n);
  return columns > 1 ? columns : 1;
}

static int rows_a_slice(int n) {
  const int rows = slice_work / (2 * n);
  return rows > 1 ? rows : 1;
}

static int parts(int count, int size) { return (count + size - 1) / size; }

void tt_work_prepare(const tt_model* m, tt_work* w) {
  const ptrdiff_t n = m->order, triangle = triangle_size(m->order);
  w->symmetric_terms = 0;
  for (int t = 0; t < m->terms; ++t) {
    if (m->term_right_first[t] >= 0) continue;
    float* own = w->triangles + w->symmetric_terms * triangle;
    tt_zero(triangle, w->triangle);
    for (int c = m->term_first[t]; c < m->term_first[t + 1]; ++c)
      add_square(n, m->term_weight[c], m->term_left + c * n, w->triangle);
    for (int i = 0; i < triangle; ++i) own[i] = (float)w->triangle[i];
    w->symmetric[w->symmetric_terms++] = t;
  }
  w->constant_symmetric = is_symmetric(n, m->conduction);
  plan_factor(m->order, w);
  w->sum_slices = w->symmetric_terms > 0 ? parts(w->symmetric_terms, terms_a_slice(m->order)) : 1;
  w->flow_slices = parts(right_columns(m), flows_a_slice(m->order));
  w->project_slices = parts(tt_output_count(m), rows_a_slice(m->order));
  w->factor_step = 0.0;
}

int tt_slices(const tt_work* w) { return w->sum_slices + 1 + w->flow_slices + w->lu_slices + 3 + w->project_slices; }

static void add_term(ptrdiff_t size, double amount, const float* restrict term, double* restrict triangle) {
  for (ptrdiff_t i = 0; i < size; ++i) triangle[i] += amount * term[i];
}

static void sum_terms(const tt_model* m, tt_work* w, const double* p, int slice) {
  const ptrdiff_t n = m->order, size = triangle_size(m->order);
  const int each = terms_a_slice(m->order);
  if (slice == 0) {
    double* to = w->triangle;
    for (int j = 0; j < n; ++j, to += n - j + 1) tt_copy(n - j, m->conduction + j * n + j, to);
  }
  for (int k = slice * each; k < (slice + 1) * each && k < w->symmetric_terms; ++k) {
    const double amount = p[w->symmetric[k]];
    if (amount != 0.0) add_term(size, amount, w->triangles + k * size, w->triangle);
  }
}

/* matrix = diagonal + scale times the sum of the terms so far */
static void build_matrix(const tt_model* m, const tt_work* w, double diagonal, double scale, double* matrix) {
  const ptrdiff_t n = m->order;
  const double* from = w->triangle;
  for (int j = 0; j < n; ++j) {
    double* column = matrix + j * n;
    for (int i = j; i < n; ++i) column[i] = scale * *from++;
    column[j] += diagonal;
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < j; ++i) {
      const double* k = m->conduction;
      const double beside = w->constant_symmetric ? 0.0 : k[i + j * n] - k[j + i * n];
      matrix[i + j * n] = matrix[j + i * n] + scale * beside;
    }
  }
}

static void add_flows(const tt_model* m, double scale, const double* p, int slice, double* matrix) {
  const ptrdiff_t n = m->order;
  const int each = flows_a_slice(m->order), first = slice * each, last = first + each;
  int column = 0;
  for (int t = 0; t < m->terms; ++t) {
    if (m->term_right_first[t] < 0) continue;
    for (int c = 0; c < columns_of(m, t); ++c, ++column) {
      if (column < first || column >= last || p[t] == 0.0) continue;
      const double *u = m->term_left + (m->term_first[t] + c) * n,
                   *v = m->term_right + (m->term_right_first[t] + c) * n;
      for (int j = 0; j < n; ++j) tt_axpy(n, scale * p[t] * v[j], u, matrix + j * n);
    }
  }
}

static void first_stage(const tt_model* m, tt_work* w, double scale, const double* q, const double* state) {
  const int n = m->order;
  tt_zero(n, w->heat);
  tt_gemv(n, m->inputs, 1.0, m->input_columns, q, w->heat);
  for (int i = 0; i < n; ++i) w->stage[i] = state[i] + scale * w->heat[i];
  tt_lu_solve(n, w->matrix, w->pivots, w->stage);
}

static int second_stage(const tt_model* m, tt_work* w, double scale, const double* state) {
  const int n = m->order;
  static const double share = (1.0 - TT_GAMMA) / TT_GAMMA;
  for (int i = 0; i < n; ++i) w->stage[i] = state[i] + share * (w->stage[i] - state[i]) + scale * w->heat[i];
  tt_lu_solve(n, w->matrix, w->pivots, w->stage);
  for (int i = 0; i < n; ++i) {
    if (!tt_is_finite(w->stage[i])) return 1;
    w->difference[i] = w->stage[i] - state[i];
  }
  return 0;
}

static int same(int n, const double* a, const double* b) {
  for (int i = 0; i < n; ++i) {
    if (a[i] != b[i]) return 0;
  }
  return 1;
}

/* The slices that make the factor. */
static int factor_slice(const tt_model* m, tt_work* w, double step_s, const double* p, int slice) {
  const int n = m->order, of_factor = w->sum_slices + 1 + w->flow_slices;
  const double scale = TT_GAMMA * step_s;
  if (slice == 0) {
    /* Nothing to do while coefficients stand; the slices stay counted, so that times do not depend on it. */
    if (w->factor_step == step_s && same(m->terms, p, w->factor_p)) return 0;
    w->factor_step = 0.0;
  }
  if (w->factor_step > 0.0) return 0;
  if (slice < w->sum_slices) {
    sum_terms(m, w, p, slice);
  } else if (slice == w->sum_slices) {
    build_matrix(m, w, 1.0, scale, w->matrix);
  } else if (slice < of_factor) {
    add_flows(m, scale, p, slice - w->sum_slices - 1, w->matrix);
  } else {
    const int k = slice - of_factor;
    if (tt_lu_columns(n, w->matrix, w->pivots, w->lu_first[k], w->lu_first[k + 1])) return 1;
    if (k + 1 < w->lu_slices) return 0;
    tt_copy(m->terms, p, w->factor_p);
    w->factor_step = step_s;
  }
  return 0;
}

static void correct(const tt_model* m, tt_work* w, const tt_step* step) {
  tt_copy(m->order, w->stage, w->corrected);
  tt_copy(m->order, w->difference, w->corrected_change);
  if (!step->correction) return;
  for (int i = 0; i < m->order; ++i) {
    w->corrected[i] += step->correction[i] + step->since * step->rate[i];
    w->corrected_change[i] += step->step_s * step->rate[i];
  }
}

int tt_slice(const tt_model* m, tt_work* w, const tt_step* step, int slice) {
  const int n = m->order, of_stages = w->sum_slices + 1 + w->flow_slices + w->lu_slices;
  const double scale = TT_GAMMA * step->step_s;
  if (slice < of_stages) return factor_slice(m, w, step->step_s, step->p, slice);
  switch (slice - of_stages) {
    case 0: first_stage(m, w, scale, step->q, step->state); return 0;
    case 1: return second_stage(m, w, scale, step->state);
    case 2:
      tt_zero(m->readings, w->next_sensors);
      tt_gemv_t(n, m->readings, 1.0, m->sensor_rows, w->stage, w->next_sensors);
      correct(m, w, step);
      return 0;
    default: tt_project_slice(m, w, w->corrected, w->corrected_change, slice - of_stages - 3); return 0;
  }
}

int tt_operator_slices(const tt_work* w) { return w->sum_slices + 1 + w->flow_slices; }

void tt_operator_slice(const tt_model* m, tt_work* w, const double* p, int slice) {
  if (slice < w->sum_slices)
    sum_terms(m, w, p, slice);
  else if (slice == w->sum_slices)
    build_matrix(m, w, 0.0, 1.0, w->operator_matrix);
  else
    add_flows(m, 1.0, p, slice - w->sum_slices - 1, w->operator_matrix);
}

int tt_project_slices(const tt_work* w) { return w->project_slices; }

void tt_project_slice(const tt_model* m, tt_work* w, const double* state, const double* change, int slice) {
  const int each = rows_a_slice(m->order), first = slice * each, count = tt_output_count(m);
  tt_project(m, first, first + each < count ? first + each : count, state, change, w->next_base, w->next_slope);
}

void tt_apply_operator(const tt_model* m, double factor, const double* p, const double* x, double* y) {
  const ptrdiff_t n = m->order;
  tt_gemv(n, n, factor, m->conduction, x, y);
  for (int t = 0; t < m->terms; ++t) {
    if (p[t] == 0.0) continue;
    for (int c = 0; c < columns_of(m, t); ++c) {
      const int column = m->term_first[t] + c, right = m->term_right_first[t];
      const double* u = m->term_left + column * n;
      const double* v = right < 0 ? u : m->term_right + (right + c) * n;
      tt_axpy(n, factor * p[t] * m->term_weight[column] * tt_dot(n, v, x), u, y);
    }
  }
}

void tt_add_term(const tt_model* m, int term, double factor, double* matrix) {
  const ptrdiff_t n = m->order;
  for (int c = 0; c < columns_of(m, term); ++c) {
    const int column = m->term_first[term] + c, right = m->term_right_first[term];
    const double* u = m->term_left + column * n;
    const double* v = right < 0 ? u : m->term_right + (right + c) * n;
    for (int j = 0; j < n; ++j) tt_axpy(n, factor * m->term_weight[column] * v[j], u, matrix + j * n);
  }
}
