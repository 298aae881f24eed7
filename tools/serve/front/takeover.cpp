// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/takeover.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <sys/stat.h>
#include <system_error>
#include <utility>

#include "core/progress.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kept_every_s = 60.0, kept_s = 86400.0;
constexpr double look_every_s = 1.0;

}  // namespace

std::vector<std::string> model_command(const FrontOptions& options, const fs::path& state) {
  std::vector<std::string> command = options.model_command;
  command.insert(command.end(), {"--state", state.string()});
  return command;
}

Takeover::Takeover(const FrontOptions& options)
    : options_(options),
      next_state_(options.state.string() + ".next"),
      used_(stamp_of(options.model)),
      seen_(used_),
      hash_(hash_of(options.model)) {}

Takeover::Stamp Takeover::stamp_of(const fs::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return {};
  return {found.st_mtim.tv_sec * 1000000000LL + found.st_mtim.tv_nsec, found.st_size, found.st_ino};
}

std::string Takeover::hash_of(const fs::path& file) {
  constexpr std::streamoff digits = 16;
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = in.tellg();
  if (size < digits + 1) return "";
  in.seekg(size - digits - 1);
  std::string hash(digits, '\0');
  in.read(hash.data(), digits);
  return hash;
}

void Takeover::keep(const ServedRow& row) {
  if (!(row.time > (day_.empty() ? -std::numeric_limits<double>::infinity() : day_.back().time))) return;
  if (!day_.empty() && row.time - day_.back().time < kept_every_s) return;
  day_.push_back(row);
  while (day_.back().time - day_.front().time > kept_s) day_.pop_front();
}

/// A file that is being written changes from look to look.
void Takeover::look(const std::string& header, double now) {
  if (now - looked_at_ < look_every_s) return;
  looked_at_ = now;
  const Stamp stamp = stamp_of(options_.model);
  const bool settled = stamp == seen_;
  seen_ = stamp;
  if (!settled || stamp == used_ || stamp.bytes < 0) return;
  used_ = stamp;
  next_.reset();
  const std::string hash = hash_of(options_.model);
  if (hash == hash_) return;  // the same model, written again
  begin(header);
}

void Takeover::begin(const std::string& header) {
  core::log_line(fmt::format("serve: {} has changed; the new model gets the rows of the last {:.3g} h",
                             options_.model.string(),
                             day_.empty() ? 0.0 : (day_.back().time - day_.front().time) / 3600.0));
  std::error_code none;
  fs::remove(next_state_, none);
  next_ = std::make_unique<ModelProcess>(model_command(options_, next_state_));
  next_->set_header(header);
  said_ = nullptr;
  fed_until_ = -std::numeric_limits<double>::infinity();
}

void Takeover::give_up(const std::string& why) {
  core::warn(fmt::format("serve: {} is not taken over: {}", options_.model.string(), why));
  next_.reset();
}

bool Takeover::tend(const std::string& header, const std::vector<std::string>& axes, double now) {
  look(header, now);
  if (!next_) return false;
  next_->set_header(header);
  next_->tend(now);
  while (next_->answer(now)) {}
  if (const auto refusal = next_->take_refusal()) {
    give_up(refusal->what);
    return false;
  }
  if (next_->restarts() > 0) {
    give_up("its process has ended");
    return false;
  }
  if (auto said = next_->take_announcement()) {
    if (!said->contains("axes") || (*said)["axes"].get<std::vector<std::string>>() != axes) {
      give_up("its offsets are those of other axes");
      return false;
    }
    said_ = std::move(*said);
  }
  if (said_.is_null()) return false;
  for (const ServedRow& row : day_) {
    if (row.time <= fed_until_) continue;
    ServedRow again = row;
    again.again = true;
    fed_until_ = row.time;
    next_->add(std::move(again));
  }
  return next_->is_idle();
}

std::unique_ptr<ModelProcess> Takeover::take() {
  hash_ = hash_of(options_.model);
  std::error_code none;
  fs::rename(options_.state, options_.state.string() + ".before", none);
  move_state();
  core::log_line(fmt::format("serve: {} is taken over", options_.model.string()));
  next_->set_command(model_command(options_, options_.state));
  return std::move(next_);
}

void Takeover::move_state() const {
  std::error_code none;
  fs::rename(next_state_, options_.state, none);
}

}  // namespace thermotwin::tools
