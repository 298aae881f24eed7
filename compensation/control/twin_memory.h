// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Owns the memory of the online core (twin.h) and saves its state as bytes or as a file.
//
// A loaded state continues bit for bit from where it was saved. It belongs to one model: its head holds the hash of all
// data of the core. Options that change these data (step_s, start_C, limits) therefore make another model.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "compensation/control/twin.h"

namespace thermotwin::compensation {

class TwinMemory {
public:
  /// Begins cold. @param model  must outlive it
  explicit TwinMemory(const tt_model& model);
  TwinMemory(const TwinMemory&) = delete;
  TwinMemory& operator=(const TwinMemory&) = delete;

  tt_twin* operator->() { return &twin_; }
  const tt_twin* operator->() const { return &twin_; }
  tt_twin* get() { return &twin_; }
  const tt_twin* get() const { return &twin_; }
  void begin_anew();  ///< cold, as after the constructor

  std::string saved() const;
  /// @param name  of the state in messages
  /// @throws StateError for a state that is cut off or damaged, of another version or another model; nothing changes
  void load(std::string_view saved, const std::string& name);
  /// Writes the state whole or not at all. @throws InputError (disk full, no permission)
  void save_file(const std::filesystem::path& path) const;
  /// @throws InputError as load, or if the file cannot be read
  void load_file(const std::filesystem::path& path);
  /// Continues from the state of a twin of the same model, whose step, limits or start temperature may differ.
  /// @throws InputError if the states differ in size (the only check)
  void take_over(const TwinMemory& other);

private:
  const tt_model& model_;
  std::vector<double> state_, work_;
  tt_twin twin_{};
};

}  // namespace thermotwin::compensation
