// SPDX-License-Identifier: GPL-3.0-or-later
// Example 4: the reduced model beside a control, row by row.
//
// A control sends what it knows: speeds, positions, states, the air's temperature, readings of temperature sensors.
// Compensator::step() takes one such row and returns offsets for the linear axes with their standard deviation; sensors
// correct its state. The machine is one of our own making: the full model on a finer mesh, stepped by another time
// scheme, with parameters perturbed within their stated uncertainty, and noise on its sensors.
//
// Usage: 04_compensate [CASE [MODEL]]    MODEL: of the same machine, from example 3; default model.rom.h5
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "compensation/evaluation/replay.h"
#include "compensation/measurement/virtual_measurement.h"
#include "compensation/online/axis_reach.h"
#include "compensation/online/compensator.h"
#include "compensation/online/output_map.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/units.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"

using namespace thermotwin;
namespace units = core::units;

namespace {

int run(const char* folder, const char* file) {
  const reduction::ReducedModel model = reduction::read_model(file);
  const solver::Case machine_case = solver::read_case(folder);
  const mesh::Machine& machine = machine_case.machine;
  if (machine.hash != model.machine.hash || machine_case.holdout.empty() || machine_case.check_points.empty())
    throw core::InputError(folder, "does not fit", "the case of the model, with a held-out load and check points");
  const mesh::Pose pose = machine_case.check_points.front();

  // 1. The machine, and what is recorded of it under a held-out load. The displacements dx, dy, dz at
  //    the pose serve as the truth below; the compensator does not get them.
  compensation::VirtualOptions truth;
  truth.seed = 11;
  truth.size_factor = 0.7 * mesh::size_factor(machine, machine_case.size);
  mesh::MeshOptions meshing;
  meshing.size_factor = truth.size_factor;
  const solver::FullModel real = solver::build_full_model(compensation::perturbed(machine, truth.seed), meshing);
  const compensation::Measurement record =
      compensation::measure_virtually(real, machine_case.load(machine_case.holdout.front()), {pose}, truth);

  // 2. Rows for the compensator: channels in the order of Compensator::channels(), and one reading a sensor in degC,
  //    NaN where it is missing. Here they come from a record; a control would fill them.
  const compensation::MeasuredRun replay;
  const solver::Channels channels(machine);
  const Eigen::MatrixXd inputs = compensation::compensator_rows(record, machine, channels, replay);
  const Eigen::MatrixXd readings_C = compensation::sensor_readings(record, machine);

  // 3. The loop of a control. offset_um is for the row's own position. tcp() is the predicted error at any pose, and
  //    OutputMap gives the offsets that cancel it there: the machine may be elsewhere than where it is judged. The
  //    offsets act through the linear axes: an error in a direction that none of them moves stays.
  compensation::CompensatorOptions options;
  options.start_C = compensation::start_temperature(record, machine);
  compensation::Compensator compensator(model, options);
  const compensation::OutputMap map(model);
  const compensation::AxisReach reach(machine, pose);
  const Eigen::VectorXd time_s = record.time();
  Eigen::Matrix3Xd error_um(3, time_s.size()), left_um(3, time_s.size());
  for (int axis = 0; axis < 3; ++axis)
    error_um.row(axis) = record.data.column(std::string("dx@1").replace(1, 1, 1, "xyz"[axis]));
  std::printf("TCP error at %s, um\n  time_h      without compensation       with compensation    offset %s +- std\n",
              mesh::format_pose(machine, pose).c_str(), compensator.axes().front().c_str());
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    const compensation::Offsets& offsets = compensator.step(time_s[i], inputs.row(i), readings_C.row(i));
    left_um.col(i) = error_um.col(i) + reach.motion(map.offsets(compensator.tcp(pose))) / units::um;
    if (i % 10 == 0) {
      const Eigen::Vector3d before = error_um.col(i), after = left_um.col(i);
      std::printf("%8.2f  %7.1f %7.1f %7.1f  %7.1f %7.1f %7.1f  %7.1f +- %.1f  %s\n", time_s[i] / units::hour,
                  before.x(), before.y(), before.z(), after.x(), after.y(), after.z(), offsets.offset_um[0],
                  offsets.std_um[0], compensation::status_text(offsets.status));
    }
  }

  // 4. What the observer has learnt: deviations from nominal values, unit 1 a share of the nominal value.
  for (const compensation::ErrorModel::State& state : compensator.learned()) {
    if (state.std < 0.7 * state.prior_std)
      std::printf("learned     %s: %.3f +- %.3f %s\n", state.name.c_str(), state.value, state.std, state.unit.c_str());
  }
  const double before = std::sqrt(error_um.squaredNorm() / time_s.size()),
               after = std::sqrt(left_um.squaredNorm() / time_s.size());
  std::printf("RMS %.1f um -> %.1f um, %.0f %% removed\n", before, after, 100.0 * (1.0 - after / before));
  double stays = 0.0;
  for (Eigen::Index i = 0; i < time_s.size(); ++i) stays += reach.unmoved(error_um.col(i)).squaredNorm();
  stays = std::sqrt(stays / time_s.size());
  const double moved_before = std::sqrt(before * before - stays * stays),
               moved_after = std::sqrt(std::max(0.0, after * after - stays * stays));
  if (!reach.unmoved_directions().empty()) {
    std::printf(
        "No axis moves the tool along %s: %.1f um RMS stay there. In the directions that axes move, %.1f um "
        "become %.1f um, %.0f %% removed.\n",
        reach.unmoved_directions().c_str(), stays, moved_before, moved_after,
        100.0 * (1.0 - moved_after / moved_before));
  }
  return moved_after < 0.3 * moved_before ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  core::set_quiet(true);
  try {
    return run(argc > 1 ? argv[1] : TOY_CASE, argc > 2 ? argv[2] : "model.rom.h5");
  } catch (const core::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_status();
  }
}
