/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/probing.h"

#include <math.h>

#include "compensation/control/linear.h"
#include "compensation/control/output_weights.h"
#include "compensation/control/outputs.h"
#include "compensation/control/scalars.h"
#include "compensation/control/twin_jobs.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

enum { of_tool = 6, of_axis = 6, of_own = 7, sides = of_tool + of_axis + of_own };

/* to (order x 3) += the rows that make the error's x, y, z of `count` outputs at each of the poses; the first of these
 * outputs is `first` of the sides. */
static void add_rows(const tt_model* m, const double unit[3 * sides], const double* weights, int poses,
                     const double* rows, int first, int count, double* to) {
  const ptrdiff_t n = m->order;
  for (ptrdiff_t i = 0; i < poses; ++i) {
    if (weights[i] == 0.0) continue;
    for (int k = 0; k < count; ++k) {
      for (int c = 0; c < 3; ++c)
        tt_axpy(n, weights[i] * unit[3 * (first + k) + c], rows + (i * count + k) * n, to + c * n);
    }
  }
}

/* tool, table: (order x 3), error = (tool + table)^T x */
static void set_rows(const tt_twin* t, const double* pose, double* tool, double* table) {
  const tt_model* m = t->model;
  double unit[3 * sides];
  double *at_tool = t->work.scratch, *at_table = at_tool + m->tool_poses;
  for (int k = 0; k < sides; ++k) {
    double one[sides] = {0};
    one[k] = 1.0;
    tt_error_of_sides(m, pose, one, unit + 3 * k);
  }
  tt_tool_weights(m, pose, at_tool);
  tt_table_weights(m, pose, at_table);
  tt_zero(3 * m->order, tool);
  tt_zero(3 * m->order, table);
  add_rows(m, unit, at_tool, m->tool_poses, m->tool_rows, 0, of_tool, tool);
  add_rows(m, unit, at_table, m->table_poses, m->axis_rows, of_tool, of_axis, table);
  add_rows(m, unit, at_table, m->table_poses, m->own_rows, of_tool + of_axis, of_own, table);
}

int tt_twin_probe(tt_twin* t, const double* pose, const double error[3], double std_m) {
  const tt_model* m = t->model;
  const ptrdiff_t n = m->order;
  double *tool = t->pose_rows, *table = tool + 3 * n, *state = table + 3 * n;
  int values = 0;
  for (int i = 0; i < 3; ++i) values += tt_is_finite(error[i]);
  if (!m->observer || !t->now->started || t->now->job == TT_JOB_START || values == 0) return 0;
  tt_finish_job(t);
  if (t->now->interval_s > 0.0) { /* sensitivities of now */
    tt_begin_correction(t);
    tt_finish_job(t);
  }
  set_rows(t, pose, tool, table);
  tt_copy(n, t->state, state);
  tt_axpy(n, tt_share_ahead(t), t->change, state);
  const tt_moment now = tt_moment_of(t);
  tt_observer_learn(&t->observer, &now, tool, table, state, error,
                    sqrt(std_m * std_m + m->model_error * m->model_error));
  tt_begin_showing(t);
  tt_finish_job(t);
  return values;
}
