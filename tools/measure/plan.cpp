// SPDX-License-Identifier: GPL-3.0-or-later
// The verb measure plan: the NC program, the load program and the points of a test.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/plan/plan_files.h"
#include "metrology/plan/test_plan.h"
#include "tools/chain.h"
#include "tools/measure/measure.h"

namespace thermotwin::tools {

namespace units = core::units;

void measure_plan(const MeasurePlanOptions& options) {
  metrology::PlanOptions asked = options.plan;
  asked.kind = metrology::test_kind(options.kind);
  if (!options.air_C.empty()) {
    if (options.air_C.size() != 2) throw core::UsageError("--air needs two temperatures, such as 21,26");
    asked.air_C = {options.air_C[0], options.air_C[1]};
  }
  metrology::ProbeSetup probes;
  probes.on_table = options.mount == "table";
  probes.contact_radius = options.contact_radius_mm * units::mm;
  probes.noise = options.noise_um * units::um;
  probes.repeatability = options.repeatability_um * units::um;
  probes.rate = asked.rate_Hz;
  const bool continuous = asked.kind == metrology::TestKind::rtest_continuous;
  probes.record = continuous ? 0.0 : asked.record_s;
  probes.cut = asked.cut_s;
  const auto& offset = options.tool_offset_mm;
  if (!offset.empty() && offset.size() != 3)
    throw core::UsageError("--tool-offset needs three numbers, such as 0,0,-150");
  const Eigen::Vector3d tool_offset =
      offset.empty() ? Eigen::Vector3d::Zero()
                     : Eigen::Vector3d(units::mm * Eigen::Vector3d(offset[0], offset[1], offset[2]));
  mesh::Machine machine = open_case(options.case_path, "", 0).machine;
  metrology::move_tool_point(machine, tool_offset);
  const metrology::TestPlan plan = metrology::make_plan(machine, asked);
  metrology::write_plan(options.out, machine, plan, probes, tool_offset);

  std::size_t blocks = 0, cycles = 0;
  double measuring = 0.0;
  for (const metrology::Stage& stage : plan.timeline.stages()) {
    blocks += stage.blocks.size();
    if (stage.cycle == 0) continue;
    ++cycles;
    measuring += stage.duration;
  }
  const double each = measuring / cycles;
  const nlohmann::json json = {
      {"kind", options.kind},  {"tested", plan.tested},         {"duration_s", plan.timeline.now()},
      {"cycles", cycles},      {"points", plan.points.size()},  {"blocks", blocks},
      {"measurement_s", each}, {"folder", options.out.string()}};
  print_summary(options,
                fmt::format("{}{}: {:.4g} h, {} measurements of {:.4g} s with {} points, {} blocks\nin {}: program.nc, "
                            "load.toml, rows.csv, points.csv, plan.toml{}\n",
                            options.kind, plan.tested.empty() ? "" : " of " + plan.tested,
                            plan.timeline.now() / units::hour, cycles, each, plan.points.size(), blocks,
                            options.out.string(), plan.is_rtest() ? ", rtest.toml" : ""),
                json.dump());
}

}  // namespace thermotwin::tools
