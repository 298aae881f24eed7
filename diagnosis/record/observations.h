// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The observations of a diagnosis: means over time intervals of every temperature and displacement channel, and the
// steps on which a model runs along the measured inputs. A channel's weights turn the model's values at the ends of the
// steps, linear between them, into means over the same samples. For zero = "first" they subtract the value at the first
// sample. Gaps and sample intervals are thus treated alike in measurement and model.

#include <Eigen/Core>

#include <algorithm>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "mesh/machine/kinematics.h"
#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

inline constexpr double long_row_s = 60;  ///< sample interval above which the time of a change is uncertain

struct ObservedChannel {
  compensation::MeasuredChannel channel;
  mesh::Pose pose;                     ///< of a displacement; home if the channel states none
  std::vector<Eigen::Index> interval;  ///< (n) index of the interval of each mean, rising
  Eigen::VectorXd time;                ///< (n) s, mean time of its samples
  Eigen::VectorXd value;               ///< (n) in the channel's unit
  Eigen::VectorXd samples;             ///< (n) number of samples
  Eigen::Index fitted = 0;             ///< number of leading means that are fitted; the others are held out
  struct Weight {
    Eigen::Index row, point;
    double value;
  };
  std::vector<Weight> weights;  ///< (n x points) sparse
  int record = 0;               ///< number of its record
  std::string record_name;      ///< of one of several records; empty: there is one

  bool is_temperature() const { return channel.kind == compensation::ChannelKind::temperature; }
  /// A displacement in um, not a rotation.
  bool is_gauge() const { return !is_temperature() && channel.unit == "um"; }
  /// The device with its own clock that it is read by: "temperature" or "displacement".
  std::string device() const {
    return (record_name.empty() ? "" : record_name + "/") + (is_temperature() ? "temperature" : "displacement");
  }
  /// All displacements of its quantity, such as "displacement.dx"; of a temperature its device.
  std::string alike() const { return is_temperature() ? device() : device() + "." + channel.quantity; }
  /// Without the name of its record.
  std::string plain(const std::string& id) const {
    return record_name.empty() ? id : id.substr(record_name.size() + 1);
  }
  /// Whether the id is that of the channel, of its device or of its quantity, in its record or in all of them.
  bool is_called(const std::string& id) const {
    const std::string names[] = {channel.id, device(), alike()};
    return std::any_of(std::begin(names), std::end(names),
                       [&](const std::string& name) { return id == name || id == plain(name); });
  }
  Eigen::Index size() const { return value.size(); }
  /// @param at_points  (points x m)  @return (n x m)
  Eigen::MatrixXd means(const Eigen::MatrixXd& at_points) const;
};

struct Observations {
  std::vector<ObservedChannel> channels;
  double start = 0, split = 0, end = 0;  ///< s; held out from split on
  double interval = 0;                   ///< s, length of an interval
  Eigen::Index intervals = 0;
  Eigen::VectorXd points;  ///< (steps + 1) s, ends of the model's steps
  Eigen::MatrixXd rows;    ///< (steps x channels of the machine) mean inputs of each step
  /// A row that holds for a share of a step.
  struct Part {
    double share;
    Eigen::VectorXd row;
  };
  /// Steps within which speeds, positions or states change: a model takes the mean of the parts' coefficients.
  std::map<Eigen::Index, std::vector<Part>> mixed;
  /// An uncertain time of a change: inputs that may have held over a time span instead of those of the model's steps. A
  /// log states when a change of speed, power or state was recorded, not when it occurred. Of each record the largest
  /// changes first, then what may have run in its pauses.
  struct MayHold {
    double from, to;                     ///< s, the time span
    Eigen::VectorXd row;                 ///< (channels of the machine)
    std::vector<Eigen::Index> channels;  ///< of the row that held; the others are as in the model's steps
    /// Prior standard deviation of the share of the span over which the row held. The change is equally likely at any
    /// time between the recorded row before it and the row that shows it.
    double std;
    double shown;           ///< s, time of the row that shows the change
    bool earlier;           ///< true: the span ends at the assumed time of the change; false: it begins there
    bool in_pause = false;  ///< of what may have run in a pause: no change was seen
    /// @param step  (channels) inputs of a step  @return those that may have held in it
    Eigen::VectorXd in_step(Eigen::VectorXd step) const {
      step(channels) = row(channels);
      return step;
    }
  };
  std::vector<MayHold> may_hold;
  /// What may have run before the record, as in a pause of 36 h that ends with it.
  std::vector<MayHold> before;
  /// All uncertain times of changes: s, of the row before the change and of the row that shows it.
  struct OpenChange {
    double from, shown;
  };
  std::vector<OpenChange> open_changes;
  std::vector<OpenChange> pauses;  ///< of the log: s, of the rows on both sides
  /// Sample interval, s, if it is above long_row_s and may_hold contains every change; else 0.
  double told_row_s = 0;
  std::vector<std::string> left_out;       ///< channels with too few values for a fit
  double start_C = 0, start_spread_K = 0;  ///< median of the first readings; their robust standard deviation
  double start_second_K = 0;  ///< second largest deviation of a first reading from the median: one sensor may be off

  std::string name;  ///< of one of several records
  struct Offset {
    double time = 0;  ///< s, what the common axis adds to the record's own time
    Eigen::Index interval = 0, step = 0;
  };
  Offset offset;  ///< of one of several records: where it begins among all
  /// Several records that are joined here one after another, each with its own time; empty: this is one record.
  std::vector<Observations> records;
  std::span<const Observations> each() const {
    return records.empty() ? std::span<const Observations>(this, 1) : std::span<const Observations>(records);
  }

  Eigen::Index size() const;        ///< number of means of all channels
  Eigen::VectorXd stacked() const;  ///< measured means, channel after channel
};

struct ObserveOptions {
  double interval_s = 600;
  double heldout_share = 0.3;
  double longest_step_s = 300;
  Eigen::Index most_intervals = 600;  ///< a longer record has longer intervals
  /// s; assumed time of a change by the time of the row that shows it, where it differs from the log.
  std::map<double, double> changes = {};

  void validate() const;  ///< @throws InputError
};

/// @return the time from which on a share of the record is held out, s. It lies between two intervals, so that no
///   fitted mean contains a later sample, and after at least four intervals.
double split_between(const Observations& of, double heldout_share);

/// @throws InputError: no temperature or displacement channel, too short a record
Observations observe(const compensation::Measurement& measurement, const mesh::Machine& machine,
                     const solver::Channels& channels, const ObserveOptions& options);

}  // namespace thermotwin::diagnosis
