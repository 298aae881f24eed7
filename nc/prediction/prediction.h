// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// TCP error along the program by the reduced model: the rows of nc/load heat it as they would heat the machine. Each
// move gets the error at the pose where it ends. Between the ends of two rows the thermal state is interpolated. The
// last row, which may be shorter, has a state at its end too.
// The machine begins at a uniform temperature, or as a saved state says (present_machine.h).

#include <functional>
#include <memory>
#include <vector>

#include "compensation/online/online_model.h"
#include "compensation/online/output_map.h"
#include "nc/load/rows.h"
#include "nc/prediction/cycle_drift.h"
#include "nc/prediction/present_machine.h"

namespace thermotwin::nc {

struct PredictionOptions {
  double start_C = 20.0;   ///< uniform temperature of the machine before the program
  double interval = 10.0;  ///< s, of the rows
  int parts = 1;           ///< runs of the program
  void validate() const;   ///< @throws InputError
};

/// The error field at a time between two rows.
class ErrorField {
public:
  explicit ErrorField(const reduction::ReducedModel& model) : map_(model) {}

  /// @param share  0: the row before, 1: the last row
  solver::TcpError error(const Positions& positions, double share) const;
  /// (linear axes) m, what cancels the error
  Eigen::VectorXd offsets(const Positions& positions, double share) const;
  Eigen::VectorXd offsets(const solver::TcpError& error) const { return map_.offsets(error); }
  /// (3) standard deviation of the error's translations from those of the axes' offsets, taken to be independent, in
  /// the unit of the offsets'
  Eigen::Vector3d error_std(const Eigen::VectorXd& of_offsets) const;
  const std::vector<std::string>& axes() const { return map_.axes(); }
  bool outside(const Positions& positions) const { return map_.outside(positions); }
  /// @param shares  what probing has found, as OnlineTwin::output_shares()
  void advance(const Eigen::VectorXd& state, const Eigen::Vector<double, 9>& shares);

private:
  compensation::OutputMap map_;
  compensation::OutputMap::Projected base_, change_;
  Eigen::VectorXd state_;
  Eigen::Vector<double, 9> shares_ = Eigen::Vector<double, 9>::Zero();
};

struct PredictedMove {
  const Timed* timed;
  Positions end;
  double time;   ///< s, of its end
  double share;  ///< of the row in which it ends
  const ErrorField* field;
  Eigen::Vector3d error_um;           ///< tool against table at its end
  Eigen::VectorXd offset_um, std_um;  ///< (linear axes)
  bool outside;                       ///< of the model's workspace
  Eigen::VectorXd ahead_um;           ///< (linear axes) drift of the offset ahead of the last part; empty: not known
};

class Predictor {
public:
  /// @param model  must outlive this  @param present  the machine before the program; none: at options.start_C
  /// @param take  receives each move in the program's order
  Predictor(const reduction::ReducedModel& model, std::unique_ptr<PresentMachine> present, const Positions& start,
            const PredictionOptions& options, std::function<void(const PredictedMove&)> take);

  void add(const Timed& timed);  ///< before the row that ends after it
  void row(const Row& row);
  const std::vector<std::string>& axes() const { return field_.axes(); }
  const compensation::OffsetLimits& limits() const { return online_.limits(); }

private:
  void advance_field();
  void step(double time, const Eigen::VectorXd& channels);
  /// The state at the end of a row that is shorter than a step of the model.
  void end_short_step(const Row& row, const Eigen::VectorXd& channels);
  void take(const Timed& timed, const Row& row);
  void see_part(const PredictedMove& move);

  const reduction::ReducedModel& model_;
  std::unique_ptr<PresentMachine> present_;
  std::unique_ptr<compensation::OnlineModel> cold_;
  compensation::OnlineModel& online_;
  double zero_ = 0;  ///< s, of the program's start on the model's clock
  ErrorField field_;
  PredictionOptions options_;
  std::unique_ptr<CycleDrift> drift_;  ///< of a series of parts
  std::unique_ptr<ErrorField> ahead_;  ///< from the state of now to that of an endless series
  int part_ = -1;                      ///< of the last cutting move
  std::function<void(const PredictedMove&)> take_;
  std::vector<Timed> pending_;
};

}  // namespace thermotwin::nc
