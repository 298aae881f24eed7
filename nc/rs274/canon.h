// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// The canonical functions that the interpreter calls, as records. They keep what the interpreter asks back: position,
// plane, feed, spindle, offsets. Lengths are in the program's unit; the machine's unit is the millimetre.

namespace thermotwin::nc::rs274 {

/// Comments that begin so are markers of the control profile.
inline constexpr const char* marker_prefix = "thermotwin:";

/// Position at the start, in mm and deg of the machine.
void start_at(const double (&position)[9]);
/// Axes of the machine, bit 0: X.
void set_axis_mask(int mask);
/// Whether lines that begin with / are left out.
void set_block_delete(bool on);

}  // namespace thermotwin::nc::rs274
