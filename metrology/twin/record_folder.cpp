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
#include "core/normal_draws.h"
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
  core::NormalDraws normal(seed + 1);
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
        data.values(row, channel.column) = (run.error[i][q] + drawn) / units::um;
      }
    }
  }
  return record;
}

namespace {

/// Deviations at the points of a volumetric grid, beside its loads.
void write_grid(const fs::path& folder, const fs::path& plan_folder, const mesh::Machine& machine,
                const PlanFolder& plan, const VirtualRun& run, std::uint64_t seed) {
  Table points = core::read_csv(plan_folder / "points.csv");
  const Index first = points.values.cols();
  for (const char* column : {"dx_um", "dy_um", "dz_um"}) points.columns.emplace_back(column);
  points.values.conservativeResize(Eigen::NoChange, first + 3);
  const double std = std_of(plan);
  core::NormalDraws normal(seed + 1);
  for (Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d deviation = run.error[i].head<3>() + std * normal.vector();
    points.values.row(i).tail<3>() = (deviation / units::um).transpose();
  }
  core::write_files_by(folder, [&](const fs::path& staged) {
    core::write_csv(staged / "points.csv", points, 12);
    core::write_file(staged / "grid.toml", rtest_text(machine, std::max(1e-9, std), ""));
    return std::vector<fs::path>{"points.csv", "grid.toml"};
  });
}

/// Five probes of ISO 230-3 about a mandrel at the first place of a test: two levels in x and in y, one along z.
void write_mandrel(const fs::path& folder, const mesh::Machine& machine, const PlanFolder& plan, const VirtualRun& run,
                   std::uint64_t seed) {
  struct Probe {
    const char* id;
    Eigen::Vector3d at, direction;
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  const std::vector<Probe> probes{{"X1", 0.0 * z, x},
                                  {"X2", probe_levels * z, x},
                                  {"Y1", 0.0 * z, y},
                                  {"Y2", probe_levels * z, y},
                                  {"Z1", 0.0 * z, z}};
  const double std = std_of(plan);
  std::string text = "# SPDX-License-Identifier: GPL-3.0-or-later\nschema = 1\n";
  Table readings;
  readings.source = "readings.csv";
  readings.columns = {"time_s"};
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < plan.points.size(); ++i)
    if (plan.points[i].place == 1) rows.push_back(i);
  readings.values.resize(std::ssize(rows), 1 + std::ssize(probes));
  text += "pose = \"" + mesh::format_pose(machine, plan.points[rows.front()].pose) + "\"\n";
  for (const Probe& probe : probes) {
    readings.columns.push_back(std::string(probe.id) + "_um");
    text += fmt::format("[[probe]]\nid = \"{}\"\nat_mm = [{}, {}, {}]\ndirection = [{}, {}, {}]\nstd_um = {:.6g}\n",
                        probe.id, probe.at.x() / units::mm, probe.at.y() / units::mm, probe.at.z() / units::mm,
                        probe.direction.x(), probe.direction.y(), probe.direction.z(), std::max(1e-9, std) / units::um);
  }
  core::NormalDraws normal(seed + 2);
  for (Index r = 0; r < readings.rows(); ++r) {
    const std::size_t i = rows[r];
    readings.values(r, 0) = plan.points[i].time;
    for (Index p = 0; p < std::ssize(probes); ++p) {
      const Probe& probe = probes[p];
      const Eigen::Vector3d shift = run.error[i].head<3>(), turn = run.error[i].tail<3>();
      readings.values(r, 1 + p) = (probe.direction.dot(shift + turn.cross(probe.at)) + std * normal()) / units::um;
    }
  }
  core::write_files_by(folder, [&](const fs::path& staged) {
    core::write_csv(staged / "readings.csv", readings, 12);
    core::write_file(staged / "mandrel.toml", text);
    return std::vector<fs::path>{"readings.csv", "mandrel.toml"};
  });
}

/// Heights of the table's surface in the middle of each cycle.
void write_surface(const fs::path& folder, const mesh::Machine& machine, const PlanFolder& plan, const VirtualRun& run,
                   std::uint64_t seed) {
  const double std = std_of(plan), radius = run.surface_at.rowwise().norm().maxCoeff();
  Table points;
  points.source = "points.csv";
  points.columns = {"time_s", "cycle", "x_mm", "y_mm", "height_um"};
  points.values.resize(run.surface.size(), 5);
  constexpr double apart = 1e-3;  // s, between two points: a table has rising times
  const double last = run.surface.cols() - 1;
  core::NormalDraws normal(seed + 3);
  Index row = 0;
  for (Index c = 0; c < run.surface.rows(); ++c) {
    for (Index i = 0; i < run.surface.cols(); ++i) {
      const double time = run.middle[c] + apart * (i - 0.5 * last);
      points.values.row(row++) << time, c + 1, run.surface_at(i, 0) / units::mm, run.surface_at(i, 1) / units::mm,
          (run.surface(c, i) + std * normal()) / units::um;
    }
  }
  const std::string text = fmt::format(
      "# SPDX-License-Identifier: GPL-3.0-or-later\nschema = 1\nradius_mm = {:.12g}\nstd_um = {:.6g}\npose = \"{}\"\n",
      radius / units::mm * (1.0 + 1e-9), std::max(1e-9, std) / units::um,
      mesh::format_pose(machine, plan.points.front().pose));
  core::write_files_by(folder, [&](const fs::path& staged) {
    core::write_csv(staged / "points.csv", points, 12);
    core::write_file(staged / "surface.toml", text);
    return std::vector<fs::path>{"points.csv", "surface.toml"};
  });
}

}  // namespace

void write_record(const fs::path& folder, const fs::path& plan_folder, const mesh::Machine& machine,
                  const PlanFolder& plan, const VirtualRun& run, double sensor_noise_K, std::uint64_t seed) {
  if (run.surface.size() > 0) write_surface(folder / "surface", machine, plan, run, seed);
  const bool grid = plan.kind == "volumetric_grid";
  if (!plan.is_rtest && !grid) {
    write_mandrel(folder / "mandrel", machine, plan, run, seed);
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
  if (grid) {
    write_grid(folder, plan_folder, machine, plan, run, seed);
    return;
  }
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
