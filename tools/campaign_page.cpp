// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/campaign_page.h"

#include <fmt/format.h>

#include "core/html_page.h"
#include "core/quoted.h"
#include "core/text.h"
#include "tools/page.h"

namespace thermotwin::tools {
namespace {

std::string headline(const CampaignResults& r) {
  double largest = 0.0, hours = 0.0, at_h = 0.0;
  std::string load, pose;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  for (const solver::SceneLoad& shown : r.scene.loads) {
    hours += shown.hours.tail(1).sum();
    for (Eigen::Index t = 0; t < shown.errors_um.cols(); ++t) {
      const Eigen::Matrix3Xd errors = shown.errors_um.col(t).reshaped(3, std::ssize(r.scene.poses));
      Eigen::Index where = 0;
      const double here = errors.colwise().norm().maxCoeff(&where);
      if (here <= largest) continue;
      largest = here, load = shown.name, at_h = shown.hours[t], error = errors.col(where);
      pose = mesh::format_pose(r.scene.machine, r.scene.poses[where]);
    }
  }
  std::string finding;
  if (largest > 0.0) {
    finding = core::html_finding(
        core::Tone::plain, "largest TCP error",
        {fmt::format("The TCP error reaches {:.1f} µm: load program {}, after {:.2f} h{}{}.", largest,
                     core::xml_text(load), at_h, pose.empty() ? "" : ", at ", core::xml_text(pose)),
         fmt::format("Its parts are X {:.1f}, Y {:.1f} and Z {:.1f} µm.", error.x(), error.y(), error.z())});
  }
  return finding + core::html_tiles({core::html_tile("largest TCP error", fmt::format("{:.1f} µm", largest),
                                                     "load program " + core::xml_text(load)),
                                     core::html_tile("load programs", std::to_string(r.loads.size()),
                                                     fmt::format("{:.1f} h of the machine", hours)),
                                     core::html_tile("poses", std::to_string(r.scene.poses.size()), "of the workspace"),
                                     core::html_tile("computed by", r.full != nullptr ? "full model" : "reduced model",
                                                     core::xml_text(r.model))});
}

std::string next_steps(const CampaignResults& r) {
  const std::string folder = core::shell_word(r.options.case_path), out = core::shell_word(r.options.out),
                    load = r.loads.front().name(),
                    mesh = mesh_words(r.options.size, r.options.mesh_order, r.options.solver);
  const core::NextStep look{"Fields of one load for ParaView:",
                            fmt::format("thermotwin simulate {} --load {}{} --out {}", folder, load, mesh, out)};
  if (r.full == nullptr) {
    return core::html_next_steps(
        {look,
         {"The same load by the full model, to compare with:",
          fmt::format("thermotwin campaign {} --load {}{} --out {}", folder, load, mesh, out)},
         {"Offsets for the rows of a load:",
          fmt::format("thermotwin compensate {} --in {}/campaign_reduced/{}/inputs.csv --out offsets.csv",
                      core::shell_word(r.options.model.empty() ? r.options.out / "model.rom.h5" : r.options.model), out,
                      load)}});
  }
  return core::html_next_steps(
      {{"A reduced model; it needs the temperatures of all nodes, so the loads are run again:",
        fmt::format("thermotwin reduce {}{} --out {}", folder, mesh, out)},
       look,
       {"Other load programs in seconds, once the model is reduced:",
        fmt::format("thermotwin campaign {} --reduced --load {} --out {}", folder, load, out)}});
}

}  // namespace

std::string campaign_page(const CampaignResults& r) {
  const std::string title = "Campaign of " + r.scene.machine.name;
  return core::html_document(
      title,
      core::html_title(title, "load programs, the TCP error at the poses of the workspace") + headline(r) +
          solver::machine_scene_html(r.scene) + loads_section(r.loads, r.scene) +
          (r.full == nullptr ? core::html_section("Loads and estimated error", "", core::html_table(r.table)) : "") +
          (r.full != nullptr ? mesh_section(*r.full) : "") + next_steps(r));
}

}  // namespace thermotwin::tools
