// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <cmath>

#include "core/file.h"
#include "core/text.h"
#include "solver/elastic_model.h"
#include "solver/tcp.h"
#include "solver/vtk_output.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {

void simulate(const SimulateOptions& options) {
  const Stopwatch time;
  const solver::Case machine_case = open_case(options.case_path, options.size);
  const mesh::Machine& machine = machine_case.machine;
  const solver::LoadProgram program = machine_case.load(options.load);
  const mesh::Pose pose = options.pose.empty() ? mesh::home_pose(machine)
                                               : mesh::parse_pose(machine, options.pose, "--pose");
  const solver::FullModel full = build(machine_case, options.out);

  solver::CampaignOptions campaign;
  campaign.poses = {pose};
  campaign.keep_snapshots = true;
  const solver::LoadResult result = solver::run_campaign(full, {program}, campaign).front();

  const auto folder = options.out / "simulate" / program.name();
  core::write_csv(folder / "tcp.csv", result.tcp);
  core::write_csv(folder / "sensors.csv", result.sensors);
  std::vector<std::pair<double, std::string>> files;
  double next = 0;
  for (Eigen::Index i = 0; i < result.snapshots.cols(); ++i) {
    const double now = result.sensors.values(i, 0);
    if (now < next - 1e-6 && i + 1 < result.snapshots.cols()) continue;
    next = now + options.fields_every_s;
    const std::string name = fmt::format("fields/{:06d}.vtu", files.size());
    const Eigen::VectorXd state = result.snapshots.col(i);
    solver::write_fields(folder / name, full.mesh, pose,
                         (state.head(full.mesh.nodes()).array() + machine.reference_C).matrix(),
                         full.elastic.displacement(state, pose));
    files.emplace_back(now, name);
  }
  solver::write_pvd(folder / "fields.pvd", files);

  nlohmann::json json = {{"load", program.name()}, {"pose", mesh::format_pose(machine, pose)},
                         {"nodes", full.mesh.nodes()}, {"folder", folder.string()}};
  std::vector<std::vector<std::string>> table{{"TCP error", "at the end", "largest"}};
  for (const char* column : {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"}) {
    const Eigen::VectorXd values = result.tcp.column(column);
    const double end = values(values.size() - 1), largest = values.cwiseAbs().maxCoeff();
    table.push_back({column, fmt::format("{:.2f}", end), fmt::format("{:.2f}", largest)});
    json["tcp"][column] = {{"end", end}, {"largest", largest}};
  }
  print_summary(options,
                fmt::format("{} ({}), pose {}\n{}\n{} nodes, {} fields, {:.0f} s; open {} in ParaView\n", program.name(),
                            program.title(), mesh::format_pose(machine, pose), core::format_table(table),
                            full.mesh.nodes(), files.size(), time.seconds(), (folder / "fields.pvd").string()),
                json.dump());
}

}  // namespace thermotwin::tools
