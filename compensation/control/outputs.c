/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/outputs.h"

#include "compensation/control/linear.h"
#include "compensation/control/output_weights.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

int tt_output_count(const tt_model* m) { return 6 * m->tool_poses + 13 * m->table_poses; }

void tt_project(const tt_model* m, int first, int last, const double* x, const double* d, double* y, double* z) {
  const int of_tool = 6 * m->tool_poses, of_axis = of_tool + 6 * m->table_poses;
  const ptrdiff_t n = m->order;
  for (int i = first; i < last; ++i) {
    const double* row = i < of_tool   ? m->tool_rows + i * n
                        : i < of_axis ? m->axis_rows + (i - of_tool) * n
                                      : m->own_rows + (i - of_axis) * n;
    y[i] = tt_dot(n, row, x);
    z[i] = tt_dot(n, row, d);
  }
}

/* A rigid motion x -> R x + t; R column by column. */
typedef struct frame {
  double r[9], t[3];
} frame;

static void turn(const double r[9], const double v[3], double out[3]) {
  for (int i = 0; i < 3; ++i) out[i] = r[i] * v[0] + r[3 + i] * v[1] + r[6 + i] * v[2];
}

/* R^T v */
static void turn_back(const double r[9], const double v[3], double out[3]) {
  for (int i = 0; i < 3; ++i) out[i] = r[3 * i] * v[0] + r[3 * i + 1] * v[1] + r[3 * i + 2] * v[2];
}

static void cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Rotation about a unit direction. */
static void rotation(const double u[3], double angle, double r[9]) {
  const double c = tt_cos(angle), s = tt_sin(angle), k = 1.0 - c;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) r[3 * j + i] = k * u[i] * u[j] + (i == j ? c : 0.0);
  }
  r[1] += s * u[2];
  r[2] -= s * u[1];
  r[3] -= s * u[2];
  r[5] += s * u[0];
  r[6] += s * u[1];
  r[7] -= s * u[0];
}

/* From the home frame of a chain's body to the machine; each axis acts in home coordinates of what carries it. */
static frame frame_of(const tt_model* m, int chain, const double* pose) {
  frame f = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  for (int k = m->chain_first[chain]; k < m->chain_first[chain + 1]; ++k) {
    const int a = m->chain_axis[k];
    const double *u = m->axis_direction + 3 * a, *o = m->axis_origin + 3 * a;
    if (!m->axis_rotary[a]) {
      for (int i = 0; i < 3; ++i) f.t[i] += pose[a] * u[i];
      continue;
    }
    double r[9], from[3], turned[3];
    frame g;
    rotation(u, pose[a], r);
    for (int j = 0; j < 3; ++j) turn(r, f.r + 3 * j, g.r + 3 * j);
    for (int i = 0; i < 3; ++i) from[i] = f.t[i] - o[i];
    turn(r, from, turned);
    for (int i = 0; i < 3; ++i) g.t[i] = turned[i] + o[i];
    f = g;
  }
  return f;
}

/* A point of the machine in home coordinates of the frame's body. */
static void into(const frame* f, const double point[3], double out[3]) {
  const double from[3] = {point[0] - f->t[0], point[1] - f->t[1], point[2] - f->t[2]};
  turn_back(f->r, from, out);
}

/* sides: tool 6, axis 6, own 7 */
void tt_error_of_sides(const tt_model* m, const double* pose, const double sides[19], double error[3]) {
  const double *tool = sides, *axis = sides + 6, *own = sides + 12;
  double tcp[3], arm[3], motion[3], part[3], at_table[3];
  const frame of_tool = frame_of(m, TT_CHAIN_TOOL, pose), carrier = frame_of(m, TT_CHAIN_CARRIER, pose),
              table = frame_of(m, TT_CHAIN_TABLE, pose);
  turn(of_tool.r, m->tool_point, tcp);
  for (int i = 0; i < 3; ++i) tcp[i] += of_tool.t[i];

  into(&carrier, tcp, arm);
  for (int i = 0; i < 3; ++i) arm[i] -= m->table_point[i];
  cross(axis + 3, arm, motion);
  for (int i = 0; i < 3; ++i) motion[i] += axis[i];
  turn(carrier.r, motion, part);
  for (int i = 0; i < 3; ++i) error[i] = tool[i] - part[i];

  into(&table, tcp, at_table);
  for (int i = 0; i < 3; ++i) arm[i] = at_table[i] - m->table_point[i];
  cross(own + 3, arm, motion);
  for (int i = 0; i < 3; ++i) motion[i] += own[i];
  if (m->table_radius > 0.0) {
    double from[3], along = 0.0;
    for (int i = 0; i < 3; ++i) from[i] = at_table[i] - m->growth_origin[i];
    for (int i = 0; i < 3; ++i) along += from[i] * m->growth_direction[i];
    for (int i = 0; i < 3; ++i) motion[i] += own[6] / m->table_radius * (from[i] - along * m->growth_direction[i]);
  }
  turn(table.r, motion, part);
  for (int i = 0; i < 3; ++i) error[i] -= part[i];
}

static void add_sides(const tt_model* m, const double* outputs, const double* at_tool, const double* at_table,
                      double factor, double* sides) {
  const double *axis = outputs + 6 * m->tool_poses, *own = axis + 6 * m->table_poses;
  tt_gemv(6, m->tool_poses, factor, outputs, at_tool, sides);
  tt_gemv(6, m->table_poses, factor, axis, at_table, sides + 6);
  tt_gemv(7, m->table_poses, factor, own, at_table, sides + 12);
}

void tt_sides_at(const tt_model* m, const double* base, const double* change, double share, const double* pose,
                 double* scratch, double sides[19]) {
  double *at_tool = scratch, *at_table = scratch + m->tool_poses;
  tt_zero(19, sides);
  tt_tool_weights(m, pose, at_tool);
  tt_table_weights(m, pose, at_table);
  add_sides(m, base, at_tool, at_table, 1.0, sides);
  if (share != 0.0) add_sides(m, change, at_tool, at_table, share, sides);
}

void tt_tcp_error(const tt_model* m, const double* base, const double* change, double share, const double* pose,
                  double* scratch, double error[3]) {
  double sides[19];
  tt_sides_at(m, base, change, share, pose, scratch, sides);
  tt_error_of_sides(m, pose, sides, error);
}

void tt_offsets(const tt_model* m, const double error[3], double* offsets) {
  for (int i = 0; i < m->linear_axes; ++i) offsets[i] = 0.0;
  tt_gemv(m->linear_axes, 3, 1.0, m->to_axes, error, offsets);
}

int tt_outside(const tt_model* m, const double* pose) {
  for (int i = 0; i < m->travels; ++i) {
    const double at = pose[m->travel_axis[i]];
    if (at < m->travel_low[i] || at > m->travel_high[i]) return 1;
  }
  return 0;
}
