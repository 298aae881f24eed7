// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A command that a page offers as the next step, with the options that were given.

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/quoted.h"

namespace thermotwin::tools {

class ShellCommand {
public:
  /// @param begin  words for the shell, as they are
  explicit ShellCommand(std::string begin) : words_(std::move(begin)) {}

  /// An empty value is none that was given.
  ShellCommand& text(std::string_view option, const std::string& value) {
    if (!value.empty()) words_ += fmt::format(" {} {}", option, core::shell_word(value));
    return *this;
  }
  ShellCommand& texts(std::string_view option, const std::vector<std::string>& values) {
    for (const std::string& value : values) text(option, value);
    return *this;
  }
  /// @param usual  the default, which is not written
  template <class Number>
  ShellCommand& number(std::string_view option, Number value, Number usual) {
    if (value != usual) words_ += fmt::format(" {} {}", option, value);
    return *this;
  }
  ShellCommand& flag(std::string_view option, bool given) {
    if (given) words_ += fmt::format(" {}", option);
    return *this;
  }

  const std::string& words() const { return words_; }

private:
  std::string words_;
};

}  // namespace thermotwin::tools
