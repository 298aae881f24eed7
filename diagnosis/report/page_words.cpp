// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/page_words.h"

#include <fmt/format.h>

#include "core/page_text.h"
#include "core/text.h"
#include "diagnosis/report/words.h"

namespace thermotwin::diagnosis {

std::string percent(double value) { return percent_text(value, 1) + "&#8239;%"; }

std::string probability(double p) {
  if (p < 1e-3) return "&lt; 0.001";
  if (p > 0.999) return "&gt; 0.999";
  return fmt::format("{:.3f}", p);
}

std::string display_unit(const std::string& unit) { return unit == "1" ? "" : core::unit_text(unit); }

std::string two_digits(double value) { return core::plain_number(value, 2); }

Wording wording(const Diagnosis& d, const mesh::Machine* machine) {
  const std::string measurement = d.measurement.empty() ? "without a name" : d.measurement;
  if (machine != nullptr) {
    return {machine->name, "model of the machine against the record in " + measurement, "TCP residual",
            "stated uncertainty, discretisation error and noise", "stated uncertainty, discretisation error, noise"};
  }
  return {measurement, "measured record; model: a lag model fitted to its first part", "residual",
          "uncertain gains, usual drift and noise", "uncertain gains, usual drift, noise"};
}

std::string estimate(const RankedCause& cause) {
  const std::string unit = display_unit(cause.parameter.unit);
  return fmt::format("{} {} ± {}{}{}", core::xml_text(cause.parameter.name), core::plain_number(cause.value, 4),
                     two_digits(cause.std), unit.empty() ? "" : " ", unit);
}

bool shows_change(const Diagnosis& d, const mesh::Machine* machine) { return machine != nullptr || !d.causes.empty(); }

}  // namespace thermotwin::diagnosis
