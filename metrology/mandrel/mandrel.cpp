// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/mandrel/mandrel.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/config.h"
#include "core/error.h"
#include "core/text.h"
#include "core/unique_id.h"
#include "core/units.h"
#include "diagnosis/statistics/statistics.h"
#include "metrology/rtest/result_folder.h"

namespace thermotwin::metrology {

using core::Absent;
using core::InputError;
using core::Node;
using core::Table;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
namespace key = core::key;
namespace units = core::units;

namespace {

constexpr double largest_um = 1e5;
constexpr double least_apart = 1e-4, least_turn = 1e-3;  ///< m; rad: two probes that would show a rotation

const std::vector<std::string>& quantity_names() {
  static const std::vector<std::string> names{"dx", "dy", "dz", "ra", "rb", "rc"};
  return names;
}

const core::KeyTable probe_table{
    "probe",
    "A probe beside the mandrel.",
    {
        key::text("id", core::required, "Its name; its readings are the column <id>_um."),
        key::point("at_mm", "mm", core::required, "Point on the mandrel at which the probe measures."),
        key::point("direction", "", core::required, "Its reading rises when the mandrel moves in this direction."),
        key::number("std_um", "um", core::positive, core::required, "Standard uncertainty of a reading."),
        key::number("place_std_mm", "mm", core::non_negative, 0.0,
                    "Standard uncertainty of each coordinate of `at_mm`."),
    }};

const core::KeyTable mandrel_file{
    "mandrel.toml",
    "Probes around a test mandrel for `measure analyse`, beside readings.csv.",
    {
        key::schema(),
        key::tables("probe", probe_table, core::required, "One for each probe."),
        key::point("point_mm", "mm", Absent{"0, 0, 0"},
                   "Functional point at which the displacement is stated, in the frame of the probes' places."),
        key::word("mandrel", {"spindle", "table"}, "spindle",
                  "The side of the machine that carries the mandrel; the other side carries the probes."),
        key::texts("quantities", Absent{"all that the probes observe"},
                   "Quantities to be estimated, of dx, dy, dz, ra, rb, rc; each has to be observable."),
        key::word("reference", {"first", "absolute"}, "first",
                  "first: values against the first row; absolute: values as read. A single row is always absolute."),
        key::text("pose", "", "Positions of the machine's axes, such as X=0,B=90, for diagnose."),
    }};

std::vector<MandrelProbe> read_mandrel_probes(const Node& root) {
  std::vector<MandrelProbe> probes;
  std::vector<std::string> seen;
  for (const Node& node : root.tables("probe")) {
    MandrelProbe probe;
    probe.id = node.text("id");
    core::require_unique_id(probe.id, node.place("id"), seen);
    probe.at = node.vector3("at_mm") * units::mm;
    probe.direction = node.vector3("direction");
    const double length = probe.direction.norm();
    if (!(length > 1e-9 && length < 1e9) || !(probe.at.norm() < 1e3)) {
      throw InputError(node.place(length > 1e-9 && length < 1e9 ? "at_mm" : "direction"),
                       fmt::format("a length of {:.3g}", length > 1e-9 && length < 1e9 ? probe.at.norm() : length),
                       "a direction that is not 0, at a place within 1 km");
    }
    probe.direction /= length;
    probe.std = node.number("std_um") * units::um;
    probe.place_std = node.number("place_std_mm") * units::mm;
    node.finish();
    probes.push_back(std::move(probe));
  }
  for (std::size_t i = 0; i < probes.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double apart = (probes[i].at - probes[k].at).norm();
      const bool parallel = probes[i].direction.cross(probes[k].direction).norm() < least_turn;
      if (!parallel || apart == 0.0 || apart >= least_apart) continue;
      throw InputError(root.place("probe"),
                       fmt::format("probes '{}' and '{}' in one direction, {:.3g} mm apart", probes[k].id, probes[i].id,
                                   apart / units::mm),
                       fmt::format("at least {:.3g} mm, or the same place", least_apart / units::mm));
    }
  }
  if (probes.empty()) throw InputError(root.place("probe"), "no probe", "at least one [[probe]]");
  return probes;
}

MatrixXd read_readings(const Table& table, const std::vector<MandrelProbe>& probes) {
  if (table.rows() == 0) throw InputError(table.source, "no rows", "at least one row of readings");
  core::require_time_column(table);
  std::vector<std::string> names{"time_s"};
  for (const MandrelProbe& probe : probes) names.push_back(probe.id + "_um");
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    if (std::find(names.begin(), names.end(), table.columns[c]) != names.end()) continue;
    throw InputError(fmt::format("{}:1 column {}", table.source, c + 1), "'" + table.columns[c] + "'",
                     "one of: " + core::join(names) + " (nearest: " + core::nearest(table.columns[c], names) + ")");
  }
  MatrixXd readings(table.rows(), std::ssize(probes));
  for (Index p = 0; p < readings.cols(); ++p) {
    const std::string& name = names[p + 1];
    const auto column = table.find(name);
    if (!column) throw InputError(table.source + ":1", "no column " + name, "a column for each probe");
    for (Index i = 0; i < readings.rows(); ++i) {
      const double value = table.values(i, *column);
      if (!(std::abs(value) <= largest_um)) {
        throw InputError(
            fmt::format("{}:{} {}", table.source, Table::line_of_row(i), name),
            std::isnan(value) ? std::string("a missing reading") : fmt::format("{}", value),
            fmt::format("a number of at most {:.0e} um; leave out the row in which a probe failed", largest_um));
      }
      readings(i, p) = value * units::um;
    }
  }
  return readings;
}

/// (probes x quantities) of the unit displacements and rotations.
MatrixXd rows_of(const MandrelRecord& record, const std::vector<std::string>& quantities) {
  const std::vector<std::string>& all = quantity_names();
  MatrixXd rows(std::ssize(record.probes), std::ssize(quantities));
  const double sign = record.in_spindle ? 1.0 : -1.0;
  for (Index p = 0; p < rows.rows(); ++p) {
    const MandrelProbe& probe = record.probes[p];
    const Vector3d turn = (probe.at - record.point).cross(probe.direction);
    for (Index q = 0; q < rows.cols(); ++q) {
      const Index component = std::find(all.begin(), all.end(), quantities[q]) - all.begin();
      rows(p, q) = sign * (component < 3 ? probe.direction[component] : turn[component - 3]);
    }
  }
  return rows;
}

/// Rotations among the values of these quantities, 0 for others.
Vector3d turn_of(const std::vector<std::string>& quantities, const VectorXd& values) {
  const std::vector<std::string>& all = quantity_names();
  Vector3d turn = Vector3d::Zero();
  for (Index k = 0; k < values.size(); ++k) {
    const Index component = std::find(all.begin(), all.end(), quantities[k]) - all.begin();
    if (component >= 3) turn[component - 3] = values[k];
  }
  return turn;
}

}  // namespace

const core::KeyTable& mandrel_keys() { return mandrel_file; }

MandrelRecord MandrelRecord::parse(const std::string& toml, const Table& readings, const std::string& source) {
  const core::Config config = core::Config::parse(toml, source, &mandrel_keys());
  const Node root = config.root();
  root.schema(1);
  MandrelRecord record;
  record.source = source;
  record.probes = read_mandrel_probes(root);
  if (root.has("point_mm")) record.point = root.vector3("point_mm") * units::mm;
  record.in_spindle = root.choice("mandrel") == "spindle";
  record.against_first = root.choice("reference") == "first";
  record.pose = root.text("pose");
  require_pose_text(record.pose, root.place("pose"));
  record.place_of_quantities = root.has("quantities") ? root.place("quantities") : root.place("probe");
  for (const std::string& name : root.texts_or_empty("quantities")) {
    const auto& known = quantity_names();
    const bool twice = std::find(record.quantities.begin(), record.quantities.end(), name) != record.quantities.end();
    if (twice || std::find(known.begin(), known.end(), name) == known.end())
      throw InputError(record.place_of_quantities, "'" + name + (twice ? "' a second time" : "'"),
                       "each once of: " + core::join(known));
    record.quantities.push_back(name);
  }
  root.finish();
  record.readings = read_readings(readings, record.probes);
  record.time = readings.values.col(0);
  record.alone = record.against_first && record.time.size() == 1;
  if (record.alone) record.against_first = false;
  return record;
}

MandrelRecord MandrelRecord::load(const std::filesystem::path& folder) {
  for (const char* name : {"mandrel.toml", "readings.csv"}) {
    if (!std::filesystem::is_regular_file(folder / name))
      throw InputError(folder.string(), std::string("no file ") + name, "a folder with mandrel.toml and readings.csv");
  }
  const core::Config config = core::Config::load(folder / "mandrel.toml");
  return parse(config.text(), core::read_csv(folder / "readings.csv"), config.source());
}

Estimates analyse(const MandrelRecord& record) {
  const std::vector<std::string> asked = record.quantities.empty() ? quantity_names() : record.quantities;
  const MatrixXd rows = rows_of(record, asked);
  VectorXd weight(rows.rows());
  for (Index p = 0; p < weight.size(); ++p) weight[p] = 1.0 / record.probes[p].std;
  const MatrixXd weighted = weight.asDiagonal() * rows;
  const LinearFit shape = fit_linear(weighted, VectorXd::Zero(rows.rows()));
  Estimates result;
  std::vector<Index> kept;
  for (Index q = 0; q < rows.cols(); ++q) {
    const std::string& name = asked[q];
    if (!shape.hides(q)) {
      kept.push_back(q);
      result.errors.push_back(name);
      result.units.emplace_back(name[0] == 'r' ? "um/m" : "um");
      continue;
    }
    result.not_observable.push_back(name + ": not observable: " + shape.same_effect(asked, q, ""));
  }
  if (kept.empty() || (!record.quantities.empty() && !result.not_observable.empty())) {
    throw InputError(
        record.place_of_quantities, "a singular arrangement of probes: " + core::join(result.not_observable, "; "),
        kept.empty() ? "probes that distinguish at least one quantity" : "quantities that the probes distinguish");
  }
  // The value of a hidden direction is free; the observable ones do not depend on it.
  const MatrixXd solve = shape.cofactor * weighted.transpose();  // (quantities x probes), of weighted readings
  Vector3d first_turn = Vector3d::Zero();
  for (Index i = 0; i < record.readings.rows(); ++i) {
    const VectorXd reading = record.readings.row(i);
    const VectorXd value = solve * (weight.asDiagonal() * reading);
    CycleResult cycle;
    cycle.time = record.time[i];
    cycle.parameters = rows.cols();
    cycle.rank = cycle.parameters - shape.unobserved.cols();
    cycle.degrees_of_freedom = rows.rows() - cycle.rank;
    cycle.residual = reading - rows * value;
    cycle.residual_rms = std::sqrt(cycle.residual.squaredNorm() / rows.rows());
    cycle.value = value(kept);
    cycle.covariance = shape.cofactor(kept, kept);
    const Vector3d turn = turn_of(result.errors, cycle.value);
    // A wrong place acts on the change that is stated, in all rows alike.
    if (i == 0 && record.against_first) first_turn = turn;
    VectorXd systematic(rows.rows());
    for (Index p = 0; p < systematic.size(); ++p) {
      const MandrelProbe& probe = record.probes[p];
      systematic[p] = std::pow(weight[p] * probe.place_std, 2) * probe.direction.cross(turn - first_turn).squaredNorm();
    }
    cycle.covariance += (solve * systematic.asDiagonal() * solve.transpose())(kept, kept);
    result.cycles.push_back(std::move(cycle));
  }
  complete(result.cycles, record.against_first);
  const VectorXd zeros = record.against_first ? result.cycles.front().residual : VectorXd::Zero(rows.rows());
  for (CycleResult& cycle : result.cycles) {
    cycle.residual -= zeros;
    cycle.residual_rms = std::sqrt(cycle.residual.squaredNorm() / rows.rows());
  }
  return result;
}

namespace {

/// (probes x probes) of readings over their standard deviations: what the quantities leave of them.
MatrixXd left_over(const MandrelRecord& record) {
  MatrixXd rows = rows_of(record, record.quantities.empty() ? quantity_names() : record.quantities);
  for (Index p = 0; p < rows.rows(); ++p) rows.row(p) /= record.probes[p].std;
  const LinearFit shape = fit_linear(rows, VectorXd::Zero(rows.rows()));
  return MatrixXd::Identity(rows.rows(), rows.rows()) - rows * shape.cofactor * rows.transpose();
}

}  // namespace

// A wrong place of a probe acts in all rows alike: with the columns U of what the standard deviations of the places do
// to the readings, each over its own, the covariance of the residuals is I + U U^T.
ResidualTest residual_test(const MandrelRecord& record, const Estimates& estimates) {
  const Index rows = std::ssize(estimates.cycles), probes = std::ssize(record.probes);
  MatrixXd scaled(rows, probes), of_places(rows, 3 * probes);
  for (Index i = 0; i < rows; ++i) {
    const CycleResult& cycle = estimates.cycles[i];
    const Vector3d turn = turn_of(estimates.errors, cycle.value);
    for (Index p = 0; p < probes; ++p) {
      const MandrelProbe& probe = record.probes[p];
      scaled(i, p) = cycle.residual[p] / probe.std;
      of_places.block<1, 3>(i, 3 * p) = probe.place_std / probe.std * probe.direction.cross(turn).transpose();
    }
  }
  if (record.against_first) {
    scaled.rowwise() -= scaled.colwise().mean().eval();
    of_places.rowwise() -= of_places.colwise().mean().eval();
  }
  const MatrixXd left = left_over(record);
  MatrixXd gram = of_places.transpose() * of_places;
  VectorXd shown(3 * probes);
  for (Index p = 0; p < probes; ++p) {
    shown.segment<3>(3 * p) = of_places.middleCols<3>(3 * p).transpose() * scaled.col(p);
    for (Index q = 0; q < probes; ++q) gram.block<3, 3>(3 * p, 3 * q) *= left(p, q);
  }
  gram.diagonal().array() += 1.0;
  ResidualTest test;
  test.degrees = (record.against_first ? rows - 1 : rows) * estimates.cycles.front().degrees_of_freedom;
  if (test.degrees < 1) {
    test.ratio = std::numeric_limits<double>::quiet_NaN();
    return test;
  }
  const double squares = scaled.squaredNorm() - shown.dot(gram.llt().solve(shown)), degrees = test.degrees;
  test.ratio = std::sqrt(squares / degrees);
  test.exceeds = diagnosis::chi_square_tail(squares, degrees) < residual_probability;
  return test;
}

}  // namespace thermotwin::metrology
