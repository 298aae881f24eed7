// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A folder of a test's own, and small helpers about messages.

#include <gtest/gtest.h>

#include <string>

#include "core/error.h"
#include "core/file.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::compensation::test {

class Scratch : public core::TemporaryFolder {
public:
  void write(const std::string& name, const std::string& text) const { core::write_file(path() / name, text); }
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
