/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/deviation.h"

#include "compensation/control/linear.h"
#include "compensation/control/output_weights.h"
#include "compensation/control/outputs.h"
#include "compensation/control/scalars.h"

enum { slice_products = 60000 }; /* multiplications of a slice, about */
enum { of_tool = 6, of_axis = 6, of_own = 7, sides = 19 };

static int places_of(const tt_model* m) { return m->grid_poses * m->grid_tables; }
static int outputs_of(const tt_model* m) { return of_tool * m->grid_poses + (of_axis + of_own) * m->grid_tables; }

void tt_deviation_lay(tt_deviation* d, const tt_model* m, const tt_sensor_model* sensors, tt_arena* state,
                      tt_arena* work) {
  const ptrdiff_t axes = m->linear_axes, places = places_of(m), columns = tt_columns(sensors);
  d->variance = tt_doubles(state, axes * places);
  d->smallest = tt_doubles(state, axes);
  d->next = tt_doubles(state, axes * places);
  d->columns = tt_doubles(work, axes * sides * places * m->grid_angles);
  d->outputs = tt_doubles(work, columns * outputs_of(m));
  d->influence = tt_doubles(work, columns + tt_outputs);
  d->product = tt_doubles(work, columns + tt_outputs);
  d->at_poses = tt_doubles(work, m->grid_poses);
  d->at_tables = tt_doubles(work, m->grid_tables);
}

void tt_deviation_prepare(tt_deviation* d, const tt_model* m) {
  const ptrdiff_t poses = places_of(m) * m->grid_angles, axes = m->linear_axes;
  for (ptrdiff_t i = 0; i < poses; ++i) {
    for (int k = 0; k < sides; ++k) {
      double unit[sides] = {0}, error[3];
      unit[k] = 1.0;
      tt_error_of_sides(m, m->grid_pose + i * m->axes, unit, error);
      tt_offsets(m, error, d->columns + (i * sides + k) * axes);
    }
  }
}

static int slices_for(int items, int each) { return (items + each - 1) / each; }
static int rows_a_slice(const tt_model* m, int columns) {
  const int rows = slice_products / (m->order * columns);
  return rows > 1 ? rows : 1;
}
static int places_a_slice(const tt_model* m, int columns) {
  const int places = slice_products / ((columns + sides) * columns * m->linear_axes * m->grid_angles + 1);
  return places > 1 ? places : 1;
}

int tt_deviation_slices(const tt_model* m, const tt_sensor_model* sensors) {
  const int columns = tt_columns(sensors);
  return slices_for(outputs_of(m), rows_a_slice(m, columns)) + slices_for(places_of(m), places_a_slice(m, columns));
}

/* The row of one of the outputs: all of the tool at each pose, then those of the table at each of its poses. */
static const double* row_of(const tt_model* m, int output) {
  const ptrdiff_t n = m->order;
  if (output < of_tool * m->grid_poses) return m->tool_rows + output * n;
  output -= of_tool * m->grid_poses;
  if (output < of_axis * m->grid_tables)
    return m->axis_rows + (m->grid_table[output / of_axis] * of_axis + output % of_axis) * n;
  output -= of_axis * m->grid_tables;
  return m->own_rows + (m->grid_table[output / of_own] * of_own + output % of_own) * n;
}

/* Outputs first to last: each direction is read once for all of them. */
static void set_outputs(tt_deviation* d, const tt_model* m, const tt_errors* e, ptrdiff_t columns, int first,
                        int last) {
  for (ptrdiff_t k = 0; k < columns; ++k) {
    const double* direction = e->sensitivities.directions + k * m->order;
    for (int i = first; i < last; ++i) d->outputs[i * columns + k] = tt_dot(m->order, direction, row_of(m, i));
  }
}

/* Place of a pose of the grid at an angle, among all of them. */
static ptrdiff_t place_of(const tt_model* m, ptrdiff_t pose, int table, int angle) {
  return (pose * m->grid_tables + table) * m->grid_angles + angle;
}

/* influence (columns) of the offset of an axis at a pose of the grid, at an angle */
static void set_influence(tt_deviation* d, const tt_model* m, ptrdiff_t columns, int pose, int table, int angle,
                          int axis) {
  const double* by = d->columns + place_of(m, pose, table, angle) * sides * m->linear_axes;
  const int of_axes = of_tool * m->grid_poses, of_owns = of_axes + of_axis * m->grid_tables;
  tt_zero(columns, d->influence);
  for (int k = 0; k < sides; ++k) {
    const int output = k < of_tool             ? of_tool * pose + k
                       : k < of_tool + of_axis ? of_axes + of_axis * table + k - of_tool
                                               : of_owns + of_own * table + k - of_tool - of_axis;
    tt_axpy(columns, by[k * m->linear_axes + axis], d->outputs + output * columns, d->influence);
  }
}

/* The error of one side alone, tool or table, of outputs at a pose of the grid, at an angle. */
static void side_error(const tt_model* m, const double* outputs, int tool_side, int pose, int table, int angle,
                       double error[3]) {
  const double *axis = outputs + of_tool * m->tool_poses, *own = axis + of_axis * m->table_poses;
  double side[sides] = {0};
  if (tool_side) {
    tt_copy(of_tool, outputs + of_tool * pose, side);
  } else {
    tt_copy(of_axis, axis + of_axis * m->grid_table[table], side + of_tool);
    tt_copy(of_own, own + of_own * m->grid_table[table], side + of_tool + of_axis);
  }
  tt_error_of_sides(m, m->grid_pose + place_of(m, pose, table, angle) * m->axes, side, error);
}

/* The rest of the influence: shares of the tool side, of the table side, and the remainder, by x y z. */
static void set_output_influence(tt_deviation* d, const tt_model* m, const double* outputs, int columns, int pose,
                                 int table, int angle, int axis) {
  double* influence = d->influence + columns;
  double tool[3], other[3];
  side_error(m, outputs, 1, pose, table, angle, tool);
  side_error(m, outputs, 0, pose, table, angle, other);
  for (int i = 0; i < 3; ++i) {
    const double to_axis = m->to_axes[axis + i * m->linear_axes];
    influence[i] = to_axis * tool[i];
    influence[3 + i] = to_axis * other[i];
    influence[6 + i] = to_axis;
  }
}

/* influence^T Sigma influence, of columns and outputs */
static double whole_variance(tt_deviation* d, const tt_errors* e, int columns) {
  const tt_sensor_model* sensors = e->sensitivities.model;
  const ptrdiff_t all = tt_errors_count(sensors);
  const int output = tt_errors_first_output(sensors);
  for (int k = 0; k < columns + tt_outputs; ++k) {
    const double* sigma = e->sigma + (k < columns ? k : output + k - columns) * all;
    d->product[k] = tt_dot(columns, sigma, d->influence) + tt_dot(tt_outputs, sigma + output, d->influence + columns);
  }
  return tt_dot(columns + tt_outputs, d->product, d->influence);
}

static void set_place(tt_deviation* d, const tt_model* m, const tt_errors* e, const double* outputs, int columns,
                      int place) {
  const ptrdiff_t all = tt_errors_count(e->sensitivities.model), axes = m->linear_axes;
  const int pose = place / m->grid_tables, table = place % m->grid_tables;
  for (int axis = 0; axis < axes; ++axis) {
    double sum = 0.0;
    for (int angle = 0; angle < m->grid_angles; ++angle) {
      set_influence(d, m, columns, pose, table, angle, axis);
      if (tt_errors_learns(e)) {
        set_output_influence(d, m, outputs, columns, pose, table, angle, axis);
        sum += whole_variance(d, e, columns);
        continue;
      }
      for (int k = 0; k < columns; ++k) d->product[k] = tt_dot(columns, e->sigma + k * all, d->influence);
      sum += tt_dot(columns, d->product, d->influence);
    }
    d->next[place * axes + axis] = tt_max(0.0, sum / m->grid_angles);
  }
}

int tt_deviation_work(tt_deviation* d, const tt_model* m, const tt_errors* e, const double* outputs, int slice,
                      int slices) {
  const int columns = tt_columns(e->sensitivities.model), rows = rows_a_slice(m, columns),
            places = places_a_slice(m, columns), first_place = slices_for(outputs_of(m), rows);
  if (slice < first_place) {
    const int done = slices < first_place - slice ? slices : first_place - slice;
    const int first = slice * rows, last = first + done * rows;
    set_outputs(d, m, e, columns, first, last < outputs_of(m) ? last : outputs_of(m));
    return done;
  }
  slice -= first_place;
  for (int i = slice * places; i < (slice + 1) * places && i < places_of(m); ++i)
    set_place(d, m, e, outputs, columns, i);
  return 1;
}

void tt_deviation_finish(tt_deviation* d, const tt_model* m) {
  const ptrdiff_t axes = m->linear_axes;
  tt_copy(places_of(m) * axes, d->next, d->variance);
  for (int axis = 0; axis < axes; ++axis) {
    double least = d->variance[axis];
    for (int i = 1; i < places_of(m); ++i) least = tt_min(least, d->variance[i * axes + axis]);
    d->smallest[axis] = least;
  }
}

void tt_deviation_at(const tt_deviation* d, const tt_model* m, const double* pose, double* variance) {
  const ptrdiff_t axes = m->linear_axes;
  tt_grid_weights(m, pose, d->at_poses);
  tt_grid_table_weights(m, pose, d->at_tables);
  tt_zero(m->linear_axes, variance);
  for (int i = 0; i < m->grid_poses; ++i) {
    if (d->at_poses[i] == 0.0) continue;
    for (int j = 0; j < m->grid_tables; ++j)
      tt_axpy(axes, d->at_poses[i] * d->at_tables[j], d->variance + (i * m->grid_tables + j) * axes, variance);
  }
  for (int axis = 0; axis < m->linear_axes; ++axis) variance[axis] = tt_max(variance[axis], d->smallest[axis]);
}
