// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/dialect/siemens_places.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/units.h"
#include "nc/control/letters.h"

namespace thermotwin::nc {

using core::InputError;

SiemensPlaces::SiemensPlaces(const ControlProfile& control, const Nine& start) : control_(control) {
  for (int i = 0; i < 9; ++i) turned_[i] = start[i] / core::units::deg;
}

void SiemensPlaces::use_work_offset(int number) {
  work_ = number;
  forget();
}

void SiemensPlaces::change_unit(double factor) {
  for (int i = 0; i < 9; ++i)
    if (!is_angle(i)) shift_[i] *= factor;
  forget();
}

void SiemensPlaces::forget() { at_.fill(std::nullopt); }

double SiemensPlaces::shortest(int axis, const SiemensValue& value, const std::string& place) const {
  if (!is_angle(axis))
    throw InputError(place, fmt::format("DC, ACP or ACN of {}", letters[axis]), "rotary axes: A, B, C");
  constexpr double same = 1e-9;  // deg: there already
  const double turns = (turned_[axis] - frame_of(axis) - value.number) / 360.0;
  const double whole = value.sense == SiemensSense::shortest   ? std::round(turns)
                       : value.sense == SiemensSense::positive ? std::ceil(turns - same)
                                                               : std::floor(turns + same);
  return value.number + 360.0 * whole;
}

/// deg, from the machine's zero to the program's
double SiemensPlaces::frame_of(int axis) const {
  double sum = shift_[axis];
  for (const WorkOffset& offset : control_.work_offsets)
    if (offset.number == work_) sum += offset.offset[axis] / core::units::deg;
  return sum;
}

void SiemensPlaces::turn_to(int axis, const SiemensValue& value, bool machine) {
  if (value.sense == SiemensSense::incremental)
    turned_[axis] += value.number;
  else
    turned_[axis] = value.number + (machine ? 0.0 : frame_of(axis));
}

void SiemensPlaces::write(SiemensCoordinates axes, bool machine, bool tool_length, const std::string& place,
                          std::string& text) {
  int all = 0, absolute = 0;
  for (int i = 0; i < 9; ++i) {
    if (!axes[i]) continue;
    SiemensValue& value = *axes[i];
    if (value.sense == SiemensSense::shortest || value.sense == SiemensSense::positive ||
        value.sense == SiemensSense::negative)
      value = {shortest(i, value, place), SiemensSense::absolute};
    if (value.sense == SiemensSense::modal)
      value.sense = absolute_ ? SiemensSense::absolute : SiemensSense::incremental;
    ++all;
    absolute += value.sense == SiemensSense::absolute ? 1 : 0;
  }
  if (all == 0) return;
  if (machine && tool_length)
    throw InputError(place, "machine coordinates with a tool length (SUPA, G53, G153)",
                     "D0 in this or an earlier block");
  // All of one sense as they stand; of both senses by the places that are known.
  const bool as_absolute = absolute == all || (absolute != 0 && absolute_);
  if (as_absolute != written_absolute_) {
    text += as_absolute ? " G90" : " G91";
    written_absolute_ = as_absolute;
  }
  if (machine) text += " G53";
  for (int i = 0; i < 9; ++i) {
    if (!axes[i]) continue;
    const SiemensValue& value = *axes[i];
    const bool is_absolute = value.sense == SiemensSense::absolute;
    if (is_absolute != as_absolute && !at_[i])
      throw InputError(place,
                       fmt::format("{} with AC or IC beside other coordinates, from an unknown place", letters[i]),
                       "all coordinates of the block in one sense, or an absolute move of the axis before");
    const double number = is_absolute == as_absolute ? value.number
                          : as_absolute              ? *at_[i] + value.number
                                                     : value.number - *at_[i];
    text += fmt::format(" {}{}", letters[i], number_text(number));
    turn_to(i, value, machine);
    if (machine) {
      at_[i].reset();
    } else if (is_absolute) {
      at_[i] = value.number;
    } else if (at_[i]) {
      at_[i] = *at_[i] + value.number;
    }
  }
}

}  // namespace thermotwin::nc
