// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/online_model.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/range.h"

namespace thermotwin::compensation {

const char* status_text(Status status) {
  switch (status) {
    case Status::ok: return "ok";
    case Status::no_sensors: return "no_sensors";
    case Status::outside_workspace: return "outside_workspace";
    case Status::input_missing: return "input_missing";
    case Status::sensor_failed: return "sensor_failed";
    case Status::limited: return "limited";
    case Status::failed: return "failed";
  }
  return "";
}

void check_probe_std(double std_um) {
  core::require_within("compensator probe std_um", std_um, {1e-3, largest_probe_um});
}

void check_probe(const Eigen::Vector3d& error_um, double std_um) {
  for (const double value : error_um) {
    if (std::abs(value) > largest_probe_um) {
      throw core::InputError("compensator probe", fmt::format("{} um", value),
                             fmt::format("at most {} um, or NaN", largest_probe_um));
    }
  }
  check_probe_std(std_um);
}

}  // namespace thermotwin::compensation
