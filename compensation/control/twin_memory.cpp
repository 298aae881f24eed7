// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/twin_memory.h"

#include <fmt/format.h>

#include <algorithm>

#include "compensation/control/state_error.h"
#include "compensation/control/twin_jobs.h"
#include "core/error.h"
#include "core/file.h"

namespace thermotwin::compensation {

TwinMemory::TwinMemory(const tt_model& model)
    : model_(model),
      state_((tt_twin_state_bytes(&model) + 7) / 8),
      work_((tt_twin_work_bytes(&model) + 7) / 8) {
  begin_anew();
}

void TwinMemory::begin_anew() {
  std::fill(state_.begin(), state_.end(), 0.0);
  std::fill(work_.begin(), work_.end(), 0.0);
  tt_twin_begin(&twin_, &model_, state_.data(), work_.data());
}

std::string TwinMemory::saved() const {
  std::string bytes(tt_twin_saved_bytes(&model_), '\0');
  tt_twin_save(&twin_, bytes.data());
  return bytes;
}

void TwinMemory::load(std::string_view saved, const std::string& name) {
  switch (tt_twin_load(&twin_, saved.data(), saved.size())) {
    case TT_LOADED: return;
    case TT_NO_STATE:
      throw StateError(StateFault::damaged, name, "no saved state, or one that is cut off", "a state that was saved");
    case TT_OTHER_VERSION:
      throw StateError(StateFault::other_version, name, "a state that another version of thermotwin saved",
                       "a state of this version; move the file away to start cold");
    case TT_OTHER_MODEL:
      throw StateError(StateFault::other_model, name,
                       "a state of another model, or of the same model with other options",
                       "a state of this model with these options; move the file away to start cold");
    default:
      throw StateError(StateFault::damaged, name, "a state that is cut off or damaged",
                       "a whole state; move the file away to start cold");
  }
}

void TwinMemory::save_file(const std::filesystem::path& path) const { core::write_file(path, saved()); }

void TwinMemory::load_file(const std::filesystem::path& path) { load(core::read_file(path), path.string()); }

void TwinMemory::take_over(const TwinMemory& other) {
  if (other.state_.size() != state_.size())
    throw core::InputError("state to go on from", fmt::format("{} numbers", other.state_.size()),
                           fmt::format("{}, those of the same model", state_.size()));
  std::copy(other.state_.begin(), other.state_.end(), state_.begin());
  tt_redo_job(&twin_);
}

}  // namespace thermotwin::compensation
