// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/probe/raw_signals.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::metrology {

using core::InputError;
using core::Table;
using Eigen::Index;

namespace {

/// First and last sample of each point.
struct Span {
  Index first = -1, last = -1;
};

std::vector<Span> spans_of(const Table& raw, Index points) {
  const auto column = raw.find("point");
  if (!column) throw InputError(raw.source + ":1", "no column point", "time_s, point and a column for each probe");
  std::vector<Span> spans(points);
  for (Index i = 0; i < raw.rows(); ++i) {
    const double number = raw.values(i, *column);
    if (std::isnan(number)) continue;
    if (number != std::round(number) || number < 1 || number > points) {
      throw InputError(fmt::format("{}:{} point", raw.source, Table::line_of_row(i)), fmt::format("{}", number),
                       fmt::format("a row of points.csv, 1 to {}, or a blank", points));
    }
    Span& span = spans[static_cast<Index>(number) - 1];
    if (span.first < 0) span.first = i;
    span.last = i;
  }
  for (Index p = 0; p < points; ++p) {
    if (spans[p].first < 0) {
      throw InputError(raw.source, fmt::format("no sample of point {}", p + 1),
                       "samples of each row of points.csv; leave out the row of a point that was not measured");
    }
  }
  return spans;
}

}  // namespace

RawSignals RawSignals::load(const std::filesystem::path& folder) {
  for (const char* name : {"raw.csv", "calibration.csv"}) {
    if (!std::filesystem::is_regular_file(folder / name))
      throw InputError(folder.string(), std::string("no file ") + name,
                       "raw.csv and calibration.csv, or columns dx_um, dy_um, dz_um in points.csv");
  }
  return {core::read_csv(folder / "raw.csv"), core::read_csv(folder / "calibration.csv")};
}

std::vector<Eigen::Vector3d> sphere_displacements(const RawSignals& signals, const ProbeSetup& setup, Index points,
                                                  CalibrationCheck* check) {
  const Table& raw = signals.raw;
  core::require_time_column(raw);
  const Calibration calibration = Calibration::fit(signals.calibration, setup.contact_radius);
  CalibrationCheck checked = check_calibration(calibration, setup, signals.calibration.source);
  std::vector<Index> columns;
  for (const std::string& name : calibration.names()) {
    const auto found = raw.find(name);
    if (!found) {
      throw InputError(raw.source + ":1", "no column " + name,
                       "the probes of the calibration: " + core::join(calibration.names()));
    }
    columns.push_back(*found);
  }
  const std::vector<Span> spans = spans_of(raw, points);
  const Index of_point = *raw.find("point");
  std::vector<Eigen::Vector3d> displacements;
  for (Index p = 0; p < points; ++p) {
    const auto [first, last] = spans[p];
    const double from = raw.values(first, 0) + setup.cut - 1e-9, to = raw.values(last, 0) - setup.cut + 1e-9;
    const bool whole = setup.record <= 0.0 || first == last;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(std::ssize(columns));
    Index count = 0;
    for (Index i = first; i <= last; ++i) {
      if (raw.values(i, of_point) != p + 1) continue;
      if (!whole && (raw.values(i, 0) < from || raw.values(i, 0) > to)) continue;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const double reading = raw.values(i, columns[k]);
        if (!(std::abs(reading) <= 1e5)) {
          throw InputError(fmt::format("{}:{} {}", raw.source, Table::line_of_row(i), raw.columns[columns[k]]),
                           std::isnan(reading) ? std::string("a missing reading") : fmt::format("{}", reading),
                           "a number of at most 1e5 um; leave out the row of a sample that was not taken");
        }
        sum[k] += reading * core::units::um;
      }
      ++count;
    }
    if (count == 0) {
      throw InputError(
          fmt::format("{}:{}", raw.source, Table::line_of_row(first)),
          fmt::format("a record of {:.4g} s of point {}", raw.values(last, 0) - raw.values(first, 0), p + 1),
          fmt::format("more than twice cut_s = {} s", setup.cut));
    }
    const Eigen::VectorXd reading = sum / (1.0 * count);
    checked.see(reading, raw.source, calibration);
    displacements.push_back(calibration.displacement(reading));
  }
  if (check != nullptr) *check = checked;
  return displacements;
}

}  // namespace thermotwin::metrology
