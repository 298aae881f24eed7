// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tests/test_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/range.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/plan/load_intervals.h"
#include "solver/operation/channels.h"

namespace thermotwin::study {

using core::units::deg;
using core::units::minute;
using Eigen::Index;
using Eigen::VectorXd;
using mesh::Axis;
using mesh::AxisKind;
using metrology::LoadMotion;
using solver::Channels;

namespace {

constexpr double turn_deg = 360.0;
constexpr double share_of_rapid = 0.5;  ///< the other half of the time goes into acceleration and braking
constexpr double change_probability = 0.5;
constexpr double near_s = 1e-6;
constexpr double same_surroundings_K = 0.5;

VectorXd between(const TestPhase& phase, double share) {
  VectorXd row = phase.from;
  for (Index i = 0; i < row.size(); ++i)
    if (phase.to[i] != phase.from[i] && std::isfinite(phase.to[i])) row[i] += share * (phase.to[i] - phase.from[i]);
  return row;
}

/// Makes blocks of one machine.
class Maker {
public:
  Maker(const mesh::Machine& machine, const BlockOptions& options)
      : machine_(machine),
        options_(options),
        channels_(machine) {}

  VectorXd standing() const { return channels_.defaults(); }
  void set(VectorXd& row, const std::string& channel, double value) const {
    if (const int index = channels_.index(channel); index >= 0) row[index] = value;
  }
  void cool(VectorXd& row, bool on) const {
    for (const mesh::CoolantSpec& coolant : machine_.coolants)
      set(row, "coolant." + coolant.id + ".on", on ? 1.0 : 0.0);
  }
  void stand(VectorXd& row, const mesh::Pose& pose) const {
    for (Index a = 0; a < pose.size(); ++a) {
      const solver::AxisChannels& of = channels_.of_axis(a);
      row[of.position] = pose[a] / of.unit;
      row[of.feed] = 0.0;
      row[of.low] = row[of.high] = solver::not_given;
    }
  }
  /// Adds a motion that takes a share of the time.
  void move(VectorXd& row, const LoadMotion& load, double share) const {
    if (load.axis < 0) return set(row, "spindle.speed_rpm", load.speed);
    const solver::AxisChannels& of = channels_.of_axis(load.axis);
    const bool endless = machine_.axes[load.axis].endless;
    if (!endless && !(load.high > load.low && load.speed > 0)) {
      row[of.position] = load.low / of.unit;
      return;
    }
    if (!(load.speed * share > 0)) return;
    const double start = row[of.position];
    row[of.low] = endless ? start : load.low / of.unit;
    row[of.high] = endless ? start + turn_deg : load.high / of.unit;
    if (!endless) row[of.position] = 0.5 * (row[of.low] + row[of.high]);
    row[of.feed] = load.speed * share / of.unit * minute;
  }
  /// The largest load of an axis over its travel, or of the spindle (-1).
  LoadMotion largest(int axis) const {
    LoadMotion load{axis, machine_.spindle_max_rpm, 0, 0};
    if (axis < 0) return load;
    const Axis& of = machine_.axes[axis];
    load.speed = of.rapid > 0 ? of.rapid : of.kind == AxisKind::linear ? 1.0 : turn_deg * deg / 10.0;
    if (!of.endless) load.low = of.low, load.high = of.high;
    return load;
  }
  bool has(int axis) const { return axis >= 0 || machine_.spindle_max_rpm > 0; }
  std::string name(int axis) const { return axis < 0 ? "spindle" : machine_.axes[axis].id; }
  std::vector<int> loads() const {
    std::vector<int> all;
    for (int axis = -1; axis < std::ssize(machine_.axes); ++axis)
      if (has(axis)) all.push_back(axis);
    return all;
  }

  TestBlock steady(const std::string& name, const VectorXd& row, double seconds) const {
    return probed({name, {{name, seconds, row, row, false}}});
  }
  TestBlock loaded(int axis, double seconds) const {
    VectorXd row = standing();
    move(row, largest(axis), axis < 0 ? 1.0 : share_of_rapid);
    return steady(name(axis), row, seconds);
  }
  TestBlock all(const std::string& name, VectorXd row) const {
    for (const int axis : loads()) move(row, largest(axis), axis < 0 ? 1.0 : share_of_rapid);
    return steady(name, row, options_.block_s);
  }
  TestBlock random(const std::string& name, const std::vector<int>& axes) const {
    std::vector<metrology::RandomLoads::Limits> limits;
    for (const int axis : axes) {
      const LoadMotion widest = largest(axis);
      limits.push_back({widest, 0.0, widest.speed});
    }
    metrology::RandomLoads cycle(limits, change_probability, false, options_.seed);
    TestBlock block{name, {}};
    const auto intervals = std::max(1L, std::lround(options_.block_s / options_.interval_s));
    const double seconds = options_.block_s / intervals;
    for (long i = 0; i < intervals; ++i) {
      VectorXd row = standing();
      for (const LoadMotion& load : cycle.next()) move(row, load, load.axis < 0 ? 1.0 : share_of_rapid);
      block.phases.push_back({fmt::format("{} {}", name, i + 1), seconds, row, row, false});
    }
    return probed(std::move(block));
  }

  /// The last part of each interval of the probe, and of the block, becomes a standstill at its pose.
  TestBlock probed(TestBlock block) const {
    const double every = options_.probe_every_s, stands = options_.probe_s, length = block.seconds();
    if (!(every > 0) || !(length > 2.0 * stands)) return block;
    TestBlock cut{block.name, {}};
    const double readings = std::max(1.0, std::floor(length / every + 1e-9));
    const bool even = std::abs(readings * every - length) < near_s;
    std::vector<double> ends;
    for (double i = 1.0; i <= readings; ++i) ends.push_back(std::min(i * every, length));
    if (!even && length - ends.back() > 2.0 * stands) ends.push_back(length);
    double before = 0.0;
    for (const double end : ends) {
      copy(block, before, end - stands, cut);
      TestPhase reading = cut.phases.back();
      reading.name = probe_phase;
      reading.seconds = stands;
      reading.probes = true;
      reading.from = reading.to;
      set(reading.from, "spindle.speed_rpm", 0.0);
      set(reading.from, "cutting_fluid.on", 0.0);
      stand(reading.from, options_.probe_pose);
      reading.to = reading.from;
      cut.phases.push_back(std::move(reading));
      before = end;
    }
    copy(block, before, length, cut);
    return cut;
  }

private:
  static void copy(const TestBlock& block, double from, double to, TestBlock& into) {
    double start = 0.0;
    for (const TestPhase& phase : block.phases) {
      const double end = start + phase.seconds, a = std::max(start, from), b = std::min(end, to);
      if (b - a > near_s) {
        TestPhase part = phase;
        part.from = between(phase, (a - start) / phase.seconds);
        part.to = between(phase, (b - start) / phase.seconds);
        part.seconds = b - a;
        into.phases.push_back(std::move(part));
      }
      start = end;
    }
  }

  const mesh::Machine& machine_;
  const BlockOptions& options_;
  Channels channels_;
};

/// One phase as text: all that it can state, so that it stands for itself.
class PhaseText {
public:
  explicit PhaseText(const mesh::Machine& machine) : machine_(machine), channels_(machine) {}

  std::string operator()(const TestPhase& phase) const {
    std::string text = fmt::format("\n[[phase]]\nname = \"{}\"\nduration_s = {:.12g}\n", phase.name, phase.seconds);
    const auto value = [&](const std::string& name) {
      const int index = channels_.index(name);
      return index < 0 ? 0.0 : phase.from[index];
    };
    const auto flag = [&](const char* key, bool on) { text += fmt::format("{} = {}\n", key, on); };
    const bool runs = value("machine.on") != 0.0;
    flag("machine_on", runs);
    text += fmt::format("spindle_rpm = {:.12g}\n", runs ? value("spindle.speed_rpm") : 0.0);
    flag("cutting_fluid", value("cutting_fluid.on") != 0.0);
    bool cooled = false;
    for (const mesh::CoolantSpec& coolant : machine_.coolants)
      cooled = cooled || value("coolant." + coolant.id + ".on") != 0.0;
    if (!machine_.coolants.empty()) flag("coolant", cooled);
    if (const int index = channels_.index("process.power_W"); index >= 0 && std::isfinite(phase.from[index]))
      text += fmt::format("process_W = {:.12g}\n", phase.from[index]);
    text += doors(phase);
    for (const mesh::AmbientSpec& ambient : machine_.ambients) {
      text += ramp(phase, ambient.id + ".T_C", ambient.id + "_C");
      if (ambient.has_gradient) text += ramp(phase, ambient.id + ".gradient_K_m", ambient.id + "_gradient_K_m");
    }
    for (const mesh::VolumeSpec& volume : machine_.volumes) text += ramp(phase, volume.id + ".T_C", volume.id + "_C");
    for (std::size_t a = 0; a < machine_.axes.size(); ++a) text += axis(phase, a);
    return text;
  }

private:
  std::string doors(const TestPhase& phase) const {
    std::vector<std::string> open;
    for (const std::string& door : machine_.doors)
      if (phase.from[channels_.index("door." + door + ".open")] != 0.0) open.push_back("\"" + door + "\"");
    return machine_.doors.empty() ? "" : "doors_open = [" + core::join(open) + "]\n";
  }
  std::string ramp(const TestPhase& phase, const std::string& channel, const std::string& key) const {
    const int index = channels_.index(channel);
    const double from = phase.from[index], to = phase.to[index];
    if (!std::isfinite(from)) return "";
    return from == to ? fmt::format("{} = {:.12g}\n", key, from)
                      : fmt::format("{} = [{:.12g}, {:.12g}]\n", key, from, to);
  }
  std::string axis(const TestPhase& phase, std::size_t a) const {
    const Axis& axis = machine_.axes[a];
    const solver::AxisChannels& of = channels_.of_axis(a);
    const VectorXd& row = phase.from;
    const std::string unit = axis.kind == AxisKind::linear ? "mm" : "deg";
    std::string text = "[[phase.axis]]\nid = \"" + axis.id + "\"\n";
    if (of.clamped >= 0 && row[of.clamped] != 0.0) text += "clamped = true\n";
    if (!(row[of.feed] > 0.0) || !std::isfinite(row[of.low]))
      return text + fmt::format("position_{} = {:.12g}\n", unit, row[of.position]);
    if (axis.endless && row[of.high] - row[of.low] > turn_deg - 1e-6)
      return text + fmt::format("speed_rpm = {:.12g}\n", row[of.feed] / turn_deg);
    return text + fmt::format("low_{0} = {1:.12g}\nhigh_{0} = {2:.12g}\nfeed_{0}_min = {3:.12g}\n", unit, row[of.low],
                              row[of.high], row[of.feed]);
  }

  const mesh::Machine& machine_;
  Channels channels_;
};

}  // namespace

double TestBlock::seconds() const {
  double sum = 0.0;
  for (const TestPhase& phase : phases) sum += phase.seconds;
  return sum;
}

void BlockOptions::validate() const {
  core::require_within("tests: block_s", block_s, {300.0, 1e7});
  core::require_within("tests: interval_s", interval_s, {300.0, 1e7});
  core::require_within("tests: probe_every_s", probe_every_s, {0.0, 1e7});
  core::require_within("tests: probe_s", probe_s, {1.0, 3600.0});
}

std::vector<TestBlock> standard_blocks(const mesh::Machine& machine, const BlockOptions& options) {
  options.validate();
  const Maker make(machine, options);
  const double seconds = options.block_s;
  const VectorXd standing = make.standing();
  std::vector<TestBlock> blocks{make.steady("standstill", standing, seconds)};
  const bool fluid = std::any_of(machine.films.begin(), machine.films.end(),
                                 [](const mesh::FilmSpec& film) { return film.state.starts_with("cutting_fluid"); });
  VectorXd wet = standing;
  make.set(wet, "cutting_fluid.on", 1.0);
  if (fluid) blocks.push_back(make.steady("standstill, cutting fluid", wet, seconds));
  if (!machine.coolants.empty()) {
    VectorXd uncooled = standing;
    make.cool(uncooled, false);
    blocks.push_back(make.steady("standstill, no coolant", uncooled, seconds));
  }
  const std::vector<int> loads = make.loads();
  for (const int axis : loads) {
    blocks.push_back(make.loaded(axis, seconds));
    blocks.push_back(make.random(make.name(axis) + ", random", {axis}));
  }
  if (loads.size() > 1) {
    blocks.push_back(make.all("all", standing));
    blocks.push_back(make.random("all, random", loads));
    if (fluid) blocks.push_back(make.all("all, cutting fluid", wet));
  }
  if (!make.has(-1)) return blocks;
  for (const bool high : {false, true}) {
    VectorXd row = standing;
    mesh::Pose pose = mesh::home_pose(machine);
    for (Index a = 0; a < pose.size(); ++a)
      if (!machine.axes[a].endless) pose[a] = high ? machine.axes[a].high : machine.axes[a].low;
    make.stand(row, pose);
    make.move(row, make.largest(-1), 1.0);
    blocks.push_back(make.steady(high ? "spindle, axes high" : "spindle, axes low", row, seconds));
  }
  return blocks;
}

std::vector<TestBlock> iso_230_3_blocks(const mesh::Machine& machine, const BlockOptions& options, double seconds) {
  options.validate();
  const Maker make(machine, options);
  const std::vector<int> loads = make.loads();
  const double tests = std::ssize(loads), each = seconds / (tests + 1.0);
  // Whole intervals of the sensors' rows, so that all readings fall on one.
  const double unit = 600.0, load = std::max(unit, std::floor(2.0 / 3.0 * each / unit) * unit),
               rest = std::max(unit, std::floor(each / unit) * unit - load);
  std::vector<TestBlock> blocks;
  const double first = std::max(unit, seconds - tests * (load + rest));
  blocks.push_back(make.steady("standstill", make.standing(), first));
  for (const int axis : loads) {
    blocks.push_back(make.loaded(axis, load));
    blocks.push_back(make.steady("standstill", make.standing(), rest));
  }
  return blocks;
}

bool moves_surroundings(const mesh::Machine& machine, const solver::LoadProgram& load) {
  const Channels channels(machine);
  double before = 0.0;
  for (const double stop : load.stops()) {
    const double middle = 0.5 * (before + stop);
    for (const double at : {before, stop}) {
      const VectorXd row = load.row_at(at, middle);
      for (const mesh::AmbientSpec& ambient : machine.ambients) {
        const int index = channels.index(ambient.id + ".T_C");
        const double usual = channels.defaults()[index];
        if (std::isfinite(row[index]) &&
            std::abs(row[index] - (std::isfinite(usual) ? usual : load.initial_C())) > same_surroundings_K)
          return true;
      }
    }
    before = stop;
  }
  return false;
}

TestBlock program_block(const mesh::Machine& machine, const solver::LoadProgram& load, const BlockOptions& options,
                        double seconds) {
  options.validate();
  TestBlock block{load.name(), {}};
  double before = 0.0;
  for (const double stop : load.stops()) {
    if (!load.is_corner(stop) && stop < load.duration() - near_s) continue;
    const double end = std::min(stop, seconds), middle = 0.5 * (before + end);
    if (end - before > near_s) {
      block.phases.push_back(
          {load.phase_at(middle), end - before, load.row_at(before, middle), load.row_at(end, middle), false});
    }
    before = stop;
    if (before >= seconds) break;
  }
  return Maker(machine, options).probed(std::move(block));
}

std::string test_text(const mesh::Machine& machine, const std::vector<const TestBlock*>& blocks,
                      const std::string& title, double initial_C, double output_s) {
  std::string text = fmt::format(
      "# SPDX-License-Identifier: GPL-3.0-or-later\nschema = 1\ntitle = \"{}\"\ninitial_C = {:.12g}\ntime_step_s = "
      "60\noutput_s = {:.12g}\n",
      title, initial_C, output_s);
  const PhaseText of(machine);
  for (const TestBlock* block : blocks) {
    text += "\n# " + block->name + "\n";
    for (const TestPhase& phase : block->phases) text += of(phase);
  }
  return text;
}

}  // namespace thermotwin::study
