// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A measurement as the diagnosis sees it: means over intervals of time of every temperature and
// displacement channel, and the steps on which a model runs along the measured inputs. A channel's
// weights turn a model's values at the ends of the steps into the same means over the same samples
// (straight lines in between), less the value at its first sample where its zero stands there; so
// gaps and channels of different sampling are treated alike on both sides.

#include <Eigen/Core>

#include <map>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "mesh/machine/kinematics.h"
#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

inline constexpr double long_row_s = 120;  ///< rows closer together say well enough when something changed

struct ObservedChannel {
  compensation::MeasuredChannel channel;
  mesh::Pose pose;                     ///< of a displacement: home where the channel names none
  std::vector<Eigen::Index> interval;  ///< (n) which interval each mean belongs to, rising
  Eigen::VectorXd time;                ///< (n) s, mean time of its samples
  Eigen::VectorXd value;               ///< (n) in the channel's unit
  Eigen::VectorXd samples;             ///< (n) count
  Eigen::Index fitted = 0;             ///< the first so many are fitted, the rest only judged
  struct Weight {
    Eigen::Index row, point;
    double value;
  };
  std::vector<Weight> weights;  ///< (n x points) sparse

  bool is_temperature() const { return channel.kind == compensation::ChannelKind::temperature; }
  /// A displacement in um, not a rotation.
  bool is_gauge() const { return !is_temperature() && channel.unit == "um"; }
  /// The device with its own clock that it is read by: "temperature" or "displacement".
  std::string device() const { return is_temperature() ? "temperature" : "displacement"; }
  Eigen::Index size() const { return value.size(); }
  /// @param at_points  (points x m)  @return (n x m)
  Eigen::MatrixXd means(const Eigen::MatrixXd& at_points) const;
};

struct Observations {
  std::vector<ObservedChannel> channels;
  double start = 0, split = 0, end = 0;  ///< s; what lies behind split is held out
  double interval = 0;                   ///< s
  Eigen::Index intervals = 0;
  Eigen::VectorXd points;  ///< (steps + 1) s, ends of the model's steps
  Eigen::MatrixXd rows;    ///< (steps x channels of the machine) inputs of each step, their mean
  /// Rows that held one after the other, for so large a share of the step.
  struct Part {
    double share;
    Eigen::VectorXd row;
  };
  /// Steps within which speeds, positions or states change: a model takes the mean of the parts' coefficients.
  std::map<Eigen::Index, std::vector<Part>> mixed;
  /// Inputs that may have held for a while instead of those that the model's steps have: a log says when it saw a
  /// speed, power or state changed, not when that changed. The largest changes first.
  struct MayHold {
    double from, to;
    Eigen::VectorXd row;
    double
        /// Prior, of the share of the while: the change comes anywhere alike from the first while's start to the row
        /// that shows it
        std;
    double shown;  ///< s, time of that row
    bool earlier;  ///< the while ends when the change is taken to come, else it begins then
  };
  std::vector<MayHold> may_hold;
  /// Usual time between rows, where it is long and each change between them is in may_hold; else 0.
  double told_row_s = 0;
  std::vector<std::string> left_out;       ///< channels with too few values to be fitted
  double start_C = 0, start_spread_K = 0;  ///< mean of the first readings, their standard deviation

  Eigen::Index size() const;        ///< means of all channels
  Eigen::VectorXd stacked() const;  ///< measured means, channel after channel
};

struct ObserveOptions {
  double interval_s = 600;
  double heldout_share = 0.3;
  double longest_step_s = 300;
  Eigen::Index most_intervals = 600;  ///< longer records get longer intervals
  /// s; when that came which the rows of these times show first, if not as the log says.
  std::map<double, double> changes = {};

  void validate() const;  ///< @throws InputError
};

/// Time from which on a share of the record is held out: between two intervals, so that no mean that is fitted has a
/// sample from behind it, with four intervals before it at least.
double split_between(const Observations& of, double heldout_share);

/// @throws InputError: no temperature or displacement channel, too short a record
Observations observe(const compensation::Measurement& measurement, const mesh::Machine& machine,
                     const solver::Channels& channels, const ObserveOptions& options);

}  // namespace thermotwin::diagnosis
