// SPDX-License-Identifier: GPL-2.0-or-later
#include "nc/rs274/canon.h"

#include <array>
#include <canon.hh>
#include <cmath>
#include <cstdarg>
#include <cstring>

#include "nc/rs274/stream.h"
#include "nc/rs274/tools.h"

namespace {

using namespace thermotwin::nc::rs274;

constexpr double pi = 3.14159265358979323846;
using Nine = std::array<double, 9>;

/// What the interpreter may ask for.
struct State {
  Nine position{};             // machine, mm and deg
  Nine work{}, g92{}, tool{};  // mm and deg
  double unit = 1.0;           // mm
  double rotation = 0.0;       // deg
  CANON_PLANE plane = CANON_PLANE_XY;
  CANON_MOTION_MODE mode = CANON_CONTINUOUS;
  double tolerance = 0.0, naive = 0.0, feed = 0.0;
  double speed[8] = {};
  CANON_DIRECTION direction[8] = {};
  bool flood = false, mist = false, block_delete = true, optional_stop = true;
  int axis_mask = 0x3f, slot = 0, selected = -1;
} state;

double unit_of(int axis) { return axis >= 3 && axis < 6 ? 1.0 : state.unit; }

void turn(double& x, double& y, double degrees) {
  const double c = std::cos(degrees * pi / 180.0), s = std::sin(degrees * pi / 180.0), old = x;
  x = c * x - s * y;
  y = s * old + c * y;
}

/// Machine position of a programmed one, and back. The position of the controlled point holds no tool offset.
Nine to_machine(Nine p) {
  for (int i = 0; i < 9; ++i) p[i] = p[i] * unit_of(i) + state.g92[i];
  turn(p[0], p[1], state.rotation);
  for (int i = 0; i < 9; ++i) p[i] += state.work[i] + state.tool[i];
  return p;
}
Nine to_program(Nine p) {
  for (int i = 0; i < 9; ++i) p[i] -= state.work[i] + state.tool[i];
  turn(p[0], p[1], -state.rotation);
  for (int i = 0; i < 9; ++i) p[i] = (p[i] - state.g92[i]) / unit_of(i);
  return p;
}

void move(Kind kind, int line, const Nine& to) {
  write_values(kind, 0, line, to.data(), 9);
  state.position = to_machine(to);
}

void offset(OffsetKind kind, Nine& held, const Nine& given) {
  write_values(Kind::offset, static_cast<std::uint8_t>(kind), current_line(), given.data(), 9);
  for (int i = 0; i < 9; ++i) held[i] = given[i] * unit_of(i);
}

int spindle_index(int spindle) { return spindle >= 0 && spindle < 8 ? spindle : 0; }

double position_of(int axis) { return to_program(state.position)[axis]; }

}  // namespace

namespace thermotwin::nc::rs274 {
void start_at(const double (&position)[9]) {
  for (int i = 0; i < 9; ++i) state.position[i] = position[i];
}
void set_axis_mask(int mask) { state.axis_mask = mask; }
void set_block_delete(bool on) { state.block_delete = on; }
}  // namespace thermotwin::nc::rs274

// --- offsets and units

void INIT_CANON() {}
void SET_G5X_OFFSET(int origin, double x, double y, double z, double a, double b, double c, double u, double v,
                    double w) {
  write_setting(Setting::work_offset_set, origin);
  offset(OffsetKind::work, state.work, {x, y, z, a, b, c, u, v, w});
}
void SET_G92_OFFSET(double x, double y, double z, double a, double b, double c, double u, double v, double w) {
  offset(OffsetKind::g92, state.g92, {x, y, z, a, b, c, u, v, w});
}
void SET_XY_ROTATION(double t) {
  state.rotation = t;
  write_setting(Setting::rotation, t);
}
void CANON_UPDATE_END_POINT(double, double, double, double, double, double, double, double, double) {}
void USE_LENGTH_UNITS(CANON_UNITS u) {
  state.unit = u == CANON_UNITS_INCHES ? 25.4 : u == CANON_UNITS_CM ? 10.0 : 1.0;
  write_setting(Setting::length_unit, state.unit);
}
void SELECT_PLANE(CANON_PLANE plane) {
  state.plane = plane;
  write_setting(Setting::plane, plane);
}
void USE_TOOL_LENGTH_OFFSET(EmcPose t) {
  offset(OffsetKind::tool, state.tool, {t.tran.x, t.tran.y, t.tran.z, t.a, t.b, t.c, t.u, t.v, t.w});
}

// --- motion

void SET_TRAVERSE_RATE(double) {}
void STRAIGHT_TRAVERSE(int line, double x, double y, double z, double a, double b, double c, double u, double v,
                       double w) {
  move(Kind::traverse, line, {x, y, z, a, b, c, u, v, w});
}
void STRAIGHT_FEED(int line, double x, double y, double z, double a, double b, double c, double u, double v, double w) {
  move(Kind::feed, line, {x, y, z, a, b, c, u, v, w});
}
void STRAIGHT_PROBE(int line, double x, double y, double z, double a, double b, double c, double u, double v, double w,
                    unsigned char) {
  move(Kind::probe, line, {x, y, z, a, b, c, u, v, w});
}
void RIGID_TAP(int line, double x, double y, double z, double) {
  Nine to = to_program(state.position);
  to[0] = x, to[1] = y, to[2] = z;
  // Down and back: the tool ends where it was.
  write_values(Kind::tap, 0, line, to.data(), 9);
}
void ARC_FEED(int line, double first_end_, double second_end_, double first, double second, int rotation, double end,
              double a, double b, double c, double u, double v, double w) {
  const std::array<double, arc_values> values{
      first_end_, second_end_, first, second, static_cast<double>(rotation), end, a, b, c, u, v, w};
  write_values(Kind::arc, 0, line, values.data(), arc_values);
  Nine to{0, 0, 0, a, b, c, u, v, w};
  switch (state.plane) {
    case CANON_PLANE_YZ: to[1] = first_end_, to[2] = second_end_, to[0] = end; break;
    case CANON_PLANE_XZ: to[2] = first_end_, to[0] = second_end_, to[1] = end; break;
    default: to[0] = first_end_, to[1] = second_end_, to[2] = end; break;
  }
  state.position = to_machine(to);
}
void NURBS_FEED(int, std::vector<CONTROL_POINT>, unsigned int) { stop(Stop::program, "a spline (G5, G5.1 or G5.2)"); }
void SET_FEED_RATE(double rate) {
  state.feed = rate;
  write_setting(Setting::feed_rate, rate);
}
void SET_FEED_REFERENCE(CANON_FEED_REFERENCE) {}
void SET_FEED_MODE(int, int mode) { write_setting(Setting::feed_mode, mode); }
void SET_MOTION_CONTROL_MODE(CANON_MOTION_MODE mode, double tolerance) {
  state.mode = mode;
  state.tolerance = tolerance;
  write_setting(Setting::path_mode, mode, tolerance);
}
void SET_NAIVECAM_TOLERANCE(double tolerance) { state.naive = tolerance; }
void SET_CUTTER_RADIUS_COMPENSATION(double) {}
void START_CUTTER_RADIUS_COMPENSATION(int side) { write_setting(Setting::compensation, side); }
void STOP_CUTTER_RADIUS_COMPENSATION() { write_setting(Setting::compensation, 0); }
void START_SPEED_FEED_SYNCH(int, double feed, bool) { write_setting(Setting::synchronous, feed); }
void STOP_SPEED_FEED_SYNCH() { write_setting(Setting::synchronous, 0); }
void STOP() {}
void DWELL(double seconds) { write_setting(Setting::dwell, seconds); }

// --- spindle, tool, coolant

void SET_SPINDLE_MODE(int spindle, double mode) {
  if (spindle == 0) write_setting(Setting::surface_speed, mode);
}
void SPINDLE_RETRACT_TRAVERSE() {}
void SPINDLE_RETRACT() {}
void START_SPINDLE_CLOCKWISE(int spindle, int) {
  state.direction[spindle_index(spindle)] = CANON_CLOCKWISE;
  if (spindle == 0) write_setting(Setting::spindle_turns, 1);
}
void START_SPINDLE_COUNTERCLOCKWISE(int spindle, int) {
  state.direction[spindle_index(spindle)] = CANON_COUNTERCLOCKWISE;
  if (spindle == 0) write_setting(Setting::spindle_turns, -1);
}
void SET_SPINDLE_SPEED(int spindle, double speed) {
  state.speed[spindle_index(spindle)] = speed;
  if (spindle == 0) write_setting(Setting::spindle_speed, speed);
}
void STOP_SPINDLE_TURNING(int spindle) {
  state.direction[spindle_index(spindle)] = CANON_STOPPED;
  if (spindle == 0) write_setting(Setting::spindle_turns, 0);
}
void ORIENT_SPINDLE(int, double, int) {}
void WAIT_SPINDLE_ORIENT_COMPLETE(int, double) {}
void LOCK_SPINDLE_Z() {}
void USE_SPINDLE_FORCE() {}
void USE_NO_SPINDLE_FORCE() {}
void SET_TOOL_TABLE_ENTRY(int pocket, int number, EmcPose tool_offset, double diameter, double front, double back,
                          int orientation) {
  auto& table = tool_table();
  if (pocket < 0 || pocket >= std::ssize(table)) return;
  CANON_TOOL_TABLE& tool = table[pocket];
  tool.toolno = number;
  tool.offset = tool_offset;
  tool.diameter = diameter;
  tool.frontangle = front;
  tool.backangle = back;
  tool.orientation = orientation;
}
void START_CHANGE() {}
void SELECT_TOOL(int number) { write_setting(Setting::tool_selected, number); }
void CHANGE_TOOL(int slot) {
  load_tool(slot);
  state.slot = slot;
  write_setting(Setting::tool_change, tool_table()[0].toolno > 0 ? tool_table()[0].toolno : 0);
}
void CHANGE_TOOL_NUMBER(int slot) {
  load_tool(slot);
  state.slot = slot;
  write_setting(Setting::tool_change, tool_table()[0].toolno > 0 ? tool_table()[0].toolno : 0);
}
void RELOAD_TOOLDATA() {}
void FLOOD_ON() {
  state.flood = true;
  write_setting(Setting::flood, 1);
}
void FLOOD_OFF() {
  state.flood = false;
  write_setting(Setting::flood, 0);
}
void MIST_ON() {
  state.mist = true;
  write_setting(Setting::mist, 1);
}
void MIST_OFF() {
  state.mist = false;
  write_setting(Setting::mist, 0);
}

// --- the program

void COMMENT(const char* text) {
  if (std::strncmp(text, marker_prefix, std::strlen(marker_prefix)) != 0) return;
  write_text(Kind::marker, 0, current_line(), text + std::strlen(marker_prefix));
  block_ran();
}
void PROGRAM_STOP() { write_setting(Setting::stop, 0); }
void OPTIONAL_PROGRAM_STOP() { write_setting(Setting::stop, 1); }
void PROGRAM_END() {}
void SET_OPTIONAL_PROGRAM_STOP(bool on) { state.optional_stop = on; }
bool GET_OPTIONAL_PROGRAM_STOP() { return state.optional_stop; }
void SET_BLOCK_DELETE(bool on) { state.block_delete = on; }
bool GET_BLOCK_DELETE() { return state.block_delete; }
void CANON_ERROR(const char* format, ...) {
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  stop(Stop::program, text);
}
void FINISH() {}
void ON_RESET() {}
void UPDATE_TAG(StateTag) { block_ran(); }
void MESSAGE(char*) {}
void LOG(char*) {}
void LOGOPEN(char*) {}
void LOGAPPEND(char*) {}
void LOGCLOSE() {}
void PLUGIN_CALL(int, const char*) {}
void IO_PLUGIN_CALL(int, const char*) {}
void PALLET_SHUTTLE() {}
void TURN_PROBE_ON() {}
void TURN_PROBE_OFF() {}
void CLAMP_AXIS(CANON_AXIS) {}
void UNCLAMP_AXIS(CANON_AXIS) {}
int UNLOCK_ROTARY(int, int) { return 0; }
int LOCK_ROTARY(int, int) { return 0; }
void ENABLE_ADAPTIVE_FEED() {}
void DISABLE_ADAPTIVE_FEED() {}
void ENABLE_FEED_OVERRIDE() {}
void DISABLE_FEED_OVERRIDE() {}
void ENABLE_SPEED_OVERRIDE(int) {}
void DISABLE_SPEED_OVERRIDE(int) {}
void ENABLE_FEED_HOLD() {}
void DISABLE_FEED_HOLD() {}
void NURB_KNOT_VECTOR() {}
void NURB_CONTROL_POINT(int, double, double, double, double) {}
void NURB_FEED(double, double) {}
void SET_MOTION_OUTPUT_BIT(int) {}
void CLEAR_MOTION_OUTPUT_BIT(int) {}
void SET_AUX_OUTPUT_BIT(int) {}
void CLEAR_AUX_OUTPUT_BIT(int) {}
void SET_MOTION_OUTPUT_VALUE(int, double) {}
void SET_AUX_OUTPUT_VALUE(int, double) {}
int WAIT(int, int, int, double) { return 0; }

// --- what the interpreter asks for

double GET_EXTERNAL_FEED_RATE() { return state.feed; }
int GET_EXTERNAL_FLOOD() { return state.flood ? 1 : 0; }
int GET_EXTERNAL_MIST() { return state.mist ? 1 : 0; }
CANON_UNITS GET_EXTERNAL_LENGTH_UNIT_TYPE() {
  return state.unit == 25.4 ? CANON_UNITS_INCHES : state.unit == 10.0 ? CANON_UNITS_CM : CANON_UNITS_MM;
}
double GET_EXTERNAL_LENGTH_UNITS() { return 1.0; }
double GET_EXTERNAL_ANGLE_UNITS() { return 1.0; }
CANON_MOTION_MODE GET_EXTERNAL_MOTION_CONTROL_MODE() { return state.mode; }
double GET_EXTERNAL_MOTION_CONTROL_TOLERANCE() { return state.tolerance; }
double GET_EXTERNAL_MOTION_CONTROL_NAIVECAM_TOLERANCE() { return state.naive; }
void GET_EXTERNAL_PARAMETER_FILE_NAME(char* name, int size) {
  // No such file may be there: the interpreter would rename it.
  std::strncpy(name, "/nonexistent/thermotwin.var", size);
  name[size - 1] = 0;
}
void SET_PARAMETER_FILE_NAME(const char*) {}
CANON_PLANE GET_EXTERNAL_PLANE() { return state.plane; }
double GET_EXTERNAL_POSITION_X() { return position_of(0); }
double GET_EXTERNAL_POSITION_Y() { return position_of(1); }
double GET_EXTERNAL_POSITION_Z() { return position_of(2); }
double GET_EXTERNAL_POSITION_A() { return position_of(3); }
double GET_EXTERNAL_POSITION_B() { return position_of(4); }
double GET_EXTERNAL_POSITION_C() { return position_of(5); }
double GET_EXTERNAL_POSITION_U() { return position_of(6); }
double GET_EXTERNAL_POSITION_V() { return position_of(7); }
double GET_EXTERNAL_POSITION_W() { return position_of(8); }
// A probe touches at the end of its move.
double GET_EXTERNAL_PROBE_POSITION_X() { return position_of(0); }
double GET_EXTERNAL_PROBE_POSITION_Y() { return position_of(1); }
double GET_EXTERNAL_PROBE_POSITION_Z() { return position_of(2); }
double GET_EXTERNAL_PROBE_POSITION_A() { return position_of(3); }
double GET_EXTERNAL_PROBE_POSITION_B() { return position_of(4); }
double GET_EXTERNAL_PROBE_POSITION_C() { return position_of(5); }
double GET_EXTERNAL_PROBE_POSITION_U() { return position_of(6); }
double GET_EXTERNAL_PROBE_POSITION_V() { return position_of(7); }
double GET_EXTERNAL_PROBE_POSITION_W() { return position_of(8); }
double GET_EXTERNAL_PROBE_VALUE() { return 0.0; }
int GET_EXTERNAL_PROBE_TRIPPED_VALUE() { return 1; }
int GET_EXTERNAL_QUEUE_EMPTY() { return 1; }
double GET_EXTERNAL_SPEED(int spindle) { return state.speed[spindle_index(spindle)]; }
CANON_DIRECTION GET_EXTERNAL_SPINDLE(int spindle) {
  const CANON_DIRECTION direction = state.direction[spindle_index(spindle)];
  return direction == 0 ? CANON_STOPPED : direction;
}
double GET_EXTERNAL_TOOL_LENGTH_XOFFSET() { return state.tool[0] / state.unit; }
double GET_EXTERNAL_TOOL_LENGTH_YOFFSET() { return state.tool[1] / state.unit; }
double GET_EXTERNAL_TOOL_LENGTH_ZOFFSET() { return state.tool[2] / state.unit; }
double GET_EXTERNAL_TOOL_LENGTH_AOFFSET() { return state.tool[3]; }
double GET_EXTERNAL_TOOL_LENGTH_BOFFSET() { return state.tool[4]; }
double GET_EXTERNAL_TOOL_LENGTH_COFFSET() { return state.tool[5]; }
double GET_EXTERNAL_TOOL_LENGTH_UOFFSET() { return state.tool[6] / state.unit; }
double GET_EXTERNAL_TOOL_LENGTH_VOFFSET() { return state.tool[7] / state.unit; }
double GET_EXTERNAL_TOOL_LENGTH_WOFFSET() { return state.tool[8] / state.unit; }
int GET_EXTERNAL_TOOL_SLOT() { return state.slot; }
int GET_EXTERNAL_SELECTED_TOOL_SLOT() { return state.selected; }
CANON_TOOL_TABLE GET_EXTERNAL_TOOL_TABLE(int pocket) {
  const auto& table = tool_table();
  if (pocket < 0 || pocket >= std::ssize(table)) return no_tool();
  return table[pocket];
}
int GET_EXTERNAL_TC_FAULT() { return 0; }
int GET_EXTERNAL_TC_REASON() { return 0; }
double GET_EXTERNAL_TRAVERSE_RATE() { return 1000.0; }
int GET_EXTERNAL_FEED_OVERRIDE_ENABLE() { return 1; }
int GET_EXTERNAL_SPINDLE_OVERRIDE_ENABLE(int) { return 1; }
int GET_EXTERNAL_ADAPTIVE_FEED_ENABLE() { return 0; }
int GET_EXTERNAL_FEED_HOLD_ENABLE() { return 1; }
int GET_EXTERNAL_DIGITAL_INPUT(int, int otherwise) { return otherwise; }
double GET_EXTERNAL_ANALOG_INPUT(int, double otherwise) { return otherwise; }
int GET_EXTERNAL_AXIS_MASK() { return state.axis_mask; }
int GET_EXTERNAL_OFFSET_APPLIED() { return 0; }
EmcPose GET_EXTERNAL_OFFSETS() { return EmcPose{}; }
USER_DEFINED_FUNCTION_TYPE USER_DEFINED_FUNCTION[USER_DEFINED_FUNCTION_NUM] = {};
int USER_DEFINED_FUNCTION_ADD(USER_DEFINED_FUNCTION_TYPE, int) { return -1; }
