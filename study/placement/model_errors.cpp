// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/model_errors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/progress.h"
#include "reduction/basis/second_model.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/campaign.h"

namespace thermotwin::study {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Of a load at its outputs: temperatures of the sensors and translations of the TCP, one column an output.
struct Run {
  MatrixXd sensors_K, tcp_um;
};

Run run_of(const reduction::ReducedModel& model, const solver::LoadProgram& load, const MatrixXd& places,
           const MatrixXd& tcp) {
  reduction::RunRecord record;
  reduction::ReducedRun how;
  how.tell = false;
  how.record = &record;
  reduction::simulate_reduced(model, model.machine, load, {mesh::home_pose(model.machine)}, how);
  MatrixXd states(model.system.order(), std::ssize(record.outputs));
  for (Index i = 0; i < states.cols(); ++i) states.col(i) = record.outputs[i].state;
  return {places * states, tcp * states};
}

Run run_of(const solver::LoadResult& result) {
  const core::Table &sensors = result.sensors, &tcp = result.tcp;
  const Index outputs = sensors.rows(), poses = tcp.rows() / std::max<Index>(1, outputs);
  const Index column = tcp.values.cols() - 18;
  Run run;
  run.sensors_K = sensors.values.rightCols(sensors.values.cols() - 1).transpose();
  run.tcp_um.resize(3 * poses, outputs);
  for (Index i = 0; i < outputs; ++i)
    for (Index p = 0; p < poses; ++p)
      run.tcp_um.block<3, 1>(3 * p, i) = tcp.values.block<1, 3>(i * poses + p, column).transpose();
  return run;
}

}  // namespace

namespace {

/// All loads on another mesh.
struct OtherMesh {
  double factor = 1.0;
  std::vector<Run> runs;
};

VectorXd since_start(const MatrixXd& of, Index i) { return of.col(i) - of.col(0); }

}  // namespace

std::vector<ModelErrors> model_errors(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                                      const reduction::ReducedModel& model,
                                      const std::vector<mesh::SensorSpec>& sensors, const MatrixXd& places,
                                      const MatrixXd& tcp, const std::vector<solver::LoadProgram>& loads,
                                      const std::vector<LoadResponses>& along, const std::filesystem::path& cache,
                                      std::string& others) {
  others.clear();
  std::vector<OtherMesh> meshes;
  const auto run_on = [&](const reduction::SecondModel& other) {
    OtherMesh made{other.factor, {}};
    for (const solver::LoadResult& result : solver::run_campaign(other.full, loads, {}))
      made.runs.push_back(run_of(result));
    meshes.push_back(std::move(made));
    others += (others.empty() ? "" : " and ") + other.words();
  };
  const std::string no_second = reduction::with_second_model(machine_case, mesh, sensors, cache, run_on);
  const std::string no_finer = reduction::with_finer_model(machine_case, mesh, sensors, cache, run_on);
  if (meshes.empty()) {
    core::warn("no other mesh, hence the choice of sensors neglects the mesh error: " + no_second);
  } else if (meshes.size() == 1) {
    core::warn("the mesh error is that of one other mesh: " + (no_second.empty() ? no_finer : no_second));
  }
  std::vector<ModelErrors> found;
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const Run nominal = run_of(model, loads[l], places, tcp);
    const std::vector<double> outputs = loads[l].output_times();
    ModelErrors of;
    of.meshes.resize(meshes.size());
    for (const double time : along[l].times) {
      const Index i = std::lower_bound(outputs.begin(), outputs.end(), time - 1e-6) - outputs.begin();
      of.changes_K.push_back(since_start(nominal.sensors_K, i));
      for (std::size_t m = 0; m < meshes.size(); ++m) {
        const Run& other = meshes[m].runs[l];
        const auto differs = [&](const MatrixXd& one, const MatrixXd& from) -> VectorXd {
          return meshes[m].factor * (since_start(one, i) - since_start(from, i));
        };
        of.meshes[m].places_K.push_back(differs(other.sensors_K, nominal.sensors_K));
        of.meshes[m].tcp_um.push_back(differs(other.tcp_um, nominal.tcp_um));
      }
    }
    found.push_back(std::move(of));
  }
  return found;
}

}  // namespace thermotwin::study
