// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Predicts the TCP error along the program. The rows of nc/load drive the reduced model. The error of a point is that
// at its position and time, with the thermal state interpolated between the ends of rows. The last row may be shorter.
// The machine starts at a uniform temperature or from a saved state (present_machine.h).

#include <deque>
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
  double start_C = 20.0;    ///< uniform temperature of the machine before the program
  bool rested = false;      ///< no heat of earlier work is left in the machine; not with a saved state
  double interval = 10.0;   ///< s, of the rows
  int parts = 1;            ///< runs of the program
  double largest_um = 0.0;  ///< limit of an offset; 0: by the model, as that of the rate. A saved state has both
  double rate_um_s = 0.0;
  std::vector<std::string> drives{};  ///< of the process, see Row::process_W
  void validate() const;              ///< @throws InputError
};

/// The error over position and time, for the rows that waiting moves still need.
class ErrorField {
public:
  explicit ErrorField(const reduction::ReducedModel& model) : map_(model) {}

  /// @param time  s, of a row that is kept
  solver::TcpError error(const Positions& positions, double time) const;
  /// (linear axes) m, what cancels the error
  Eigen::VectorXd offsets(const Positions& positions, double time) const;
  Eigen::VectorXd offsets(const solver::TcpError& error) const { return map_.offsets(error); }
  /// (3) standard deviations of the error's translations, from those of the axes' offsets (assumed independent) and in
  /// the same unit
  Eigen::Vector3d error_std(const Eigen::VectorXd& of_offsets) const;
  const std::vector<std::string>& axes() const { return map_.axes(); }
  bool outside(const Positions& positions) const { return map_.outside(positions); }
  /// @param shares  what probing has found, as OnlineTwin::output_shares()  @param time  s, of the row's end
  void advance(const Eigen::VectorXd& state, const Eigen::Vector<double, 9>& shares, double time);
  void forget(double time);  ///< rows that end before it
  /// s, where the course of the state bends: ends of rows within a time
  std::vector<double> bends(double from, double to) const;

private:
  struct Stretch {
    double from, to;  ///< s
    compensation::OutputMap::Projected base, change;
    Eigen::Vector<double, 9> shares;
  };
  const Stretch& at(double time) const;

  compensation::OutputMap map_;
  std::deque<Stretch> rows_;
  Eigen::VectorXd state_;
};

/// A time within a move: the planner's axis positions, and the offsets from the thermal state at this time.
struct MoveSample {
  double time;  ///< s
  double u;     ///< share of the move
  Positions positions;
  Eigen::VectorXd offset_um;  ///< (linear axes)
};

struct PredictedMove {
  const Timed* timed = nullptr;                     ///< its last element
  const std::vector<TimeCourse>* before = nullptr;  ///< its other elements
  const ErrorField* field = nullptr;
  double start = 0, time = 0;  ///< s, of its begin and end
  double length = 0;           ///< along the path, m or rad
  Positions begin, end;
  Eigen::Vector3d error_um;                  ///< tool against table at its end
  Eigen::VectorXd begin_um;                  ///< (linear axes) offsets at its begin
  Eigen::VectorXd offset_um, std_um;         ///< (linear axes) at its end
  Eigen::VectorXd mean_um, low_um, high_um;  ///< (linear axes) offsets over its time
  std::vector<MoveSample> inside;            ///< in the order of time, 1 to 2.5 s apart
  bool outside = false;                      ///< of the model's workspace
  Eigen::VectorXd ahead_um;                  ///< (linear axes) drift of the offset after the last part; empty: unknown

  double duration() const { return time - start; }
  double time_at(double u) const;         ///< s, when a share of the move is done
  double share_at(double seconds) const;  ///< inverse of time_at()
};

class Predictor {
public:
  /// @param model  must outlive this  @param present  the machine before the program; none: at options.start_C
  /// @param take  receives each move in the program's order
  Predictor(const reduction::ReducedModel& model, std::unique_ptr<PresentMachine> present, const Positions& start,
            const PredictionOptions& options, std::function<void(const PredictedMove&)> take);

  void add(const Timed& timed);  ///< before the row that ends after it
  void row(const Row& row);
  const ErrorField& field() const { return field_; }  ///< it has the last row
  const std::vector<std::string>& axes() const { return field_.axes(); }
  const compensation::OffsetLimits& limits() const { return online_.limits(); }

private:
  void advance_field(double time);
  void step(double time, const Eigen::VectorXd& channels);
  /// The state at the end of a row that is shorter than a step of the model.
  void end_short_step(const Row& row, const Eigen::VectorXd& channels);
  /// A move that waits for the row in which it ends.
  struct Moving {
    Timed last;
    std::vector<TimeCourse> before;
    double start = 0, length = 0;
    Positions begin;
  };
  void sample(const Timed& timed);
  void predict_samples(double until);
  void take(const Moving& moving, const Row& row);
  void begin(const Moving& moving);
  void set_range();
  /// @param share  of the last row, at the move's end
  void see_part(const PredictedMove& move, double share);

  const reduction::ReducedModel& model_;
  std::unique_ptr<PresentMachine> present_;
  std::unique_ptr<compensation::OnlineModel> cold_;
  compensation::OnlineModel& online_;
  double zero_ = 0;  ///< s, of the program's start on the model's clock
  ErrorField field_;
  PredictionOptions options_;
  std::unique_ptr<CycleDrift> drift_;  ///< of a series of parts
  std::unique_ptr<ErrorField> ahead_;  ///< at 0 s the present state, at 1 s that of an endless series
  int part_ = -1;                      ///< of the last cutting move
  std::function<void(const PredictedMove&)> take_;
  std::vector<Moving> pending_;
  Moving moving_;  ///< whose last element has not come
  bool open_ = false;
  std::deque<MoveSample> samples_;  ///< of moves that wait; u is the distance in the move so far
  std::size_t predicted_samples_ = 0;
  PredictedMove move_;
};

}  // namespace thermotwin::nc
