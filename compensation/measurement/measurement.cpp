// SPDX-License-Identifier: GPL-3.0-or-later
// Reading and writing a measurement folder.

#include "compensation/measurement/measurement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "compensation/measurement/channel_keys.h"
#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/text.h"
#include "core/time_of_day.h"
#include "core/unique_id.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;

constexpr double largest = 1e10;  ///< no quantity of a machine is larger in its unit

struct Kind {
  ChannelKind kind;
  const char* word;
  std::vector<std::string> units;
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = {
      {ChannelKind::temperature, "temperature", {"degC", "K"}},
      {ChannelKind::displacement, "displacement", {"um", "um/m"}},
      {ChannelKind::speed, "speed", {"rpm", "mm_min", "deg_min"}},
      {ChannelKind::power, "power", {"W"}},
      {ChannelKind::position, "position", {"mm", "deg"}},
      {ChannelKind::flow, "flow", {"kg_s"}},
      {ChannelKind::state, "state", {"1", "K/m", "h"}},
  };
  return all;
}

const Kind& kind_of(ChannelKind kind) {
  return *std::find_if(kinds().begin(), kinds().end(), [kind](const Kind& k) { return k.kind == kind; });
}

const Kind& kind_named(const std::string& word) {
  return *std::find_if(kinds().begin(), kinds().end(), [&](const Kind& k) { return k.word == word; });
}

/// `pose = {X_mm = 1, B_deg = 45}` as "X=1,B=45", the form of the command line.
std::string read_pose(const core::Node& node) {
  const auto pose = node.table_if("pose");
  if (!pose) return "";
  std::string text;
  for (const std::string& key : pose->keys()) {
    const bool known_unit = key.ends_with("_mm") || key.ends_with("_deg");
    const std::string axis = key.substr(0, key.find('_'));
    if (!known_unit || axis.empty() || axis.size() + (key.ends_with("_mm") ? 3U : 4U) != key.size()) {
      throw InputError(pose->place(key), "'" + key + "'", "an axis with its unit, such as X_mm or B_deg");
    }
    const double value = pose->number(key);
    text += fmt::format("{}{}={}", text.empty() ? "" : ",", axis, value);
  }
  pose->finish();
  return text;
}

/// Poses of the points of each test.
using Arrangements = std::map<std::string, std::vector<std::string>>;

Arrangements read_arrangements(const core::Node& root) {
  Arrangements all;
  std::vector<std::string> seen;
  for (const core::Node& node : root.tables("arrangement")) {
    const std::string id = node.text("id");
    core::require_unique_id(id, node.place("id"), seen);
    std::vector<std::string>& poses = all[id];
    for (const core::Node& point : node.tables("point")) {
      poses.push_back(read_pose(point));
      point.finish();
    }
    if (poses.empty()) throw InputError(node.place(), "no point", "one [[arrangement.point]] or more");
    node.finish();
  }
  return all;
}

/// Rotations and their location errors are in um/m.
bool is_rotation(const std::string& quantity) { return std::string("rABC").find(quantity[0]) != std::string::npos; }

/// The points and weights of a location error.
void read_points(const core::Node& node, const Arrangements& arrangements, MeasuredChannel& channel) {
  if (!node.has("arrangement")) {
    if (node.has("weights")) throw InputError(node.place("weights"), "weights without an arrangement", "both");
    return;
  }
  channel.arrangement = node.text("arrangement");
  const auto found = arrangements.find(channel.arrangement);
  if (found == arrangements.end()) {
    std::vector<std::string> ids;
    for (const auto& [id, poses] : arrangements) ids.push_back(id);
    throw InputError(node.place("arrangement"), "'" + channel.arrangement + "'",
                     ids.empty()
                         ? "the id of an [[arrangement]]; there is none"
                         : "the id of an [[arrangement]] (nearest: " + core::nearest(channel.arrangement, ids) + ")");
  }
  if (channel.quantity.size() != 3)
    throw InputError(node.place("arrangement"), "an arrangement of '" + channel.quantity + "'", "a location error");
  for (const char* other : {"pose", "frame"}) {
    if (node.has(other))
      throw InputError(node.place(other), std::string(other) + " beside an arrangement", "one of them");
  }
  const std::vector<double> weights = node.has("weights") ? node.numbers("weights") : std::vector<double>();
  const std::vector<std::string>& poses = found->second;
  if (weights.size() != 3 * poses.size()) {
    throw InputError(node.place(node.has("weights") ? "weights" : "arrangement"),
                     fmt::format("{} weights for {} points", weights.size(), poses.size()),
                     fmt::format("{}: three for each point", 3 * poses.size()));
  }
  if (std::all_of(weights.begin(), weights.end(), [](double weight) { return weight == 0.0; }))
    throw InputError(node.place("weights"), "all weights 0", "at least one other than 0");
  for (std::size_t i = 0; i < poses.size(); ++i)
    channel.points.push_back({poses[i], {weights[3 * i], weights[3 * i + 1], weights[3 * i + 2]}});
}

MeasuredChannel read_channel(const core::Node& node, const Arrangements& arrangements, std::vector<std::string>& seen) {
  MeasuredChannel channel;
  channel.id = node.text("id");
  // Column names may hold more than ids of machine.toml do ("dx@1"), but not what ends a cell.
  if (channel.id.empty() || channel.id.find_first_of(",;\"\n\r\t ") != std::string::npos) {
    throw InputError(node.place("id"), "'" + channel.id + "'", "a name without comma, semicolon, quote or blank");
  }
  if (std::find(seen.begin(), seen.end(), channel.id) != seen.end()) {
    throw InputError(node.place("id"), "'" + channel.id + "' a second time", "each id once");
  }
  seen.push_back(channel.id);
  const Kind& kind = kind_named(node.choice("kind"));
  channel.kind = kind.kind;
  channel.unit = node.choice("unit", kind.units);
  const bool observed =
      channel.kind == ChannelKind::displacement || (channel.kind == ChannelKind::temperature && !node.has("input"));
  // What a model is compared with must say how good it is; what drives it may go without.
  channel.uncertainty = observed ? node.number("uncertainty", core::positive) : node.number_or("uncertainty", 0.0);
  channel.sensor = node.text("sensor");
  channel.input = node.text("input");
  channel.direction = node.text("direction");
  if (channel.kind == ChannelKind::displacement) {
    if (node.has("quantity")) channel.quantity = node.choice("quantity");
    channel.pose_text = read_pose(node);
    channel.frame = node.choice("frame");
    channel.zero = node.choice("zero") == "first" ? Zero::first : Zero::absolute;
    if (!channel.quantity.empty()) {
      const std::string unit = is_rotation(channel.quantity) ? "um/m" : "um";
      if (channel.unit != unit) {
        throw InputError(node.place("unit"), "'" + channel.unit + "' for " + channel.quantity, "'" + unit + "'");
      }
    }
    read_points(node, arrangements, channel);
  }
  if (!channel.sensor.empty() && !channel.input.empty()) {
    throw InputError(node.place("input"), "sensor and input in one channel", "one of them");
  }
  node.finish();
  return channel;
}

void check_columns(Measurement& measurement, const std::string& channels_file) {
  const core::Table& data = measurement.data;
  std::vector<std::string> ids;
  for (MeasuredChannel& channel : measurement.channels) {
    ids.push_back(channel.id);
    const auto column = data.find(channel.id);
    if (!column) {
      throw InputError(data.source + ":1", "no column for channel '" + channel.id + "' of " + channels_file,
                       "a column for each [[channel]] (nearest: " + core::nearest(channel.id, data.columns) +
                           "), or no [[channel]] of this id");
    }
    channel.column = *column;
    for (Eigen::Index i = 0; i < data.rows(); ++i) {
      const double value = data.values(i, *column);
      if (std::isnan(value) || std::abs(value) <= largest) continue;
      throw InputError(fmt::format("{}:{} {}", data.source, core::Table::line_of_row(i), channel.id),
                       fmt::format("{}", value),
                       fmt::format("a number of at most {:.0e}, blank or nan (missing)", largest));
    }
    if (channel.kind != ChannelKind::state || channel.unit != "1") continue;
    for (Eigen::Index i = 0; i < data.rows(); ++i) {
      const double value = data.values(i, *column);
      if (value < 0.0 || value > 1.0) {
        throw InputError(fmt::format("{}:{} {}", data.source, core::Table::line_of_row(i), channel.id),
                         fmt::format("{}", value), "a state: 0 (off) to 1 (on), or nan");
      }
    }
  }
  for (std::size_t i = 1; i < data.columns.size(); ++i) {
    if (std::find(ids.begin(), ids.end(), data.columns[i]) != ids.end()) continue;
    throw InputError(fmt::format("{}:1 column {}", data.source, i + 1), "'" + data.columns[i] + "'",
                     "a channel of " + channels_file + " (nearest: " + core::nearest(data.columns[i], ids) + ")");
  }
}

std::vector<Program> read_programs(const core::Node& root) {
  std::vector<Program> programs;
  for (const core::Node& node : root.tables("program")) {
    Program program{node.text("name"), node.number("from_s"), node.number("to_s")};
    if (program.name.empty() || program.name == "training" || program.name.starts_with("day ")) {
      throw InputError(node.place("name"), "'" + program.name + "'", "a name of its own, not 'training' or 'day ...'");
    }
    if (!(program.to_s > program.from_s)) {
      throw InputError(node.place("to_s"), fmt::format("{}", program.to_s),
                       fmt::format("later than from_s = {}", program.from_s));
    }
    for (const Program& before : programs) {
      if (before.name == program.name)
        throw InputError(node.place("name"), "'" + program.name + "' a second time", "each name once");
    }
    if (!programs.empty() && program.from_s < programs.back().to_s) {
      throw InputError(node.place("from_s"), fmt::format("{}", program.from_s),
                       fmt::format("at least {}, where '{}' ends", programs.back().to_s, programs.back().name));
    }
    node.finish();
    programs.push_back(std::move(program));
  }
  return programs;
}

/// "X=1,B=45" as `X_mm = 1, B_deg = 45`.
std::string pose_keys(const std::string& text) {
  std::string pose;
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t comma = std::min(text.find(',', start), text.size());
    const std::string part = text.substr(start, comma - start);
    const std::size_t equals = part.find('=');
    const std::string axis = part.substr(0, equals);
    // Rotary axes are A, B, C by ISO 841; everything else moves straight.
    const bool turns = axis.find_first_of("ABC") == 0;
    pose += fmt::format("{}{}{} = {}", pose.empty() ? "" : ", ", axis, turns ? "_deg" : "_mm", part.substr(equals + 1));
    start = comma + 1;
  }
  return pose;
}

/// The points of all tests, each once.
void write_arrangements(const Measurement& measurement, fmt::appender out) {
  std::vector<std::string> written;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.points.empty() || std::find(written.begin(), written.end(), channel.arrangement) != written.end())
      continue;
    written.push_back(channel.arrangement);
    fmt::format_to(out, "[[arrangement]]\nid = \"{}\"\n", channel.arrangement);
    for (const PointShare& point : channel.points)
      fmt::format_to(out, "[[arrangement.point]]\npose = {{{}}}\n", pose_keys(point.pose_text));
  }
}

double read_hour(const core::Node& node, const std::string& key) {
  const std::string text = node.text(key);
  if (const std::optional<double> hours = core::hours_of_day(text)) return *hours;
  throw InputError(node.place(key), "'" + text + "'", core::time_of_day_form);
}

}  // namespace

Measurement read_measurement(const std::filesystem::path& folder) {
  const auto channels_path = folder / "channels.toml";
  const auto data_path = folder / "data.csv";
  for (const auto& path : {channels_path, data_path}) {
    if (!std::filesystem::is_regular_file(path)) {
      throw InputError(folder.string(), "no file " + path.filename().string(),
                       "a measurement folder with channels.toml and data.csv");
    }
  }
  const core::Config config = core::Config::load(channels_path, &channel_keys());
  const core::Node root = config.root();
  if (root.has("schema")) root.schema(1);
  Measurement measurement;
  measurement.folder = folder;
  if (const auto record = root.table_if("record")) {
    if (record->has("machine")) measurement.machine = record->text("machine");
    measurement.rows_at_changes = record->boolean("rows_at_changes");
    if (record->has("starts_at")) measurement.starts_at_h = read_hour(*record, "starts_at");
    record->finish();
  }
  std::vector<std::string> seen{"time_s"};
  const Arrangements arrangements = read_arrangements(root);
  for (const core::Node& node : root.tables("channel"))
    measurement.channels.push_back(read_channel(node, arrangements, seen));
  measurement.programs = read_programs(root);
  root.finish();
  if (measurement.channels.empty()) {
    throw InputError(channels_path.string(), "no channel", "one [[channel]] for each column of data.csv");
  }
  measurement.data = core::read_csv(data_path);
  if (measurement.data.rows() == 0) {
    throw InputError(data_path.string(), "no rows", "at least one row of numbers below the column names");
  }
  core::require_time_column(measurement.data);
  for (const Eigen::Index i : {Eigen::Index{0}, measurement.data.rows() - 1}) {
    constexpr double longest = 1e11;  // s; 3000 years
    const double time = measurement.data.values(i, 0);
    if (!(std::abs(time) <= longest)) {
      throw InputError(fmt::format("{}:{} time_s", data_path.string(), core::Table::line_of_row(i)),
                       fmt::format("{}", time), fmt::format("a number of at most {:.0e}", longest));
    }
  }
  check_columns(measurement, channels_path.string());
  return measurement;
}

void write_measurement(const std::filesystem::path& folder, const Measurement& measurement) {
  fmt::memory_buffer text;
  const auto out = fmt::appender(text);
  fmt::format_to(out, "schema = 1\n");
  const bool timed = std::isfinite(measurement.starts_at_h);
  if (!measurement.machine.empty() || measurement.rows_at_changes || timed) fmt::format_to(out, "[record]\n");
  if (!measurement.machine.empty()) fmt::format_to(out, "machine = {}\n", core::toml_text(measurement.machine));
  if (measurement.rows_at_changes) fmt::format_to(out, "rows_at_changes = true\n");
  if (timed) {
    const long minutes = std::lround(60.0 * measurement.starts_at_h) % (24 * 60);
    fmt::format_to(out, "starts_at = \"{:02}:{:02}\"\n", minutes / 60, minutes % 60);
  }
  write_arrangements(measurement, out);
  for (const MeasuredChannel& channel : measurement.channels) {
    fmt::format_to(out, "[[channel]]\nid = \"{}\"\nkind = \"{}\"\nunit = \"{}\"\nuncertainty = {}\n", channel.id,
                   kind_of(channel.kind).word, channel.unit, channel.uncertainty);
    if (!channel.sensor.empty()) fmt::format_to(out, "sensor = \"{}\"\n", channel.sensor);
    if (!channel.input.empty()) fmt::format_to(out, "input = \"{}\"\n", channel.input);
    if (!channel.direction.empty()) fmt::format_to(out, "direction = \"{}\"\n", channel.direction);
    if (channel.kind != ChannelKind::displacement) continue;
    if (!channel.quantity.empty()) fmt::format_to(out, "quantity = \"{}\"\n", channel.quantity);
    if (!channel.pose_text.empty()) {
      fmt::format_to(out, "pose = {{{}}}\n", pose_keys(channel.pose_text));
    }
    if (channel.points.empty()) {
      fmt::format_to(out, "frame = \"{}\"\n", channel.frame);
    } else {
      std::vector<double> weights;
      for (const PointShare& point : channel.points)
        weights.insert(weights.end(), point.weight.begin(), point.weight.end());
      fmt::format_to(out, "arrangement = \"{}\"\nweights = [{:.10g}]\n", channel.arrangement, fmt::join(weights, ", "));
    }
    fmt::format_to(out, "zero = \"{}\"\n", channel.zero == Zero::first ? "first" : "absolute");
  }
  for (const Program& program : measurement.programs) {
    fmt::format_to(out, "[[program]]\nname = \"{}\"\nfrom_s = {}\nto_s = {}\n", program.name, program.from_s,
                   program.to_s);
  }
  core::write_csv(folder / "data.csv", measurement.data, 10);
  core::write_file(folder / "channels.toml", std::string_view(text.data(), text.size()));
}

}  // namespace thermotwin::compensation
