component thermotwin_guard "Guard of thermal offsets: limit, rate, heartbeat, hold, return to zero";
description """
Stands between offsets that a program computes and the external offsets of the axes. Pins of one number belong to one
axis.
Offsets follow what is wanted within
.B limit-um
and
.B rate-um-s
while
.B heartbeat
changes. Beyond this rate they may change by
.B slope-um-N
for each unit that axis N moves, as an error changes over the workspace. A heartbeat that stands is a
program that is gone: offsets are held for
.B hold-s
seconds, then return to zero at
.B return-um-s.
LinuxCNC drops external offsets without a word when the machine goes off and when an axis is homed.
.B eoffset
tells the guard; it goes on from there within the rate.
""";
license "GPL-3.0-or-later";
author "thermotwin";
option singleton no;
option personality yes;

pin in float wanted_um-#[9:personality] "Offset that is wanted, um; a value that is no number counts as none";
pin in float position-#[9:personality] "Position of the axis, in the machine's unit";
pin in float eoffset-#[9:personality] "axis.L.eoffset, what LinuxCNC applies, in the machine's unit";
pin in u32 heartbeat "Changes with every new set of wanted offsets";
pin in bit machine_is_on "Machine on: motion.motion-enabled";
pin in bit enable = 1 "FALSE: return to zero at return-um-s";
pin out s32 counts-#[9:personality] "For axis.L.eoffset-counts";
pin out float offset_um-#[9:personality] "Offset that is applied, um";
pin out s32 state "0 follows, 1 limited, 2 holds, 3 returns to zero, 4 machine off";
pin out float age_s "Time since the heartbeat changed, s";
param rw float limit_um = 100 "Largest offset, um";
param rw float rate_um_s = 1 "Fastest change of an offset while no axis moves, um/s";
param rw float return_um_s = 1 "Fastest change on the way to zero, um/s";
param rw float hold_s = 10 "Offsets are held for so long without a heartbeat, s";
param rw float counts_per_um = 1000 "Counts of an um: 1e-3 / (axis.L.eoffset-scale in mm)";
param rw float um_per_unit = 1000 "um in the machine's unit of length";
param rw float slope_um-#[9:personality] = 0 "Change of offsets that a unit of this axis' motion allows, um";
param rw float fastest-#[9:personality] = 0 "Fastest motion of the axis, units/s; more counts as no motion";
variable double last_um[9];
variable double last_position[9];
variable double room_um;
variable double dropped_um[9];
variable double apart_s[9];
variable double silent_s = 1e9;
variable hal_u32_t last_beat;

function _ fp;
;;
#include <rtapi_math.h>

#define shown_after_s 1.0 /* a pause of a second is no silence yet */
#define kept_s 0.1
#define seen_um 1e-3
#define apart_um 0.02
#define dropped_after_s 0.1

enum { follows, limited, holds, returns, off };

static double clamped(double value, double low, double high) {
  if (value < low) return low;
  return value > high ? high : value;
}

/* A parameter that is no number, or negative, moves nothing. */
static double positive(double value) { return value > 0 ? value : 0; }

/* What the axes' motion allows. The model answers a few periods later: what it allows is kept for a tenth of a
 * second. */
static double motion_um(struct __comp_state* __comp_inst, double dt) {
  int i;
  room_um *= dt < kept_s ? 1 - dt / kept_s : 0;
  for (i = 0; i < personality; ++i) {
    const double moved = fabs(position(i) - last_position[i]);
    if (moved <= fastest(i) * dt) room_um += positive(slope_um(i)) * moved;
    last_position[i] = position(i);
  }
  return room_um;
}

/* Whether LinuxCNC applies another offset than it was given, though that has not moved for a while. */
static int is_dropped(struct __comp_state* __comp_inst, int i, int still, double dt) {
  const int apart = fabs(eoffset(i) * um_per_unit - offset_um(i)) > apart_um;
  apart_s[i] = apart && still ? apart_s[i] + dt : 0;
  return apart_s[i] > dropped_after_s;
}

FUNCTION(_) {
  const double dt = period * 1e-9, limit = positive(limit_um), still = positive(rate_um_s) * dt;
  double reach = still + motion_um(__comp_inst, dt), used = 0;
  int i, valid = 1, behind = 0, now = follows;
  silent_s = heartbeat != last_beat ? 0.0 : silent_s + dt;
  last_beat = heartbeat;
  age_s = silent_s;
  for (i = 0; i < personality; ++i) valid = valid && isfinite(wanted_um(i));
  /* Values of a program that is gone are no news, whatever its pins still say. */
  if (silent_s == 0.0 && valid)
    for (i = 0; i < personality; ++i) last_um[i] = wanted_um(i);
  if (!machine_is_on)
    now = off;
  else if (!enable || !(silent_s <= hold_s))
    now = returns, reach = positive(return_um_s) * dt;
  else if (silent_s > shown_after_s)
    now = holds, reach = 0;
  for (i = 0; i < personality; ++i) {
    const double applied = offset_um(i), aim = now == returns ? 0 : clamped(last_um[i], -limit, limit);
    offset_um(i) = now == off ? 0 : clamped(aim, applied - reach, applied + reach);
    if (now != off && fabs(offset_um(i) - applied) > used) used = fabs(offset_um(i) - applied);
    if (is_dropped(__comp_inst, i, fabs(offset_um(i) - applied) <= still, dt)) {
      dropped_um[i] += offset_um(i) - eoffset(i) * um_per_unit; /* counts stay: LinuxCNC adds their changes */
      offset_um(i) = eoffset(i) * um_per_unit;
    }
    behind = behind || fabs(offset_um(i) - last_um[i]) > seen_um;
    counts(i) = (int)floor((offset_um(i) + dropped_um[i]) * counts_per_um + 0.5);
  }
  if (used > still) room_um = positive(room_um - (used - still));
  state = now == follows && behind ? limited : now;
}
