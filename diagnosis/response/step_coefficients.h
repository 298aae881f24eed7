// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One machine's way from the channels of a record to the coefficients of each step of propagation.h, with its chillers
// and its factors that change in the course of the record.

#include <Eigen/Core>

#include <optional>
#include <vector>

#include "diagnosis/causes/machine_in_time.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "diagnosis/record/observations.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/chiller.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::diagnosis {

class StepCoefficients {
public:
  StepCoefficients(const reduction::ReducedModel& reduced, const MachineInTime& machine);

  /// Of a step: the mean of those of its parts.
  /// @param sensors_K (sensors) temperatures at the sensors, without their offsets  @param ambient, by_K  moved by so
  ///   much
  /// @param held  null, or inputs that hold for a while instead
  void update(const Observations& obs, Eigen::Index step, const Eigen::VectorXd& sensors_K, int ambient = 0,
              double by_K = 0.0, const Observations::MayHold* held = nullptr);
  /// Of sources that the reduced model's own layout does not have.
  void add_heat(Eigen::VectorXd& heat, double factor) const;

  const Eigen::VectorXd& p() const { return c_.p; }  ///< of the last step
  const Eigen::VectorXd& q() const { return c_.q; }
  const std::optional<solver::Chiller>& chiller() const { return chiller_; }
  void set_chiller(const std::optional<solver::Chiller>& chiller) { chiller_ = chiller; }

private:
  /// The machine from a time of the record on.
  struct Afterwards {
    double from_s;
    solver::OperatingModel model;
  };
  void between(double begin, double end, const Eigen::VectorXd& row, const Eigen::VectorXd& inlets,
               const Eigen::VectorXd& readings, solver::Coefficients& out);
  Eigen::VectorXd disturbed(const Eigen::VectorXd& row, int ambient, double by_K) const;
  void coefficients(double begin, double end, const Eigen::VectorXd& measured, const Eigen::VectorXd& readings,
                    int ambient, double by_K, double duration, solver::Coefficients& out);

  AddedSources added_;
  solver::OperatingModel model_;
  std::vector<Afterwards> afterwards_;  ///< rising times
  Eigen::VectorXd sensor_offsets_;
  std::optional<solver::Chiller> chiller_;
  solver::Coefficients c_, part_, then_;
};

}  // namespace thermotwin::diagnosis
