// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/twin.h"

#include "compensation/control/model_order.h"
#include "core/error.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/model_file.h"

namespace thermotwin::tools {

Twin read_twin(const std::filesystem::path& path, int order) {
  Twin twin;
  if (std::filesystem::is_directory(path) || path.extension() == ".toml") {
    twin.machine = mesh::read_machine(std::filesystem::is_directory(path) ? path / "machine.toml" : path);
  } else {
    twin.model = compensation::model_of_order(reduction::read_model(path), order);
    twin.machine = twin.model->machine;
  }
  return twin;
}

std::unique_ptr<nc::PresentMachine> present_machine(const NcOptions& options, const Twin& twin) {
  if (options.state.empty()) return nullptr;
  if (!twin.model)
    throw core::UsageError("nc: --state needs a reduced model (model.rom.h5); allowed: MODEL as `reduce` writes it");
  nc::PresentOptions present;
  present.state = options.state;
  present.after_s = options.after_s.value_or(options.row_s);
  present.step_s = options.row_s;
  compensation::CompensatorOptions& saved_with = present.saved_with.compensator;
  saved_with.step_s = options.step_s;
  saved_with.start_C = options.start_C;
  saved_with.largest_um = options.largest_um;
  saved_with.rate_um_s = options.rate_um_s;
  present.validate();
  return std::make_unique<nc::PresentMachine>(*twin.model, present);
}

nc::Positions start_of(const NcOptions& options, const mesh::Machine& machine, const nc::PresentMachine* present) {
  if (!options.start.empty()) return mesh::parse_pose(machine, options.start, "--start");
  return present != nullptr ? present->pose() : mesh::home_pose(machine);
}

}  // namespace thermotwin::tools
