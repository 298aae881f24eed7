// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The page of `validate`: what is removed on each machine, one machine over time, the verb's tables.

#include <string>

#include "compensation/evaluation/failed_sensors.h"
#include "compensation/evaluation/power_off.h"
#include "compensation/evaluation/restart.h"
#include "compensation/evaluation/validation.h"
#include "tools/options.h"

namespace thermotwin::tools {

struct ValidationHead {
  const ValidateOptions& options;
  std::string machine;    ///< its name
  std::string truth;      ///< what was measured, in words
  std::string perturbed;  ///< which parameters
};

/// @param full  the same study on full models where `main` is on reduced ones; may be nullptr
/// @return a self-contained HTML document
std::string validation_page(const ValidationHead& head, const compensation::Validation& main,
                            const compensation::Validation* full);
std::string validation_page(const ValidationHead& head, const compensation::PowerOffStudy& main,
                            const compensation::PowerOffStudy* full);
std::string validation_page(const ValidationHead& head, const compensation::RestartStudy& main,
                            const compensation::RestartStudy* full);
std::string validation_page(const ValidationHead& head, const compensation::FailedSensorStudy& main,
                            const compensation::FailedSensorStudy* full);

}  // namespace thermotwin::tools
