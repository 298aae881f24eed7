// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are a machine or an InputError. A machine that was read has channels, coefficients that
// are no NaN and none negative, poses inside its travels and a placing for each of its bodies.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/error.h"
#include "core/progress.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "solver/operation/layout.h"
#include "solver/operation/operating_model.h"
#include "tests/fuzz/require.h"

using namespace thermotwin;

namespace {

std::vector<solver::JointGrid> grids_of(const mesh::Machine& machine) {
  std::vector<solver::JointGrid> grids;
  for (const mesh::JointSpec& joint : machine.joints) {
    const int axis = joint.axis.empty() ? -1 : machine.axis_index(joint.axis);
    solver::JointGrid grid{axis, false, {0.0}};
    if (axis >= 0) {
      const mesh::Axis& moved = machine.axes[axis];
      grid.periodic = moved.endless;
      grid.positions = {moved.low, moved.endless ? 0.5 * moved.high : moved.high};
    }
    grids.push_back(grid);
  }
  return grids;
}

void use(const mesh::Machine& machine) {
  const mesh::Pose home = mesh::home_pose(machine);
  for (std::size_t a = 0; a < machine.axes.size(); ++a) {
    const mesh::Axis& axis = machine.axes[a];
    const double position = home[a];
    require(axis.endless || (position >= axis.low && position <= axis.high), "home lies in the travel");
  }
  for (int b = 0; b < std::ssize(machine.bodies); ++b)
    require(mesh::body_transform(machine, b, home).matrix().allFinite(), "a body has a place at home");
  require(mesh::parse_pose(machine, mesh::format_pose(machine, home), "home").size() == home.size(),
          "a pose can be read back");

  const solver::Layout layout = solver::make_layout(machine, grids_of(machine));
  const solver::OperatingModel model(machine, layout);
  const Eigen::VectorXd inlet = Eigen::VectorXd::Zero(std::ssize(machine.coolants));
  Eigen::VectorXd row = model.channels().defaults();
  for (const bool running : {false, true}) {
    if (running) {
      for (const std::string name : {"spindle.speed_rpm", "cutting_fluid.on"})
        row[model.channels().index(name)] = name == "cutting_fluid.on" ? 1.0 : 3000.0;
    }
    const Eigen::Index readings = machine.sensors.size() + layout.observed.size();
    const solver::Coefficients c =
        model.coefficients(row, inlet, running ? Eigen::VectorXd::Constant(readings, 5.0) : Eigen::VectorXd());
    require(c.p.size() == std::ssize(layout.terms), "a coefficient for each term");
    require((c.p.array() >= 0.0).all(), "no coefficient is negative or NaN");
    require(!c.q.array().isNaN().any(), "no input is NaN");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  core::set_quiet(true);
  try {
    use(mesh::parse_machine(std::string(reinterpret_cast<const char*>(data), size), "fuzz/machine.toml"));
  } catch (const core::InputError&) {}
  return 0;
}
