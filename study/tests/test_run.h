// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A test on the reduced model: readings of sensors and of a probe along blocks, and their derivatives by the unknowns
//   theta = (parameters, surroundings, start, biases of sensors, noise of the probe's first reading),
// each in standard deviations of its prior. A reading is its nominal value + h(t)^T theta + noise. So a test adds the
// information J = sum h h^T / std^2, and (1 + J)^-1 is the posterior covariance. Each block starts from the thermal
// state at the end of the previous one.

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/load_program.h"
#include "study/placement/responses.h"
#include "study/tests/test_blocks.h"

namespace thermotwin::study {

struct TestSetup {
  std::vector<UncertainParameter> parameters;    ///< parameters that the test estimates
  std::vector<UncertainParameter> surroundings;  ///< ambients, with constant deviations during the test
  std::vector<int> sensors;                      ///< sensors that are read: indices into Machine::sensors
  std::vector<mesh::Pose> probes;                ///< none, or the pose at which dx, dy and dz are probed
  double start_C = 20;                           ///< uniform temperature at the start
  double start_std_K = 0.3;                      ///< standard deviation of start_C
  double reading_s = 600;                        ///< interval between readings of the sensors
  double step_s = 600;                           ///< longest time step
  double bias_K = 0.1;                           ///< standard deviation of a sensor's constant error
  double probe_std_um = 0.5;                     ///< standard deviation of each probed translation
  void validate() const;                         ///< @throws InputError; also if there is neither sensor nor probe
  Eigen::Index unknowns() const;
};

/// Readings at one time.
struct TestReadings {
  double time = 0;            ///< s since the start
  bool probe = false;         ///< dx dy dz since the start in um; else sensors in K above the reference
  Eigen::VectorXd predicted;  ///< (readings) of the nominal machine
  Eigen::MatrixXd rows;       ///< (readings x unknowns) per standard deviation
  Eigen::VectorXd std;        ///< (readings) of their noise
};

class TestRun {
public:
  /// @param model   of the nominal machine
  /// @param values  (parameters) about which the readings are linear
  TestRun(const reduction::ReducedModel& model, const Eigen::VectorXd& values, const TestSetup& setup);
  ~TestRun();

  using Take = std::function<void(const TestReadings&)>;
  /// Advances the state through a block. @param take  gets each reading
  /// @return information J of the block, (unknowns x unknowns)  @throws SolverError
  Eigen::MatrixXd run(const TestBlock& block, const Take& take = nullptr);

  /// A copy of state and time, from which take_up() goes on.
  struct Kept;
  std::shared_ptr<const Kept> keep() const;
  void take_up(const Kept& kept);

  /// Mean of D^T D, with D (translations x parameters) the change of the TCP's translations since the start of a
  /// program, um per standard deviation of each parameter. The mean is over poses, load programs and times, which are
  /// 20 min apart and at corners of the program. @return (parameters x parameters) um^2
  Eigen::MatrixXd prediction(const std::vector<solver::LoadProgram>& loads, const std::vector<mesh::Pose>& poses) const;

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace thermotwin::study
