// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/last_offsets.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <system_error>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "tools/serve/front/boot_clock.h"

namespace thermotwin::tools {
namespace {

constexpr double write_every_s = 1.0, write_anyway_s = 30.0;
constexpr double small_um = 0.1;  ///< a change that needs no write of its own
constexpr double never = std::numeric_limits<double>::infinity();

double unix_s() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

/// Tells one start of the computer from another.
std::string boot_name() {
  std::ifstream in("/proc/sys/kernel/random/boot_id");
  std::string name;
  in >> name;
  return name;
}

/// @return the object in the first line; null where the second one is not its check sum
nlohmann::json checked(const std::string& text) {
  const std::size_t end = text.find('\n');
  if (end == std::string::npos || text.substr(end + 1) != core::content_hash(text.substr(0, end)) + "\n") return {};
  return nlohmann::json::parse(text.substr(0, end), nullptr, false);
}

/// By the clock of the computer since its start, else by its date; one that has gone back tells no age.
double age_of(const nlohmann::json& json) {
  const std::string boot = json.at("boot");
  if (!boot.empty() && boot == boot_name()) return boot_s() - json.at("boot_s").get<double>();
  const double age = unix_s() - json.at("unix_s").get<double>();
  return age < 0.0 ? never : age;
}

}  // namespace

LastOffsets::LastOffsets(std::filesystem::path file) : file_(std::move(file)), written_at_(-never) {
  std::error_code none;
  if (!std::filesystem::exists(file_, none)) return;
  try {
    const nlohmann::json json = checked(core::read_file(file_));
    const auto values = json.at("offset_um").get<std::vector<double>>();
    found_ =
        Kept{json.at("axes"), Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)), json.at("time_s")};
    age_s_ = age_of(json);
  } catch (const std::exception&) {
    found_.reset();
    core::warn(fmt::format("serve: {} is damaged; offsets do not continue from the last ones", file_.string()));
  }
}

LastOffsets::~LastOffsets() {
  if (writing_.valid()) writing_.wait();
}

std::optional<Eigen::VectorXd> LastOffsets::before(const std::vector<std::string>& axes, double time,
                                                   bool is_record) const {
  if (!found_ || found_->axes != axes || std::ssize(axes) != found_->offset_um.size()) return std::nullopt;
  if (!found_->offset_um.allFinite()) return std::nullopt;
  const double age_s = is_record ? std::max(age_s_, std::abs(time - found_->time)) : age_s_;
  if (age_s > valid_s) return std::nullopt;
  return found_->offset_um;
}

void LastOffsets::keep(const std::vector<std::string>& axes, const Eigen::VectorXd& offset_um, double time,
                       double now) {
  if (offset_um.size() == 0 || !offset_um.allFinite()) return;
  kept_ = {axes, offset_um, time};
  is_open_ = true;
  const bool is_same =
      written_um_.size() == offset_um.size() && (written_um_ - offset_um).cwiseAbs().maxCoeff() < small_um;
  if (now - written_at_ < (is_same ? write_anyway_s : write_every_s)) return;
  if (writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  write();
  written_at_ = now;
}

void LastOffsets::take_in() {
  if (!writing_.valid()) return;
  const std::string error = writing_.get();
  if (!error.empty() && !warned_) core::warn("serve: the last offsets cannot be saved: " + error);
  warned_ = !error.empty();
}

void LastOffsets::write() {
  take_in();
  const nlohmann::json json = {
      {"axes", kept_.axes},   {"offset_um", std::vector<double>(kept_.offset_um.begin(), kept_.offset_um.end())},
      {"time_s", kept_.time}, {"unix_s", unix_s()},
      {"boot", boot_name()},  {"boot_s", boot_s()}};
  const std::string line = json.dump();
  writing_ =
      std::async(std::launch::async, core::write_file_or_say, file_, line + "\n" + core::content_hash(line) + "\n");
  written_um_ = kept_.offset_um;
  is_open_ = false;
}

void LastOffsets::finish() {
  if (is_open_) write();
  take_in();
}

}  // namespace thermotwin::tools
