// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tests/test_confirmation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensation/evaluation/measured_machines.h"
#include "core/error.h"
#include "core/file.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "diagnosis/response/response.h"
#include "reduction/model/reduced_simulation.h"
#include "study/tests/test_estimate.h"

namespace thermotwin::study {

using compensation::Measurement;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// A run of the case's own program and its prediction.
struct Predicted {
  solver::LoadProgram load;
  Measurement measured;
};

/// Sum of the squared differences of translations since the start, um^2, and their number.
std::pair<double, double> squares(const reduction::ReducedModel& model, const mesh::Machine& machine,
                                  const Predicted& of, const std::vector<mesh::Pose>& poses) {
  reduction::ReducedRun how;
  how.tell = false;
  const reduction::ReducedModel changed = diagnosis::model_of_changed(model, machine);
  const core::Table tcp = reduction::simulate_reduced(changed, machine, of.load, poses, how).tcp;
  const Index count = std::ssize(poses), times = tcp.rows() / count;
  double sum = 0.0;
  for (Index p = 0; p < count; ++p) {
    const std::string at = mesh::format_pose(machine, poses[p]);
    for (const char* quantity : {"dx", "dy", "dz"}) {
      const auto channel = std::find_if(of.measured.channels.begin(), of.measured.channels.end(),
                                        [&](const auto& c) { return c.quantity == quantity && c.pose_text == at; });
      if (channel == of.measured.channels.end() || of.measured.data.rows() != times)
        throw core::InputError(of.measured.folder.string(), "other times or poses", "the run of this study");
      const VectorXd truth = of.measured.values(*channel), all = tcp.column(std::string(quantity) + "_um");
      for (Index t = 1; t < times; ++t) sum += std::pow(all[t * count + p] - all[p] - (truth[t] - truth[0]), 2);
    }
  }
  const double summed = count * (times - 1);
  return {sum, summed};
}

}  // namespace

std::vector<ConfirmedMachine> confirm_tests(const solver::Case& machine_case, const reduction::ReducedModel& model,
                                            const TestSetup& setup, const std::vector<ConfirmedTest>& tests,
                                            const std::vector<std::string>& loads, int draws,
                                            const std::filesystem::path& keep, const std::filesystem::path& cache) {
  const std::vector<mesh::Pose>& poses = machine_case.check_points;
  if (poses.empty()) {
    throw core::InputError((machine_case.folder / "case.toml").string() + " [check_points]", "missing",
                           "[check_points] at which predictions are compared");
  }
  solver::Case measured_case = machine_case;
  for (const mesh::Pose& probe : setup.probes) {
    const bool known =
        std::any_of(poses.begin(), poses.end(), [&](const mesh::Pose& pose) { return pose.isApprox(probe); });
    if (!known) measured_case.check_points.push_back(probe);
  }
  compensation::VirtualOptions how;
  how.mesh_cache = cache;
  compensation::MeasuredMachines machines(measured_case, how, keep, nullptr);
  std::vector<diagnosis::Parameter> parameters;
  VectorXd nominal(std::ssize(setup.parameters));
  for (const UncertainParameter& one : setup.parameters) {
    nominal[std::ssize(parameters)] = one.parameter.nominal;
    parameters.push_back(one.parameter);
  }
  BlockOptions as_it_is;
  as_it_is.probe_every_s = 0.0;
  std::vector<ConfirmedMachine> found;
  for (int draw = 0; draw < draws; ++draw) {
    const std::uint64_t seed = 1 + draw;
    std::vector<VectorXd> values{nominal};
    for (const ConfirmedTest& test : tests) {
      const auto load = solver::LoadProgram::parse(test.text, test.name + ".toml", model.machine);
      TestBlock block = program_block(model.machine, load, as_it_is, std::numeric_limits<double>::infinity());
      for (TestPhase& phase : block.phases) phase.probes = phase.name == probe_phase;
      values.push_back(estimate(model, setup, block, machines.measure(seed, {load, test.text})));
    }
    std::vector<std::pair<double, double>> sums(values.size());
    for (const std::string& name : loads) {
      Predicted of{machine_case.load(name), {}};
      of.measured =
          machines.measure(seed, {of.load, core::read_file(machine_case.folder / "loads" / (name + ".toml"))});
      for (std::size_t v = 0; v < values.size(); ++v) {
        const auto [sum, count] =
            squares(model, diagnosis::with_parameters(model.machine, parameters, values[v]), of, poses);
        sums[v].first += sum;
        sums[v].second += count;
      }
    }
    ConfirmedMachine machine;
    for (std::size_t v = 0; v < values.size(); ++v) {
      const double rms = std::sqrt(sums[v].first / std::max(1.0, sums[v].second));
      if (v == 0)
        machine.nominal_um = rms;
      else
        machine.tests_um.push_back(rms);
    }
    found.push_back(std::move(machine));
  }
  return found;
}

}  // namespace thermotwin::study
