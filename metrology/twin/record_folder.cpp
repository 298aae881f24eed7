// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/twin/record_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "compensation/measurement/virtual_measurement.h"
#include "core/file.h"
#include "core/missing.h"
#include "core/units.h"
#include "metrology/twin/signals.h"

namespace thermotwin::metrology {

namespace fs = std::filesystem;
namespace units = core::units;
using compensation::MeasuredChannel;
using compensation::Measurement;
using core::Table;
using Eigen::Index;

namespace {

Measurement loads_record(const mesh::Machine& machine, const VirtualRun& run, double sensor_noise_K,
                         std::uint64_t seed) {
  compensation::VirtualOptions options;
  options.sensor_noise_K = sensor_noise_K;
  options.seed = seed;
  return compensation::measure_run(run.load, machine, {}, options);
}

Table functionals_table(const VirtualRun& run) {
  Table table;
  table.source = "functionals.csv";
  table.columns = {"time_s"};
  for (const std::string& name : run.quantities)
    table.columns.push_back(name + (name[0] >= 'A' && name[0] <= 'C' ? "_um_per_m" : "_um"));
  table.values.resize(std::ssize(run.middle), std::ssize(table.columns));
  for (Index i = 0; i < table.rows(); ++i) table.values(i, 0) = run.middle[i];
  table.values.rightCols(std::ssize(run.quantities)) = run.functionals;
  return table;
}

}  // namespace

double std_of(const PlanFolder& plan) {
  return plan.probes.std_of_point(plan.probes.record > 0 ? plan.probes.averaged() : 1.0);
}

Measurement displacement_record(const mesh::Machine& machine, const PlanFolder& plan, const VirtualRun& run,
                                double sensor_noise_K, std::uint64_t seed) {
  Measurement record = loads_record(machine, run, sensor_noise_K, seed);
  NormalDraws normal(seed + 1);
  static constexpr std::array<const char*, 6> quantities{"dx", "dy", "dz", "ra", "rb", "rc"};
  const double std = std::max(1e-9, std_of(plan));
  std::map<int, const PlannedPoint*> places;
  for (const PlannedPoint& point : plan.points) places.emplace(point.place, &point);
  const Eigen::VectorXd time = record.time();
  for (const auto& [place, first] : places) {
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      MeasuredChannel channel;
      channel.id = fmt::format("{}@{}", quantities[q], place);
      channel.quantity = quantities[q];
      channel.kind = compensation::ChannelKind::displacement;
      channel.unit = q < 3 ? "um" : "um/m";
      const double noise = q < 3 ? std : std::sqrt(2.0) * std / probe_levels;
      channel.uncertainty = noise / units::um;
      channel.pose_text = mesh::format_pose(machine, first->pose);
      channel.zero = compensation::Zero::first;
      channel.column = std::ssize(record.data.columns);
      record.data.columns.push_back(channel.id);
      record.channels.push_back(channel);
      Table& data = record.data;
      data.values.conservativeResize(Eigen::NoChange, channel.column + 1);
      data.values.col(channel.column).setConstant(core::missing);
      for (std::size_t i = 0; i < plan.points.size(); ++i) {
        if (plan.points[i].place != place) continue;
        Index row = 0;
        (time.array() - plan.points[i].time).abs().minCoeff(&row);
        const double drawn = plan.probes.noise > 0 || plan.probes.repeatability > 0 ? noise * normal() : 0.0;
        data.values(row, channel.column) = (run.error[i][static_cast<Index>(q)] + drawn) / units::um;
      }
    }
  }
  return record;
}

void write_record(const fs::path& folder, const fs::path& plan_folder, const mesh::Machine& machine,
                  const PlanFolder& plan, const VirtualRun& run, double sensor_noise_K, std::uint64_t seed) {
  if (!plan.is_rtest) {
    const Measurement record = displacement_record(machine, plan, run, sensor_noise_K, seed);
    core::write_files_by(folder, [&](const fs::path& staged) {
      compensation::write_measurement(staged, record);
      return std::vector<fs::path>{"data.csv", "channels.toml"};
    });
    return;
  }
  const Measurement loads = loads_record(machine, run, sensor_noise_K, seed);
  core::write_files_by(folder / "loads", [&](const fs::path& staged) {
    compensation::write_measurement(staged, loads);
    return std::vector<fs::path>{"data.csv", "channels.toml"};
  });
  const RawSignals signals = probe_signals(machine, plan.points, run.error, plan.probes, seed);
  core::write_files_by(folder, [&](const fs::path& staged) {
    core::write_csv(staged / "raw.csv", signals.raw, 10);
    core::write_csv(staged / "calibration.csv", signals.calibration, 12);
    core::write_csv(staged / "functionals.csv", functionals_table(run));
    core::write_file(staged / "points.csv", core::read_file(plan_folder / "points.csv"));
    const double std = std::max(1e-9, std_of(plan));
    core::write_file(staged / "rtest.toml", rtest_text(machine, std, "") + probes_text(plan.probes));
    return std::vector<fs::path>{"raw.csv", "calibration.csv", "functionals.csv", "points.csv", "rtest.toml"};
  });
}

}  // namespace thermotwin::metrology
