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

/* Entries of the triangles whose sum over all symmetric terms is a slice. */
static int entries_a_slice(const tt_model* m) {
  const int size = triangle_size(m->order), terms = symmetric_count(m);
  const int entries = terms > 0 ? slice_work / (2 * terms) : size; /* from memory, where factors come from a cache */
  return entries < 1 ? 1 : entries < size ? entries : size;
}

/* Columns of the matrix that are set from the triangle; and those to which all of the unsymmetric terms are added. */
static int built_a_slice(int n) {
  const int columns = slice_work / (4 * n);
  return columns > 1 ? columns : 1;
}

static int flows_a_slice(const tt_model* m) {
  const int columns = slice_work / (2 * m->order * right_columns(m) + 1);
  return columns > 1 ? columns : 1;
}

static int rows_a_slice(int n) {
  const int rows = slice_work / (2 * n);
  return rows > 1 ? rows : 1;
}

static int parts(int count, int size) { return (count + size - 1) / size; }

void tt_work_prepare(const tt_model* m, tt_work* w) {
  const ptrdiff_t n = m->order, size = triangle_size(m->order), each = entries_a_slice(m), terms = symmetric_count(m);
  w->symmetric_terms = 0;
  for (int t = 0; t < m->terms; ++t) {
    if (m->term_right_first[t] >= 0) continue;
    tt_zero(size, w->triangle);
    for (int c = m->term_first[t]; c < m->term_first[t + 1]; ++c)
      add_square(n, m->term_weight[c], m->term_left + c * n, w->triangle);
    for (ptrdiff_t first = 0; first < size; first += each) {
      const ptrdiff_t count = each < size - first ? each : size - first;
      float* own = w->triangles + terms * first + w->symmetric_terms * count;
      for (ptrdiff_t i = 0; i < count; ++i) own[i] = (float)w->triangle[first + i];
    }
    w->symmetric[w->symmetric_terms++] = t;
  }
  w->constant_symmetric = is_symmetric(n, m->conduction);
  plan_factor(m->order, w);
  w->sum_slices = parts(triangle_size(m->order), entries_a_slice(m));
  w->build_slices = parts(m->order, built_a_slice(m->order));
  w->flow_slices = right_columns(m) > 0 ? parts(m->order, flows_a_slice(m)) : 0;
  w->project_slices = parts(tt_output_count(m), rows_a_slice(m->order));
  w->factor_step = 0.0;
}

static int slices_before_factor(const tt_work* w) { return w->sum_slices + w->build_slices + w->flow_slices; }

int tt_slices(const tt_work* w) { return slices_before_factor(w) + w->lu_slices + 3 + w->project_slices; }

static void add_term(ptrdiff_t size, double amount, const float* restrict term, double* restrict triangle) {
  for (ptrdiff_t i = 0; i < size; ++i) triangle[i] += amount * term[i];
}

/* Entries first to last of the constant part's lower triangle. */
static void copy_triangle(const tt_model* m, ptrdiff_t first, ptrdiff_t last, double* triangle) {
  const ptrdiff_t n = m->order;
  ptrdiff_t start = 0; /* of column j in the triangle */
  for (ptrdiff_t j = 0; j < n; start += n - j++) {
    const ptrdiff_t from = first > start ? first : start, to = last < start + n - j ? last : start + n - j;
    if (from < to) tt_copy(to - from, m->conduction + j * n + j + (from - start), triangle + from);
  }
}

static void sum_terms(const tt_model* m, tt_work* w, const double* p, int slice) {
  const ptrdiff_t size = triangle_size(m->order), each = entries_a_slice(m), first = slice * each,
                  count = each < size - first ? each : size - first;
  const float* part = w->triangles + w->symmetric_terms * first;
  copy_triangle(m, first, first + count, w->triangle);
  for (int k = 0; k < w->symmetric_terms; ++k, part += count) {
    const double amount = p[w->symmetric[k]];
    if (amount != 0.0) add_term(count, amount, part, w->triangle + first);
  }
}

/* matrix = diagonal + scale times the sum of the terms so far, some columns of it */
static void build_matrix(const tt_model* m, const tt_work* w, double diagonal, double scale, int slice,
                         double* matrix) {
  const ptrdiff_t n = m->order, each = built_a_slice(m->order), first = slice * each,
                  last = first + each < n ? first + each : n;
  const double *k = m->conduction, *row = w->triangle; /* column i of the triangle is row i of the matrix */
  for (ptrdiff_t i = 0; i < last; row += n - i++) {
    for (ptrdiff_t j = first > i ? first : i; j < last; ++j) {
      const double beside = w->constant_symmetric || i == j ? 0.0 : k[i + j * n] - k[j + i * n];
      matrix[i + j * n] = scale * row[j - i] + scale * beside;
    }
    if (i < first) continue;
    for (ptrdiff_t j = i + 1; j < n; ++j) matrix[j + i * n] = scale * row[j - i];
    matrix[i + i * n] += diagonal;
  }
}

static void add_flows(const tt_model* m, double scale, const double* p, int slice, double* matrix) {
  const ptrdiff_t n = m->order, each = flows_a_slice(m), first = slice * each,
                  last = first + each < n ? first + each : n;
  for (int t = 0; t < m->terms; ++t) {
    if (m->term_right_first[t] < 0 || p[t] == 0.0) continue;
    for (int c = 0; c < columns_of(m, t); ++c) {
      const double *u = m->term_left + (m->term_first[t] + c) * n,
                   *v = m->term_right + (m->term_right_first[t] + c) * n;
      for (ptrdiff_t j = first; j < last; ++j) tt_axpy(n, scale * p[t] * v[j], u, matrix + j * n);
    }
  }
}

/* matrix = diagonal + scale (K0 + sum_j p_j K_j), by slices. */
static void sum_slice(const tt_model* m, tt_work* w, double diagonal, double scale, const double* p, int slice,
                      double* matrix) {
  const int built = slice - w->sum_slices, flow = built - w->build_slices;
  if (built < 0)
    sum_terms(m, w, p, slice);
  else if (flow < 0)
    build_matrix(m, w, diagonal, scale, built, matrix);
  else
    add_flows(m, scale, p, flow, matrix);
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
  const int n = m->order, of_factor = slices_before_factor(w);
  const double scale = TT_GAMMA * step_s;
  if (slice == 0) {
    /* Nothing to do while coefficients stand; the slices stay counted, so that times do not depend on it. */
    if (w->factor_step == step_s && same(m->terms, p, w->factor_p)) return 0;
    w->factor_step = 0.0;
  }
  if (w->factor_step > 0.0) return 0;
  if (slice < of_factor) {
    sum_slice(m, w, 1.0, scale, p, slice, w->matrix);
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
  const int n = m->order, of_stages = slices_before_factor(w) + w->lu_slices;
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

int tt_operator_slices(const tt_work* w) { return slices_before_factor(w); }

void tt_operator_slice(const tt_model* m, tt_work* w, const double* p, int slice) {
  sum_slice(m, w, 0.0, 1.0, p, slice, w->operator_matrix);
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
