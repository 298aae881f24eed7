// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A measurement folder: channels.toml says what each column of data.csv is. Used by every model of
// this folder and by the diagnosis; the virtual measurements of the tests are written by it too.

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/table.h"
#include "mesh/machine_mesh.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation {

enum class ChannelKind { temperature, displacement, speed, power, position, flow, state };
enum class Zero { first, absolute };

/// Share of one point in a channel that is a weighted sum of deviations.
struct PointShare {
  std::string pose_text;                             ///< as MeasuredChannel::pose_text
  Eigen::Vector3d weight = Eigen::Vector3d::Zero();  ///< of dx, dy and dz there, in the channel's unit per um
};

struct MeasuredChannel {
  std::string id, unit;  ///< degC K | um um/m | rpm mm_min deg_min | W | mm deg | kg_s | 1
  ChannelKind kind;
  double uncertainty = 0;         ///< one standard deviation, in unit
  std::string sensor;             ///< id in machine.toml, or free where there is no machine
  std::string input;              ///< channel name ("spindle.speed_rpm")
  std::string quantity;           ///< dx dy dz ra rb rc | X0C Y0C Z0T R0T A0C B0C
  std::string direction;          ///< free text where there is no machine
  std::string pose_text;          ///< "X=..,B=.." (mm, deg)
  std::string frame = "machine";  ///< machine | table
  Zero zero = Zero::absolute;
  Eigen::Index column = 0;  ///< in data.csv
  /// The points of a location error that was computed from deviations (tool - table, machine frame):
  ///   value = sum_i weight_i . (dx, dy, dz) at the pose i.
  /// Channels of the same arrangement have the same points. Empty: the definition of the error holds, at pose_text.
  std::vector<PointShare> points;
  std::string arrangement;  ///< id of the points
};

/// A named part of the record: an experiment with a load program of its own.
struct Program {
  std::string name;
  double from_s = 0, to_s = 0;  ///< [from, to)
};

struct Measurement {
  std::filesystem::path folder;
  std::string machine;            ///< name in machine.toml of the recorded machine; empty: not stated
  std::vector<Program> programs;  ///< in order of time, apart from each other; may be empty
  std::vector<MeasuredChannel> channels;
  core::Table data;              ///< first column time_s, rising
  bool rows_at_changes = false;  ///< each change of a speed, power or state has a row at its time
  double starts_at_h = std::numeric_limits<double>::quiet_NaN();  ///< h, time of day at time_s = 0; NaN: not stated

  Eigen::VectorXd time() const { return data.values.col(0); }
  Eigen::VectorXd values(const MeasuredChannel& channel) const { return data.values.col(channel.column); }
};

/// @throws InputError: missing file, unknown kind or unit, a channel without column or a column
///         without channel, time running backwards, an empty file, values beyond 1e10, programs
///         that overlap
Measurement read_measurement(const std::filesystem::path& folder);

void write_measurement(const std::filesystem::path& folder, const Measurement& measurement);

}  // namespace thermotwin::compensation
