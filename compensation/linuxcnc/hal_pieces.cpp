// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/linuxcnc/hal_pieces.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/file.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

namespace fs = std::filesystem;

constexpr const char* licence = "# SPDX-License-Identifier: GPL-3.0-or-later\n";
constexpr const char *pins = "thermotwin", *guard = "thermotwin-guard";
constexpr double counts_per_um = 1000.0;  // a count is a nanometre
constexpr double offset_share = 0.02;     // of an axis' velocity and acceleration, for its offsets
constexpr std::size_t longest_hal_name = 47, most_axes = 9;

const HalAxis* axis_of(const HalConfig& config, const std::string& name) {
  return name.size() == 1 ? config.axis(name[0]) : nullptr;
}

/// Nets with signals that are there already, or new ones.
class Nets {
public:
  explicit Nets(const HalConfig& config) : config_(config) {}

  /// Joins `reader` to what the pin `source` gives.
  void join(const std::string& source, const std::string& reader) {
    const auto there = config_.signal_of_pin.find(source);
    const auto own = own_.find(source);
    if (there != config_.signal_of_pin.end())
      text_ += fmt::format("net {} => {}\n", there->second, reader);
    else if (own != own_.end())
      text_ += fmt::format("net {} => {}\n", own->second, reader);
    else
      text_ += fmt::format("net {} {} => {}\n", own_.emplace(source, own_name(source)).first->second, source, reader);
  }
  void comment(const std::string& line) { text_ += "# " + line + "\n"; }
  void line(const std::string& line) { text_ += line + "\n"; }
  const std::string& text() const { return text_; }

private:
  static std::string own_name(std::string source) {
    std::replace(source.begin(), source.end(), '.', '-');
    return "thermotwin-" + source;
  }
  const HalConfig& config_;
  std::map<std::string, std::string> own_;
  std::string text_;
};

/// The pin of LinuxCNC that gives a channel; empty: none does by itself.
std::string source_of(const HalConfig& config, const ControlData& model, std::int32_t channel) {
  const std::string& name = model.channel_names[channel];
  if (name == "machine.on") return "motion.motion-enabled";
  if (name == "spindle.speed_rpm") return "spindle.0.speed-out-abs";
  if (name == "cutting_fluid.on") return "iocontrol.0.coolant-flood";
  for (std::size_t a = 0; a < model.axis_names.size(); ++a) {
    const HalAxis* axis = axis_of(config, model.axis_names[a]);
    if (axis != nullptr && model.axis_position[a] == channel) return fmt::format("joint.{}.pos-cmd", axis->joint);
  }
  return {};
}

bool follows_from_positions(const ControlData& model, std::int32_t channel) {
  const auto holds = [&](const std::vector<std::int32_t>& channels) {
    return std::find(channels.begin(), channels.end(), channel) != channels.end();
  };
  return holds(model.axis_feed) || holds(model.axis_low) || holds(model.axis_high);
}

const std::string& linear_axis(const ControlData& model, std::size_t i) {
  return model.axis_names[model.linear_axis[i]];
}

void check(const HalConfig& config, const ControlData& model) {
  if (config.kinematics != "trivkins")
    throw core::InputError(config.ini.string() + " [KINS]KINEMATICS", config.kinematics,
                           "trivkins: external offsets act before the kinematics, and the model's are those of axes");
  if (model.axis_names.size() > most_axes)
    throw core::InputError("axes of " + model.name, fmt::format("{}", model.axis_names.size()),
                           fmt::format("at most {}", most_axes));
  for (const char* name : {pins, guard}) {
    if (std::find(config.components.begin(), config.components.end(), name) != config.components.end())
      throw core::InputError(config.ini.string(), std::string("a component is named ") + name,
                             "a configuration without it; is it the one that export has written?");
  }
  for (std::size_t i = 0; i < model.linear_axis.size(); ++i) {
    const std::string& name = linear_axis(model, i);
    if (axis_of(config, name) == nullptr)
      throw core::InputError(config.ini.string() + " axes", "no axis " + name,
                             "a configuration with the linear axes of the model's machine");
    for (const char* end : {"counts", "enable", "scale", "clear"}) {
      const std::string pin = fmt::format("axis.{}.eoffset-{}", core::lower(name), end);
      const auto place = config.place_of_pin.find(pin);
      if (place != config.place_of_pin.end())
        throw core::InputError(place->second, pin + " is linked to " + config.signal_of_pin.at(pin),
                               "an external offset that nothing else uses");
    }
  }
  for (const std::string& name : model.channel_names) {
    if (std::string(pins).size() + 1 + name.size() > longest_hal_name)
      throw core::InputError("channel " + name, fmt::format("{} characters", name.size()),
                             fmt::format("at most {} for a pin", longest_hal_name - std::string(pins).size() - 1));
  }
}

void add_inputs(const HalConfig& config, const ControlData& model, Nets& nets, HalPieces& pieces) {
  for (std::int32_t k = 0; k < std::ssize(model.channel_names); ++k) {
    if (follows_from_positions(model, k)) continue;
    const std::string& name = model.channel_names[k];
    const std::string source = source_of(config, model, k), pin = fmt::format("{}.{}", pins, name);
    if (!source.empty()) {
      nets.join(source, pin);
      pieces.linked.push_back(name);
    } else {
      nets.comment(fmt::format("net YOUR-SIGNAL => {}", pin));
      pieces.unlinked.push_back(name);
    }
  }
  for (const std::string& sensor : model.sensor_names) {
    nets.comment(fmt::format("net YOUR-SIGNAL => {}.{}_C", pins, sensor));
    pieces.unlinked.push_back(sensor + "_C");
  }
}

/// Limits, and what the motion of an axis allows offsets to change by: numbers of the model's own guard.
void add_limits(const HalConfig& config, const ControlData& model, Nets& nets) {
  nets.line(fmt::format("setp {}.limit-um {:g}", guard, model.largest_um));
  nets.line(fmt::format("setp {}.rate-um-s {:g}", guard, model.rate_um_s));
  nets.line(fmt::format("setp {}.return-um-s {:g}", guard, model.rate_um_s));
  nets.line(fmt::format("setp {}.hold-s {:g}", guard, model.hold_s));
  nets.line(fmt::format("setp {}.counts-per-um {:g}", guard, counts_per_um));
  nets.line(fmt::format("setp {}.um-per-unit {:g}", guard, 1e3 * config.mm_per_unit));
  for (std::size_t a = 0; a < model.axis_names.size(); ++a) {
    const HalAxis* axis = axis_of(config, model.axis_names[a]);
    if (axis == nullptr) continue;
    const double unit = model.axis_rotary[a] != 0 ? core::units::deg : core::units::mm * config.mm_per_unit;
    const double rapid = model.axis_rapid[a] / unit;
    nets.join(fmt::format("joint.{}.pos-cmd", axis->joint), fmt::format("{}.position-{}", guard, a));
    nets.line(fmt::format("setp {}.slope-um-{} {:g}", guard, a, model.axis_slope_um[a] * unit));
    nets.line(fmt::format("setp {}.fastest-{} {:g}", guard, a, std::max(rapid, axis->fastest)));
  }
}

void add_guard(const HalConfig& config, const ControlData& model, Nets& nets) {
  nets.join("motion.motion-enabled", fmt::format("{}.machine-is-on", guard));
  nets.line(fmt::format("net thermotwin-heartbeat {0}.heartbeat => {1}.heartbeat", pins, guard));
  add_limits(config, model, nets);
  for (const std::int32_t a : model.linear_axis) {
    const std::string& name = model.axis_names[a];
    const std::string axis = core::lower(name);
    nets.line(
        fmt::format("net thermotwin-wanted-{2} {0}.offset-{3}-um => {1}.wanted-um-{4}", pins, guard, axis, name, a));
    nets.line(fmt::format("net thermotwin-counts-{1} {0}.counts-{2} => axis.{1}.eoffset-counts", guard, axis, a));
    nets.join(fmt::format("axis.{}.eoffset", axis), fmt::format("{}.eoffset-{}", guard, a));
    nets.line(fmt::format("setp axis.{}.eoffset-scale {:g}", axis, 1e-3 / counts_per_um / config.mm_per_unit));
    nets.line(fmt::format("setp axis.{}.eoffset-enable 1", axis));
  }
}

std::string ini_pieces(const HalConfig& config, const ControlData& model, const fs::path& folder) {
  std::string text = fmt::format("{}# Lines for {}.\n", licence, comment_text(config.ini.filename().string()));
  text += fmt::format("\n[THERMOTWIN]\nFOLDER = {}\n", folder.string());
  text +=
      fmt::format("\n# in [HAL], after the other HALFILE lines:\nHALFILE = {}\n", (folder / "thermotwin.hal").string());
  for (std::size_t i = 0; i < model.linear_axis.size(); ++i) {
    const HalAxis* axis = axis_of(config, linear_axis(model, i));
    if (axis != nullptr && !axis->has_offsets)
      text += fmt::format(
          "\n# in [AXIS_{}]: the share of velocity and acceleration that offsets may use\n"
          "OFFSET_AV_RATIO = {:g}\n",
          axis->letter, offset_share);
  }
  return text;
}

}  // namespace

HalPieces hal_pieces(const HalConfig& config, const ControlData& model, const fs::path& folder) {
  check(config, model);
  if (folder.string().find_first_of("\r\n") != std::string::npos)
    throw core::InputError(comment_text(folder.string()), "a line break in the name of the folder",
                           "one line: the folder stands in the INI file");
  HalPieces pieces;
  Nets nets(config);
  nets.line(fmt::format("loadrt thermotwin_guard names={} personality={}", guard, model.axis_names.size()));
  nets.line(fmt::format("addf {} {}", guard, config.thread));
  nets.line(
      fmt::format("loadusr -Wn {0} [THERMOTWIN](FOLDER)/thermotwin_pins --model "
                  "[THERMOTWIN](FOLDER)/thermotwin_model --state [THERMOTWIN](FOLDER)/thermotwin.state "
                  "--mm-per-unit {1:g}",
                  pins, config.mm_per_unit));
  nets.line("");
  nets.comment("Inputs of the model. A pin that nothing is linked to is not given.");
  add_inputs(config, model, nets, pieces);
  nets.line("");
  nets.comment("Offsets by way of the guard.");
  add_guard(config, model, nets);
  pieces.hal = fmt::format("{}# Thermal offsets of {} for {}.\n\n{}", licence, comment_text(model.name),
                           comment_text(config.ini.filename().string()), nets.text());
  pieces.ini = ini_pieces(config, model, folder);
  return pieces;
}

std::vector<fs::path> write_linuxcnc(const fs::path& folder, const ControlData& data, const tt_model& model,
                                     const HalPieces& pieces) {
  std::vector<fs::path> names;
  for (const std::string& name : write_control_source(folder / "core", data, model))
    names.push_back(fs::path("core") / name);
  for (const EmbeddedFile& file : linuxcnc_files()) {
    core::write_file(folder / file.name, file.text);
    names.emplace_back(file.name);
  }
  fs::permissions(folder / "build.sh", fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                  fs::perm_options::add);
  core::write_file(folder / "thermotwin.ini", pieces.ini);
  core::write_file(folder / "thermotwin.hal", pieces.hal);
  names.insert(names.end(), {"thermotwin.ini", "thermotwin.hal"});
  return names;
}

}  // namespace thermotwin::compensation
