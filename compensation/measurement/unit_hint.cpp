// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/unit_hint.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

namespace thermotwin::compensation {
namespace {

using Eigen::ArrayXd;

constexpr double least_correlation = 0.9, closest = 2.0, better = 0.75, above_noise = 3.0;
constexpr Eigen::Index least_rows = 8;
constexpr double fahrenheit_factor = 1.8, fahrenheit_zero = 32.0, fahrenheit_off = 4.0;

/// What the numbers would be in the unit: a number in `unit` is `factor` times that in the stated unit.
struct OtherUnit {
  double factor;
  const char* name;
};

std::vector<OtherUnit> other_units(const std::string& stated) {
  if (stated == "um")
    return {{1.0, ""},
            {1e-3, "mm"},
            {1e-6, "m"},
            {1e3, "nm"},
            {1e3 / 25.4, "micro-inches"},
            {1.0 / 25.4, "thousandths of an inch"},
            {25.4, "a conversion from inches applied to micrometres"}};
  if (stated == "um/m")
    return {{1.0, ""},
            {1e-3, "mrad"},
            {1e-6, "rad"},
            {1e3, "nrad"},
            {180.0 * 3600.0 / std::numbers::pi * 1e-6, "arc seconds"},
            {180.0 / std::numbers::pi * 1e-6, "degrees"}};
  return {};
}

double rms(const ArrayXd& values) { return std::sqrt(values.square().mean()); }

std::optional<UnitHint> fahrenheit(const ArrayXd& measured, const ArrayXd& predicted) {
  const ArrayXd converted = (measured - fahrenheit_zero) / fahrenheit_factor;
  const double stated = rms(measured - predicted), changed = rms(converted - predicted);
  // Degrees Celsius are left where both agree: -40.
  if (!(changed < 0.1 * stated) || changed > fahrenheit_off) return std::nullopt;
  return UnitHint{fahrenheit_factor, "its numbers may be degrees Fahrenheit", stated, changed};
}

}  // namespace

std::optional<UnitHint> unit_hint(const MeasuredChannel& channel, const Eigen::VectorXd& all_measured,
                                  const Eigen::VectorXd& all_predicted) {
  std::vector<double> in_record, in_model;
  for (Eigen::Index i = 0; i < all_measured.size(); ++i) {
    if (!std::isfinite(all_measured[i]) || !std::isfinite(all_predicted[i])) continue;
    in_record.push_back(all_measured[i]);
    in_model.push_back(all_predicted[i]);
  }
  if (std::ssize(in_record) < least_rows) return std::nullopt;
  ArrayXd measured = Eigen::Map<const ArrayXd>(in_record.data(), std::ssize(in_record)),
          predicted = Eigen::Map<const ArrayXd>(in_model.data(), std::ssize(in_model));
  if (channel.kind == ChannelKind::temperature) return fahrenheit(measured, predicted);
  measured -= measured.mean();
  predicted -= predicted.mean();
  const double size = std::sqrt(predicted.square().sum()), own = std::sqrt(measured.square().sum()),
               product = (measured * predicted).sum();
  if (!(size > 0.0 && own > 0.0) || std::abs(product) < least_correlation * size * own) return std::nullopt;
  // A direction that hardly moves has no sign.
  if (rms(predicted) < above_noise * channel.uncertainty) return std::nullopt;
  const double fitted = product / (size * size);
  const OtherUnit* nearest = nullptr;
  const std::vector<OtherUnit> units = other_units(channel.unit);
  const auto apart = [&](const OtherUnit& unit) { return std::abs(std::log(std::abs(fitted) / unit.factor)); };
  for (const OtherUnit& unit : units)
    if (nearest == nullptr || apart(unit) < apart(*nearest)) nearest = &unit;
  if (nearest == nullptr || apart(*nearest) > std::log(closest)) return std::nullopt;
  const bool reversed = fitted < 0.0, same_unit = nearest->factor == 1.0;
  if (same_unit && !reversed) return std::nullopt;
  const double factor = (reversed ? -1.0 : 1.0) * nearest->factor;
  const double stated = rms(measured - predicted), changed = rms(measured / factor - predicted);
  if (changed > better * stated) return std::nullopt;
  UnitHint hint{factor, "", stated, changed};
  if (!same_unit) hint.words = fmt::format("its numbers may be {}", nearest->name);
  if (reversed) hint.words += std::string(same_unit ? "" : ", and ") + "its sign may be reversed";
  return hint;
}

std::string in_words(const UnitHint& hint, const MeasuredChannel& channel) {
  if (channel.kind == ChannelKind::temperature) {
    return fmt::format(
        "Channel {}: {}, although channels.toml states degC. So converted they differ from the simulation by {:.3g} K "
        "RMS, as stated by {:.3g} K.",
        channel.id, hint.words, hint.rms_changed, hint.rms_stated);
  }
  return fmt::format(
      "Channel {}: {}. Recorded numbers of {:.4g} times the simulation fit: divided by this factor they differ from "
      "it by {:.3g} {} RMS, as stated by {:.3g} {}. Allowed: unit = \"{}\", error = tool minus table along the axes "
      "of the frame.",
      channel.id, hint.words, hint.factor, hint.rms_changed, channel.unit, hint.rms_stated, channel.unit, channel.unit);
}

}  // namespace thermotwin::compensation
