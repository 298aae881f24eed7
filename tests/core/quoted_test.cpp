// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/quoted.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace {

using namespace thermotwin;

/// What a shell makes of the word.
std::string said_by_shell(const std::string& word) {
  FILE* pipe = popen(("printf %s " + word).c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  pclose(pipe);
  return text;
}

TEST(Quoted, AShellReadsTheWordAsItIs) {
  for (const std::string text : {"plain-1.2/+_x", "two words", "it's", "$HOME `id` \"x\" \\ * ;", "a\nb", "%"})
    EXPECT_EQ(said_by_shell(core::shell_word(text)), text);
  EXPECT_EQ(core::shell_word("out/model.rom.h5"), "out/model.rom.h5") << "plain text stays readable";
  EXPECT_EQ(core::shell_word(""), "''");
}

TEST(Quoted, ACellKeepsItsCommas) { EXPECT_EQ(core::csv_cell("a, \"b\""), "\"a, 'b'\""); }

}  // namespace
