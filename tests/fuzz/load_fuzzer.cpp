// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are a load program of a five-axis machine or an InputError. Steps of a program that was
// read rise to its end, meet its outputs and corners, and have rows inside what the machine can do.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/error.h"
#include "solver/operation/load_program.h"
#include "tests/fuzz/require.h"
#include "tests/machines/five_axis.h"

using namespace thermotwin;

namespace {

void use(const solver::LoadProgram& program, const mesh::Machine& machine, const solver::Channels& channels) {
  const double end = program.duration();
  require(std::isfinite(end) && end > 0.0, "a program lasts");
  const std::vector<double> steps = program.step_ends();
  require(!steps.empty() && steps.back() == end, "the last step ends the program");
  for (std::size_t i = 0; i < steps.size(); ++i) require(steps[i] > (i == 0 ? 0.0 : steps[i - 1]), "steps rise");
  for (const double time : program.output_times()) {
    const auto near = std::lower_bound(steps.begin(), steps.end(), time - 2e-9 * end);
    require(time <= 2e-9 * end || (near != steps.end() && std::abs(*near - time) <= 2e-9 * end),
            "an output is a step's end");
  }
  const int x = channels.index("axis.X.position_mm"), speed = channels.index("spindle.speed_rpm");
  const std::size_t stride = std::max<std::size_t>(1, steps.size() / 50);
  for (std::size_t i = 0; i < steps.size(); i += stride) {
    const Eigen::VectorXd row = program.row(i == 0 ? 0.0 : steps[i - 1], steps[i]);
    require(row.size() == channels.size() && !row.array().isInf().any(), "a row of finite channels");
    require(std::abs(row[x]) <= 1e3 * machine.axes[0].high + 1e-3, "an axis stays in its travel");
    require(row[speed] >= 0.0 && row[speed] <= machine.spindle_max_rpm, "the spindle keeps to its speeds");
    program.phase_at(steps[i]);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mesh::Machine machine = compensation::test::five_axis_machine();
  static const solver::Channels channels(machine);
  try {
    use(solver::LoadProgram::parse(std::string(reinterpret_cast<const char*>(data), size), "fuzz.toml", machine),
        machine, channels);
  } catch (const core::InputError&) {}
  return 0;
}
