/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_MODEL_H
#define THERMOTWIN_MODEL_H
/* Constant data of a reduced model and its machine for the online core: counts, numbers, and flat arrays. The affine
 * equation is that of solver/operation/operating_model.h with capacity 1,
 *   dx/dt + (K0 + sum_j p_j K_j) x = sum_k q_k s_k,   x in K above the reference.
 * A symmetric term is K_j = sum_c w_c u_c u_c^T with w = 1 or -1; another one is K_j = sum_c u_c v_c^T.
 *
 * The lists below name each entry once: the struct, the builder (control_model.h) and the writer of C source
 * (control_source.h) follow from them. Lists of different lengths lie in one array with an array of their starts,
 * `x_first` (items + 1). An index of -1 says "none". `curve` is an index into the curves. Channels are in the units of
 * their names, all else is in SI units and K above the reference. */

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { TT_TERM_FILM, TT_TERM_CONTACT, TT_TERM_WALL, TT_TERM_FLOW, TT_TERM_EXCHANGE, TT_TERM_GIVEN };
enum {
  TT_INPUT_FILM,
  TT_INPUT_CONTACT,
  TT_INPUT_SOURCE,
  TT_INPUT_INLET,
  TT_INPUT_GRADIENT,
  TT_INPUT_VOLUME,
  TT_INPUT_GIVEN
};
enum { TT_VERTICAL, TT_UP, TT_DOWN };
enum { TT_AS_IT_IS, TT_MAGNITUDE, TT_HOUR_OF_DAY };
enum { TT_LAG, TT_TWO_POINT, TT_PI_CONTROL };
enum { TT_BEARING, TT_GUIDE, TT_SCREW, TT_MOTOR, TT_HOLDING };
enum { TT_LOSS_NUMBERS = 8 }; /* a loss; their meaning: laws.h */
enum { TT_CHAIN_TOOL, TT_CHAIN_CARRIER, TT_CHAIN_TABLE, TT_CHAINS };

/* clang-format off */
#define TT_MODEL_COUNTS(X) \
  X(order)         /* states */ \
  X(terms) X(inputs) \
  X(channels)      /* of a row */ \
  X(axes)          /* of the machine */ \
  X(linear_axes)   /* that receive offsets */ \
  X(ambients) X(films) X(joints) X(coolants) X(sources) \
  X(sensors) X(readings) /* the sensors, then other temperatures that the model follows */ \
  X(tool_poses) X(table_poses) X(tool_grid) X(table_grid) /* stored poses; axes of their grids */ \
  X(lines)         /* with more tool poses: reduction/model/output_grid.h */ \
  X(travels)       /* bounds of the workspace */ \
  X(machine_on)    /* channel */ \
  X(has_middle)    /* whether lines run through the middle */ \
  X(observer)      /* 1: sensors correct the state and offsets have a deviation; 0: what follows is not there */ \
  X(quantities)    /* uncertain ones of the machine */ \
  X(day_drives) X(heating) /* the spindle and the axes; those of them that heat */ \
  X(warm)          /* quantities that are surroundings */ \
  X(own_ambients)  /* channels of surroundings that have a temperature of their own */ \
  X(leaping)       /* channels whose values may leap */ \
  X(air_channel) X(air_quantity) X(fluid_on) /* channel; quantity; channel */ \
  X(start_from_sensors) \
  X(grid_poses) X(grid_tables) /* of the workspace grid, for deviations */ \
  X(grid_angles)   /* angles of the table's own axis there */

#define TT_MODEL_NUMBERS(X) \
  X(step_s)        /* longest step of the state */ \
  X(start_C) X(reference_C) X(plausible_low_C) X(plausible_high_C) \
  X(largest_um) X(rate_um_s) X(hold_s) /* guard of the offsets */ \
  X(table_radius)  /* m; 0: no radial growth */ \
  X(correction_s)  /* longest time between corrections by sensors; after it, an input is no longer news */ \
  X(start_over_s)  /* machine time that the work of the start is spread over; 0: done in the first row */ \
  X(model_error)   /* m, stated error of the reduced model */

#define TT_MODEL_DOUBLES(X) \
  X(conduction)    /* (order x order) K0 */ \
  X(term_left)     /* (order x columns) u */ \
  X(term_right)    /* (order x columns of terms that are not symmetric) v */ \
  X(term_weight)   /* (columns) w; 1 for a term that is not symmetric */ \
  X(input_columns) /* (order x inputs) s */ \
  X(one_kelvin)    /* (order) uniform 1 K above the reference */ \
  X(sensor_rows)   /* (order x readings) */ \
  X(sensor_offset) /* (readings) K */ \
  X(tool_rows)     /* (order x 6 tool_poses) each pose x y z a b c, m and rad */ \
  X(axis_rows) X(own_rows) /* (order x 6 table_poses), (order x 7 table_poses): the seventh is radial growth */ \
  X(term_value)    /* (terms) film coefficient of a wall, flow, conductance, capacity over 1 s */ \
  X(input_share)   /* (inputs) of a source */ \
  X(channel_default) X(channel_low) X(channel_high) /* (channels) a value beyond is no value */ \
  X(axis_unit)     /* (axes) SI value of one unit of the position's channel */ \
  X(axis_direction) X(axis_origin) /* (3 x axes) machine's frame */ \
  X(axis_slope_um) X(axis_rapid)   /* (axes) um per m or rad of motion; m/s or rad/s: see offset_limits.h */ \
  X(curve_at) X(curve_value)       /* points of all curves */ \
  X(ambient_default_C) X(ambient_offset) X(ambient_gradient) \
  X(film_still) X(film_radiation)  /* W/(m^2 K) of still air, and of radiation at the reference */ \
  X(film_emissivity) X(film_length) X(film_factor) X(film_load) \
  X(film_to_rad_s) X(film_radius) X(film_fraction) X(film_speed_factor) \
  X(joint_conductance) X(joint_factor) X(joint_clamped_factor) X(joint_positions) \
  X(coolant_warmed_share) X(coolant_offset) X(coolant_inlet_offset) X(coolant_time_constant) \
  X(coolant_band) X(coolant_pull_down) X(coolant_drift_up) X(coolant_gain) X(coolant_integral_time) \
  X(coolant_heat_flow) X(coolant_power) \
  X(source_scale) X(source_loss_share) X(source_standstill) X(source_exponent) \
  X(law_half_speed) /* 0: not over a speed */ \
  X(loss_to_speed) X(loss_to_position) X(loss_fastest) X(loss_numbers) \
  X(tool_positions) X(table_positions) X(fine_positions) \
  X(travel_low) X(travel_high) \
  X(to_axes)       /* (linear_axes x 3) offsets that cancel a translation of 1 */ \
  X(tool_point) X(table_point) X(growth_origin) X(growth_direction) /* (3) */ \
  X(sensor_std)    /* (sensors) stated standard deviation of a reading, K */ \
  X(quantity_std) X(quantity_memory) /* a share or K; s, 0: does not fade */ \
  X(day_low) X(day_high) /* (axes) ends of the travel in the channel's unit */ \
  X(drive_half_speed) /* (day_drives) in the channel's unit */ \
  X(warm_K)        /* (warm) how much warmer than the hall */ \
  X(grid_table_positions) /* of the table's axes in the workspace grid */ \
  X(grid_pose)     /* (axes x grid_angles x grid_tables x grid_poses) */

#define TT_MODEL_INTS(X) \
  X(term_kind) X(term_item) X(term_channel) \
  X(term_first)    /* columns in term_left */ \
  X(term_right_first) /* (terms) first column in term_right; -1: symmetric */ \
  X(input_kind) X(input_term) X(input_item) X(input_ambient) X(input_channel) \
  X(input_occupancy) /* (inputs) term whose share of the time multiplies a source */ \
  X(channel_state) X(channel_temperature) X(channel_ambient) /* 1: a state from 0 to 1; degC; of an ambient */ \
  X(axis_position) X(axis_feed) X(axis_low) X(axis_high) X(axis_rotary) /* channels; 1: rotary */ \
  X(linear_axis)   /* (linear_axes) */ \
  X(curve_first) \
  X(ambient_channel) X(ambient_follows) X(ambient_gradient_channel) \
  X(film_first_input) X(film_ambient) X(film_surroundings) X(film_own) X(film_volume) \
  X(film_of_temperature) X(film_exact) X(film_orientation) \
  X(film_table) X(film_table_channel) X(film_table_input) X(film_speed_channel) X(film_state) \
  X(joint_first_term) X(joint_clamp) X(joint_reading) X(joint_curve) \
  X(joint_grid_axis) X(joint_periodic) X(joint_grid_first) \
  X(coolant_on) X(coolant_inlet) X(coolant_guide) X(coolant_returns) X(coolant_warmed_by) \
  X(coolant_control) X(coolant_controls_return) X(coolant_guide_ambient) \
  X(source_drive) X(source_law_first) X(source_loss_first) \
  X(law_channel) X(law_input) X(law_curve) \
  X(loss_kind) X(loss_speed) X(loss_position) X(loss_low) X(loss_high) X(loss_clamp) X(loss_curve) \
  X(tool_axis) X(tool_linear) X(tool_endless) X(tool_first) \
  X(table_axis) X(table_linear) X(table_endless) X(table_first) \
  X(fine_first) X(line_axis) X(line_at) X(line_on_grid) \
  X(travel_axis) \
  X(chain_first) X(chain_axis) /* axes that move tool, carrier and table, from the body to the bed */ \
  X(quantity_ambient) /* ambient that it is the temperature of; -1: none */ \
  X(quantity_term_first) X(quantity_term) X(quantity_input_first) X(quantity_input) \
  X(quantity_warm_first) X(quantity_warm) /* lists of a quantity: sensitivities.h */ \
  X(drive_channel) /* (day_drives) of speed or feed; -1: none */ \
  X(heating_drive) /* (heating) among the day's drives */ \
  X(warm_quantity) X(own_ambient) X(leaping_channel) \
  X(grid_table_first) X(grid_table) /* (grid_tables) stored table poses of the workspace grid */

#define TT_MODEL_TEXTS(X) X(channel_names) X(axis_names) X(sensor_names)
/* clang-format on */

typedef struct tt_model {
  const char* name;
  uint64_t hash; /* of all that follows: a state belongs to one model */
#define TT_FIELD(x) int32_t x;
  TT_MODEL_COUNTS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) double x;
  TT_MODEL_NUMBERS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) const double* x;
  TT_MODEL_DOUBLES(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) const int32_t* x;
  TT_MODEL_INTS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) const char* const* x;
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
} tt_model;

#ifdef __cplusplus
}
#endif
#endif
