// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/load_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <optional>
#include <set>
#include <string_view>

#include "core/config.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/time_of_day.h"
#include "core/units.h"
#include "mesh/machine/cutting_fluid.h"
#include "solver/operation/load_program.h"

namespace thermotwin::solver {

using core::InputError;
using core::Node;
using core::Range;

namespace {

constexpr std::string_view power_suffix = ".power_W";

/// Once for each file: verbs read a load program more than once.
void warn_of_no_start(const std::string& place) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  if (said.insert(place).second)
    core::warn(place + ": no time of day at the start: laws of machine.toml over day.time_h contribute 0");
}

}  // namespace

class LoadReader::Reading {
public:
  explicit Reading(const mesh::Machine& machine) : machine_(machine), channels_(machine), row_(channels_.defaults()) {}

  LoadProgram read(const core::Config& config, const std::filesystem::path& path) {
    const Node root = config.root();
    root.schema(1);
    LoadProgram program;
    program.name_ = path.stem().string();
    program.title_ = root.text_or("title", program.name_);
    program.initial_C_ = root.number_or("initial_C", machine_.reference_C);
    machine_.require_plausible(program.initial_C_, root.place("initial_C"));
    program.time_step_ = root.number("time_step_s");
    program.output_ = root.number("output_s");
    read_start(root);
    if (const auto time = root.table_if("time")) program.time_ = read_time(*time);
    if (const auto position = root.table_if("position")) read_positions(*position);
    program.corners_.push_back(0.0);
    for (const Node& phase : root.tables("phase")) read_phase(phase, program);
    if (program.start_.empty()) throw InputError(root.place(), "no phase", "one or more [[phase]]");
    program.schedule_coolants(machine_, channels_);
    require_affordable(root, "time_step_s", program.time_step_, program.duration());
    require_affordable(root, "output_s", program.output_, program.duration());
    root.finish();
    return program;
  }

private:
  double& channel(const std::string& name) { return row_[channels_.index(name)]; }

  struct AxisUnit {
    const mesh::Axis& axis;
    std::string unit;  // "mm", "deg"
    double to_unit;    // units of one SI unit
    Range travel() const {
      if (axis.endless) return {-1e9, 1e9};
      const double slack = 1e-9 * (1.0 + (axis.high - axis.low) * to_unit);
      return {axis.low * to_unit - slack, axis.high * to_unit + slack};
    }
    double fastest() const { return axis.rapid > 0 ? axis.rapid * to_unit * 60.0 * (1.0 + 1e-9) : 1e300; }
  };
  static AxisUnit unit_of(const mesh::Axis& axis) {
    const bool linear = axis.kind == mesh::AxisKind::linear;
    return {axis, linear ? "mm" : "deg", linear ? 1e3 : 180.0 / std::numbers::pi};
  }

  /// The time of day at the start, where a law of the machine asks for it.
  void read_start(const Node& root) {
    const std::string text = root.text_or("starts_at", "");
    if (text.empty()) {
      if (channels_.index(mesh::time_of_day) >= 0) warn_of_no_start(root.place("starts_at"));
      return;
    }
    starts_at_h_ = core::hours_of_day(text);
    if (!starts_at_h_) throw InputError(root.place("starts_at"), "'" + text + "'", core::time_of_day_form);
  }

  void read_positions(const Node& node) {
    for (const mesh::Axis& axis : machine_.axes) {
      const AxisUnit u = unit_of(axis);
      const std::string key = axis.id + "_" + u.unit, name = "axis." + axis.id + ".position_" + u.unit;
      channel(name) = node.number_or(key, channel(name), u.travel());
    }
    node.finish();
  }

  static double read_duration(const Node& phase) {
    struct Unit {
      const char* key;
      double seconds;
    };
    double duration = 0.0;
    int given = 0;
    for (const Unit& unit : {Unit{"duration_h", 3600.0}, Unit{"duration_min", 60.0}, Unit{"duration_s", 1.0}}) {
      if (phase.has(unit.key)) {
        duration = phase.number(unit.key) * unit.seconds;
        ++given;
      }
    }
    if (given != 1) {
      throw InputError(phase.place(), given == 0 ? "no duration" : "more than one duration",
                       "one of: duration_h, duration_min, duration_s");
    }
    return duration;
  }

  /// A slip of a digit in a duration or step must not fill the memory.
  static void require_affordable(const Node& root, const char* key, double interval, double duration) {
    constexpr double most = 1e7;
    if (duration / interval > most) {
      throw InputError(root.place(key), fmt::format("{} s in a program of {} s", interval, duration),
                       fmt::format("at most {:.0f} intervals: {} s or more", most, duration / most));
    }
  }

  /// A number, or [from, to] for a ramp over the phase.
  static std::pair<double, double> read_ramp(const Node& phase, const std::string& key) {
    const std::vector<double> values = phase.is_list(key) ? phase.numbers(key) : std::vector<double>{phase.number(key)};
    if (values.empty() || values.size() > 2) {
      throw InputError(phase.place(key), fmt::format("{} numbers", values.size()),
                       "a number, or [from, to] for a ramp");
    }
    return {values.front(), values.back()};
  }

  /// Motion of one axis in one phase, on top of a standing row.
  void read_axis(const Node& node, Eigen::VectorXd& motion, std::set<std::string>& seen, bool machine_on) {
    const std::string id = node.text("id");
    const int index = machine_.axis_index(id);
    if (index < 0) {
      std::vector<std::string> ids;
      for (const mesh::Axis& axis : machine_.axes) ids.push_back(axis.id);
      throw InputError(node.place("id"), "unknown axis '" + id + "'", "one of: " + core::join(ids));
    }
    if (!seen.insert(id).second)
      throw InputError(node.place("id"), "axis '" + id + "' twice in a phase", "each axis once a phase");
    const AxisUnit u = unit_of(machine_.axes[index]);
    const auto key = [&](const char* name) { return std::string(name) + "_" + u.unit; };
    const std::string prefix = "axis." + id + ".";
    const auto at = [&](const std::string& name) -> double& { return motion[channels_.index(prefix + name)]; };
    const Range travel = u.travel();
    const double duty = node.number("duty_percent") / 100.0;
    const double before = channel(prefix + key("position"));
    const int positive = channels_.index(prefix + "positive.on");
    // A law of the power while the axis holds: after the phase it has come to its stated position from either side.
    const auto set_direction = [&](double last) {
      if (positive >= 0) row_[positive] = motion[positive] = last;
    };

    double feed = 0.0;
    if (u.axis.kind == mesh::AxisKind::rotary && node.has("speed_rpm")) {
      feed = 360.0 * node.number("speed_rpm", Range{0.0, u.fastest() / 360.0});
      if (!u.axis.endless) {
        throw InputError(node.place("speed_rpm"), "a speed for axis '" + id + "' with limits",
                         "low_deg, high_deg and feed_deg_min");
      }
      if (node.has(key("low")) || node.has(key("high")) || node.has(key("feed") + "_min")) {
        throw InputError(node.place("speed_rpm"), "speed_rpm beside low_deg, high_deg or feed_deg_min",
                         "one of the two ways");
      }
      if (feed > 0.0 && duty > 0.0) {
        at("low_deg") = before;
        at("high_deg") = before + 360.0;
        set_direction(either_direction);
      }
    } else if (node.has(key("low")) || node.has(key("high"))) {
      const double low = node.number(key("low"), travel), high = node.number(key("high"), travel);
      if (!(high > low)) {
        throw InputError(node.place(key("high")), fmt::format("{}", high),
                         fmt::format("a number above {} = {}", key("low"), low));
      }
      if (node.has(key("position"))) {
        throw InputError(node.place(key("position")), "a position beside a range",
                         "either the position or low and high");
      }
      at(key("low")) = low;
      at(key("high")) = high;
      at(key("position")) = 0.5 * (low + high);
      feed = node.number(key("feed") + "_min", Range{0.0, u.fastest()});
      // An axis that moves for no part of the phase stands in the middle of its range.
      if (feed == 0.0 || duty == 0.0) at(key("low")) = at(key("high")) = not_given;
      set_direction(either_direction);
    } else if (node.has(key("position"))) {
      const double now = node.number(key("position"), travel);
      if (now != before) set_direction(now > before ? 1.0 : 0.0);
      at(key("position")) = channel(prefix + key("position")) = now;
    } else {
      throw InputError(node.place(), "no motion",
                       "low and high with a feed, or a position" + std::string(u.axis.endless ? ", or speed_rpm" : "") +
                           ", in " + u.unit);
    }
    if (const int clamped = channels_.index(prefix + "clamp.on"); clamped >= 0) {
      const bool held = node.boolean("clamped");
      motion[clamped] = held ? 1.0 : 0.0;
      if (held && feed * duty > 0.0)
        throw InputError(node.place("clamped"), "a moving axis that is clamped", "clamped = false, or a position");
    } else if (node.has("clamped")) {
      throw InputError(node.place("clamped"), "a clamp of axis '" + id + "'",
                       "an axis with a holding law or a joint with clamped_pressure_MPa");
    }
    if (feed * duty > 0.0 && !machine_on)
      throw InputError(node.place(), "a moving axis while machine_on = false", "no motion, or machine_on = true");
    at(key("feed") + "_min") = feed * duty;
    node.finish();
  }

  /// The doors that stand open; those not named are closed.
  void read_doors(const Node& phase) {
    for (const std::string& door : machine_.doors) channel("door." + door + ".open") = 0.0;
    for (const std::string& id : phase.texts("doors_open")) {
      if (std::find(machine_.doors.begin(), machine_.doors.end(), id) == machine_.doors.end()) {
        throw InputError(phase.place("doors_open"), "unknown door '" + id + "'",
                         machine_.doors.empty() ? "a [[door]] of machine.toml, which has none"
                                                : "one of: " + core::join(machine_.doors));
      }
      channel("door." + id + ".open") = 1.0;
    }
  }

  void refuse_unknown_drives(const Node& phase) const {
    std::vector<std::string> known{"process_W"};
    for (const std::string& name : channels_.names()) {
      if (name.ends_with(power_suffix)) known.push_back(name.substr(0, name.size() - power_suffix.size()) + "_W");
    }
    for (const std::string& key : phase.keys()) {
      if (!key.ends_with("_W") || std::find(known.begin(), known.end(), key) != known.end()) continue;
      const std::vector<std::string> drives(known.begin() + 1, known.end());
      throw InputError(phase.place(key), "no drive of this name",
                       drives.empty() ? "no power of a drive: no [[source]] of machine.toml has a `drive`"
                                      : "one of: " + core::join(drives));
    }
  }

  /// Powers of drives. A source's own laws stand unless a phase sets the power.
  void read_powers(const Node& phase) {
    for (const std::string& name : channels_.names()) {
      if (!name.ends_with(power_suffix)) continue;
      const std::string key = name.substr(0, name.size() - power_suffix.size()) + "_W";
      if (phase.has(key)) channel(name) = phase.number(key);
    }
    refuse_unknown_drives(phase);
    if (channels_.index("process.power_W") >= 0 || !phase.has("process_W")) return;
    if (const double power = phase.number("process_W"); power > 0.0)
      throw InputError(phase.place("process_W"), fmt::format("{} W", power),
                       "0, or a [[source]] with drive = \"process\" in machine.toml");
  }

  /// Switches that no part of the machine listens to.
  void refuse_without_effect(const Node& phase) const {
    if (machine_.coolants.empty() && phase.boolean_or("coolant", false))
      throw InputError(phase.place("coolant"), "true", "false, or a [[coolant]] in machine.toml, which has none");
    if (!mesh::has_cutting_fluid(machine_) && phase.boolean_or("cutting_fluid", false)) {
      throw InputError(phase.place("cutting_fluid"), "true",
                       "false, or a [[film]] with state = \"cutting_fluid.on\" or a law over it in machine.toml, which "
                       "has none");
    }
  }

  void read_phase(const Node& phase, LoadProgram& program) {
    program.phase_names_.push_back(phase.text_or("name", fmt::format("phase {}", program.start_.size() + 1)));
    program.corners_.push_back(program.corners_.back() + read_duration(phase));
    channel("machine.on") = phase.boolean_or("machine_on", channel("machine.on") != 0.0) ? 1.0 : 0.0;
    const bool on = channel("machine.on") != 0.0;
    const double fastest = machine_.spindle_max_rpm > 0 ? machine_.spindle_max_rpm : 1e6;
    channel("spindle.speed_rpm") = phase.number_or("spindle_rpm", channel("spindle.speed_rpm"), Range{0.0, fastest});
    if (!on && phase.has("spindle_rpm") && channel("spindle.speed_rpm") > 0.0) {
      throw InputError(phase.place("spindle_rpm"), "a turning spindle while machine_on = false",
                       "0, or machine_on = true");
    }
    refuse_without_effect(phase);
    channel("cutting_fluid.on") = phase.boolean_or("cutting_fluid", channel("cutting_fluid.on") != 0.0) ? 1.0 : 0.0;
    for (const mesh::CoolantSpec& coolant : machine_.coolants) {
      double& state = channel("coolant." + coolant.id + ".on");
      state = phase.boolean_or("coolant", state != 0.0) ? 1.0 : 0.0;
    }
    read_powers(phase);
    if (phase.has("doors_open")) read_doors(phase);

    Eigen::VectorXd start = row_, end = row_;
    const auto ramp = [&](const std::string& key, const std::string& name) {
      if (!phase.has(key)) return;
      const int index = channels_.index(name);
      std::tie(start[index], end[index]) = read_ramp(phase, key);
      row_[index] = end[index];
    };
    const auto temperature_ramp = [&](const std::string& id) {
      ramp(id + "_C", id + ".T_C");
      if (!phase.has(id + "_C")) return;
      const int index = channels_.index(id + ".T_C");
      for (const double value : {start[index], end[index]}) machine_.require_plausible(value, phase.place(id + "_C"));
    };
    for (const mesh::AmbientSpec& ambient : machine_.ambients) {
      temperature_ramp(ambient.id);
      if (ambient.has_gradient) ramp(ambient.id + "_gradient_K_m", ambient.id + ".gradient_K_m");
    }
    for (const mesh::VolumeSpec& volume : machine_.volumes) temperature_ramp(volume.id);
    Eigen::VectorXd motion = row_;
    std::set<std::string> seen;
    for (const Node& axis : phase.tables("axis")) read_axis(axis, motion, seen, on);
    phase.finish();

    for (const mesh::Axis& axis : machine_.axes) {
      const std::string unit = unit_of(axis).unit, prefix = "axis." + axis.id + ".";
      for (const std::string& name : {"position_" + unit, "feed_" + unit + "_min", "low_" + unit, "high_" + unit}) {
        const int index = channels_.index(prefix + name);
        start[index] = end[index] = motion[index];
      }
      for (const char* const name : {"clamp.on", "positive.on"})
        if (const int index = channels_.index(prefix + name); index >= 0) start[index] = end[index] = motion[index];
    }
    if (!on) {
      const auto silence = [&](const std::string& name) {
        start[channels_.index(name)] = end[channels_.index(name)] = 0.0;
      };
      silence("spindle.speed_rpm");
      silence("cutting_fluid.on");
      for (const mesh::CoolantSpec& coolant : machine_.coolants) silence("coolant." + coolant.id + ".on");
      for (const std::string& name : channels_.names())
        if (name.ends_with(power_suffix) && (std::isfinite(channel(name)) || name == "process.power_W")) silence(name);
    }
    if (const int hour = channels_.index(mesh::time_of_day); hour >= 0 && starts_at_h_) {
      const std::size_t corners = program.corners_.size();
      start[hour] = *starts_at_h_ + program.corners_[corners - 2] / core::units::hour;
      end[hour] = *starts_at_h_ + program.corners_[corners - 1] / core::units::hour;
    }
    program.start_.push_back(std::move(start));
    program.end_.push_back(std::move(end));
  }

  const mesh::Machine& machine_;
  Channels channels_;
  std::optional<double> starts_at_h_;
  Eigen::VectorXd row_;  // what holds until a phase says otherwise; axes stand
};

LoadProgram LoadReader::read(const core::Config& config, const std::filesystem::path& path,
                             const mesh::Machine& machine) {
  return Reading(machine).read(config, path);
}

}  // namespace thermotwin::solver
