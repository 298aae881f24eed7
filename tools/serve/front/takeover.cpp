// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/takeover.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sys/stat.h>
#include <system_error>
#include <utility>

#include "core/progress.h"
#include "core/units.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kept_every_s = 60.0, kept_s = 86400.0;
constexpr double enough_s = kept_s - 600.0;  ///< rows of so long tell a new model what it has to know
constexpr double pause_s = 300.0;            ///< a state holds so long; then the machine was off
constexpr std::size_t most_lines = 3000;     ///< of the file: two days, a row a minute
constexpr double look_every_s = 1.0;

}  // namespace

std::vector<std::string> model_command(const FrontOptions& options, const fs::path& state) {
  std::vector<std::string> command = options.model_command;
  command.insert(command.end(), {"--state", state.string()});
  return command;
}

Takeover::Takeover(const FrontOptions& options)
    : options_(options),
      file_(options.state.string() + ".rows"),
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

void Takeover::set_header(const std::string& header) {
  if (header == header_) return;
  const bool is_first = std::exchange(header_, header).empty();
  day_.clear();
  begins_cold_ = false;
  RowsFile::Content before = is_first ? file_.read() : RowsFile::Content{};
  if (before.header != header) before = {header, {}};
  for (KeptRow& kept : before.rows) {
    begins_cold_ = begins_cold_ || (day_.empty() && kept.kind == KeptRow::begin);
    ServedRow row;
    row.time = kept.time;
    row.text = std::move(kept.text);
    row.after_pause = kept.kind == KeptRow::after_pause;
    day_.push_back(std::move(row));
  }
  write_file();
}

void Takeover::write_file() {
  RowsFile::Content content{header_, {}};
  for (const ServedRow& row : day_) content.rows.push_back(kept_of(row));
  file_.write(content);
}

KeptRow Takeover::kept_of(const ServedRow& row) const {
  const bool begins = begins_cold_ && row.time == day_.front().time;
  return {begins ? KeptRow::begin : row.after_pause ? KeptRow::after_pause : KeptRow::plain, row.time, row.text};
}

/// Rows before a clock that began anew, or of a model that has begun cold since, do not belong to this one.
void Takeover::keep_first(ServedRow& row, bool is_cold) {
  const auto is_old = [&](const ServedRow& kept) { return kept.time >= row.time || kept.time < row.time - kept_s; };
  const bool had_any = !day_.empty(), was_long_ago = had_any && day_.back().time < row.time - kept_s;
  const std::size_t before = day_.size();
  std::erase_if(day_, is_old);
  if (day_.size() != before) begins_cold_ = false;
  row.after_pause = !day_.empty() && row.time - day_.back().time > pause_s;
  if (day_.empty()) begins_cold_ = is_cold || was_long_ago;
}

void Takeover::keep(ServedRow row, bool is_cold) {
  if (!std::isfinite(row.time)) return;
  const bool is_first = std::exchange(is_first_, false);
  if (is_first) keep_first(row, is_cold);
  if (day_.empty() && !is_first) begins_cold_ = false;
  if (!day_.empty() && row.time - day_.back().time < kept_every_s) return;
  day_.push_back(std::move(row));
  while (day_.back().time - day_.front().time > kept_s) day_.pop_front();
  if (is_first || file_.lines() > most_lines)
    write_file();
  else
    file_.append(kept_of(day_.back()));
}

double Takeover::kept_h() const {
  return day_.empty() ? 0.0 : (day_.back().time - day_.front().time) / core::units::hour;
}

bool Takeover::has_all_rows() const { return begins_cold_ || kept_h() * core::units::hour >= enough_s; }

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
  waits_ = false;
  const std::string hash = hash_of(options_.model);
  if (hash == hash_) return;  // the same model, written again
  if (has_all_rows()) return begin(header);
  waits_ = says_waiting_ = true;
  core::warn(
      fmt::format("serve: {} has changed, but the rows of the last {:.3g} h alone are known, of 24 h; the model in use "
                  "goes on until they are there",
                  options_.model.string(), kept_h()));
}

void Takeover::begin(const std::string& header) {
  core::log_line(fmt::format("serve: {} has changed; the new model gets the rows of the last {:.3g} h",
                             options_.model.string(), kept_h()));
  // The process in use may still save to the file of its own takeover.
  const std::string state = options_.state.string();
  next_state_ = state + (taken_state_ == state + ".next" ? ".next2" : ".next");
  std::error_code none;
  fs::remove(next_state_, none);
  next_ = std::make_unique<ModelProcess>(model_command(options_, next_state_));
  next_->set_header(header);
  said_ = nullptr;
  fed_until_ = paused_at_ = -std::numeric_limits<double>::infinity();
  pauses_ = 0;
}

void Takeover::give_up(const std::string& why) {
  core::warn(fmt::format("serve: {} is not taken over: {}", options_.model.string(), why));
  next_.reset();
}

bool Takeover::tend(const std::string& header, const std::vector<std::string>& axes, double now) {
  look(header, now);
  if (waits_ && has_all_rows()) {
    waits_ = false;
    begin(header);
  }
  if (!next_) return false;
  next_->set_header(header);
  next_->tend(now);
  while (next_->answer(now)) {}
  if (const auto refusal = next_->take_refusal()) {
    give_up(refusal->what);
    return false;
  }
  if (next_->restarts() > pauses_) {
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
  return feed() && next_->is_idle();
}

/// A pause of `serve` is one of the second process, too: it computes a machine that was off.
/// @return whether all rows have been given
bool Takeover::feed() {
  for (const ServedRow& row : day_) {
    if (row.time <= fed_until_) continue;
    if (row.after_pause && std::isfinite(fed_until_) && row.time > paused_at_) {
      if (!next_->is_idle()) return false;
      next_->end();
      paused_at_ = row.time;
      ++pauses_;
      said_ = nullptr;
      return false;
    }
    ServedRow again = row;
    again.again = true;
    fed_until_ = row.time;
    next_->add(std::move(again));
  }
  return true;
}

std::unique_ptr<ModelProcess> Takeover::take() {
  hash_ = hash_of(options_.model);
  std::error_code none;
  fs::rename(options_.state, options_.state.string() + ".before", none);
  taken_state_ = next_state_;
  move_state();
  core::log_line(fmt::format("serve: {} is taken over", options_.model.string()));
  next_->set_command(model_command(options_, options_.state));
  return std::move(next_);
}

void Takeover::move_state() const {
  if (taken_state_.empty()) return;
  std::error_code none;
  fs::rename(taken_state_, options_.state, none);
}

}  // namespace thermotwin::tools
