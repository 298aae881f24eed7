// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A folder of a test's own, and small helpers about messages.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "core/error.h"
#include "core/file.h"

namespace thermotwin::compensation::test {

class Scratch {
public:
  Scratch() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("thermotwin_compensation_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const std::filesystem::path& path() const { return path_; }
  void write(const std::string& name, const std::string& text) const { core::write_file(path_ / name, text); }

private:
  std::filesystem::path path_;
};

/// Runs the function and checks that it throws an InputError whose message holds all the words.
template <class Function>
void expect_input_error(const Function& function, std::initializer_list<const char*> words) {
  try {
    function();
  } catch (const core::InputError& error) {
    for (const char* word : words) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << "no '" << word << "' in: " << error.what();
    }
    return;
  }
  ADD_FAILURE() << "no InputError; expected one about " << (words.size() > 0 ? *words.begin() : "the input");
}

}  // namespace thermotwin::compensation::test
