// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/config.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/rtest/error_choice.h"
#include "metrology/rtest/point_table.h"
#include "metrology/rtest/record_keys.h"

namespace thermotwin::metrology {

using core::InputError;
using core::Node;
using core::Table;
using Eigen::Index;
using Eigen::Vector3d;
namespace units = core::units;

void take_displacements(RTestRecord& record, const ProbeSetup& setup, const std::vector<Vector3d>& displacements) {
  const auto& branch = setup.on_table ? record.chain.table : record.chain.tool;
  std::size_t at = 0;
  for (RTestCycle& cycle : record.cycles) {
    for (RTestPoint& point : cycle.points) {
      const Eigen::Matrix3d carrier =
          mesh::KinematicChain::frame(branch, std::ssize(branch) - 1, point.positions).linear();
      point.deviation = (setup.on_table ? 1.0 : -1.0) * (carrier * displacements[at++]);
    }
  }
}

RTestRecord RTestRecord::parse(const std::string& toml, const Table& points, const std::string& source,
                               const RawSignals* signals) {
  const core::Config config = core::Config::parse(toml, source, &record_keys());
  const Node root = config.root();
  root.schema(1);
  RTestRecord record;
  record.source = source;
  read_common(root, record);
  record.harmonics = root.integer("harmonics");
  const std::string place = record.errors_stated ? root.place("errors") : source;
  const std::optional<Node> probes = root.table_if("probes");
  const ProbeSetup setup = probes ? read_probes(*probes) : ProbeSetup();
  root.finish();
  record.cycles = read_cycles(points, record.chain, signals != nullptr);
  compare_nothing(record);
  if (signals != nullptr) {
    record.calibration.emplace();
    take_displacements(record, setup, sphere_displacements(*signals, setup, points.rows(), &*record.calibration));
  }
  if (!record.errors_stated) {
    ErrorChoice choice = default_errors(record);
    record.errors = std::move(choice.chosen);
    record.left_out = std::move(choice.left_out);
  }
  if (record.errors.empty()) {
    throw InputError(place, record.errors_stated ? "no error" : "no rotary axis that moves",
                     "location errors, or points at several positions of a rotary axis");
  }
  std::vector<std::string> seen;
  for (const std::string& error : record.errors) {
    if (std::find(seen.begin(), seen.end(), error) != seen.end())
      throw InputError(place, "'" + error + "' a second time", "each error once");
    seen.push_back(error);
  }
  return record;
}

RTestRecord RTestRecord::load(const std::filesystem::path& folder) {
  for (const char* name : {"rtest.toml", "points.csv"}) {
    if (!std::filesystem::is_regular_file(folder / name))
      throw InputError(folder.string(), std::string("no file ") + name, "a folder with rtest.toml and points.csv");
  }
  const core::Config config = core::Config::load(folder / "rtest.toml");
  const Table points = core::read_csv(folder / "points.csv");
  if (has_deviations(points)) return parse(config.text(), points, config.source());
  const RawSignals signals = RawSignals::load(folder);
  return parse(config.text(), points, config.source(), &signals);
}

std::vector<std::string> RTestRecord::moved_axes() const {
  std::vector<std::string> moved;
  for (const auto* branch : {&chain.table, &chain.tool}) {
    for (const mesh::ChainAxis& axis : *branch) {
      if (!axis.rotary) continue;
      double low = 1e300, high = -1e300;
      for (const RTestCycle& cycle : cycles) {
        for (const RTestPoint& point : cycle.points) {
          const auto at = point.positions.find(axis.id);
          const double position = at == point.positions.end() ? 0.0 : at->second;
          low = std::min(low, position);
          high = std::max(high, position);
        }
      }
      if (high - low > 1e-6) moved.push_back(axis.id);
    }
  }
  return moved;
}

std::vector<std::string> usual_errors(const mesh::KinematicChain& chain, const std::vector<std::string>& moved) {
  std::string outermost, table;  // of the axes that move; of all
  for (const mesh::ChainAxis& axis : chain.table) {
    if (!axis.rotary) continue;
    table = axis.id;
    if (std::find(moved.begin(), moved.end(), axis.id) != moved.end()) outermost = axis.id;
  }
  if (outermost.empty() && !moved.empty()) outermost = moved.back();
  std::vector<std::string> errors;
  for (const std::string& id : moved) {
    const mesh::ChainAxis& axis = *chain.find(id);
    Index along = 0;
    axis.direction.cwiseAbs().maxCoeff(&along);
    for (int i = 0; i < 3; ++i) {
      if (i == along && id != outermost) continue;
      errors.push_back(std::string(1, "XYZ"[i]) + "0" + (i == along && axis.table_side ? "T" : id));
    }
    for (int i = 0; i < 3; ++i)
      if (i != along || id == outermost) errors.push_back(std::string(1, "ABC"[i]) + "0" + id);
    if (id == table) errors.emplace_back("R0T");
  }
  return errors;
}

}  // namespace thermotwin::metrology
