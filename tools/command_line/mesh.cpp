// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_mesh(CLI::App& app) {
  const auto options = std::make_shared<MeshOptions>();
  MeshOptions& mesh = *options;
  CLI::App* verb = add_verb(
      app, "mesh", "Builds and checks the mesh of a machine, prints bodies, quality and joints, and writes .vtu files.",
      "thermotwin mesh cases/vmc5/machine.toml --size standard", options, &tools::mesh_machine);
  verb->add_option("MACHINE", mesh.machine, "machine.toml, or the folder that holds it.")->required();
  add_mesh_options(*verb, mesh.size, mesh.mesh_order);
  verb->get_option("--size")->description(
      "Mesh size: coarse (default), standard, fine, or a factor on the element sizes.");
}

}  // namespace thermotwin::tools
