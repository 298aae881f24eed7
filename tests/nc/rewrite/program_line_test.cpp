// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/program_line.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <tuple>

#include "core/error.h"
#include "core/file.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::nc {
namespace {

ProgramLine parsed(const std::string& text) { return ProgramLine::parse(text, "\n"); }

TEST(ProgramLine, FindsWordsAndLeavesTheRest) {
  ProgramLine line = parsed("N10 G1 x-1.5 (to X5) Y [#2 + 1] F200 ; Z9");
  ASSERT_EQ(line.words.size(), 5U);
  EXPECT_EQ(line.find('X')->value, -1.5);
  EXPECT_TRUE(line.find('Y')->expression);
  EXPECT_EQ(line.find('Z'), nullptr);
  line.set('X', "-1.4998", "XYZ");
  line.set('Z', "0.0002", "XYZ");
  EXPECT_EQ(line.text, "N10 G1 x-1.4998 (to X5) Y [#2 + 1] Z0.0002 F200 ; Z9");
}

TEST(ProgramLine, KnowsControlFlowParametersAndOddSpelling) {
  EXPECT_TRUE(parsed("o100 while [#1 lt 5]").control);
  for (const char* name : {"O1234", "o 12 (part)", "N5 O7 ; part"}) {
    EXPECT_TRUE(parsed(name).label) << name;
    EXPECT_FALSE(parsed(name).control) << name;
  }
  for (const char* word : {"O1 sub", "o<part> call", "o#1 call", "o2endif"}) EXPECT_FALSE(parsed(word).label) << word;
  EXPECT_TRUE(parsed("o2endif").control);
  EXPECT_TRUE(parsed("#1 = 5").assigns);
  EXPECT_FALSE(parsed("G1 X#1").assigns);
  EXPECT_TRUE(parsed("G1 X#<depth of cut> Y1").find('X')->expression);
  EXPECT_EQ(parsed("G1 X#<depth of cut> Y1").find('Y')->value, 1.0);
  EXPECT_EQ(parsed("G 1 X - 1 . 5").find('X')->value, -1.5);
  EXPECT_EQ(parsed("g01x+2y.5").find('Y')->value, 0.5);
  EXPECT_TRUE(parsed("X-[1+[2*3]] Y2").find('X')->expression);
  EXPECT_EQ(parsed("X-[1+[2*3]] Y2").find('Y')->value, 2.0);
  EXPECT_TRUE(parsed("Xsin[30] Y2").find('X')->expression);
  ProgramLine two = parsed("Xatan[1] / [2] Y2");
  two.set('X', "5.0", "");
  EXPECT_EQ(two.text, "X5.0 Y2");
  EXPECT_EQ(parsed("Xend Y2").find('Y')->value, 2.0);
}

// Words behind a number that grows or shrinks are where a new reading of the text finds them.
TEST(ProgramLine, WordsAreThoseOfTheTextAfterAChange) {
  for (const char* text : {"N1 G1 X1.5 Y-2 (Z3) Z4 F100 ; end", "g1x1y2z3", "X 1 . 5 Y [#2 + 1] Z-0", "X#1 Y2 #1=3",
                           "G1 X1 Y2 Z3 %", "X1 + 2 Y3 Z4"}) {
    for (const char* number : {"-123.4567", "0.0", "7"}) {
      for (const char letter : std::string("XYZF")) {
        ProgramLine line = parsed(text);
        line.set(letter, number, "XYZG");
        const ProgramLine again = parsed(line.text);
        ASSERT_EQ(line.words.size(), again.words.size()) << line.text;
        for (std::size_t k = 0; k < again.words.size(); ++k) {
          const Word &found = line.words[k], &wanted = again.words[k];
          EXPECT_EQ(std::tie(found.letter, found.begin, found.end, found.value, found.expression),
                    std::tie(wanted.letter, wanted.begin, wanted.end, wanted.value, wanted.expression))
              << line.text;
        }
        EXPECT_EQ(line.code_end, again.code_end) << line.text;
      }
    }
  }
}

TEST(ProgramLine, RemovesWordsAndKeepsEnds) {
  ProgramLine line = parsed("N5 G81 X1 Z-2 R3 F100 (drill)");
  line.remove({{'G', 81}, {'X', 1}, {'Z', -2}, {'R', 3}});
  EXPECT_EQ(line.text, "N5     F100 (drill)");
  const ProgramText text("G0\r\n\nG1 X1");
  ASSERT_EQ(text.size(), 3U);
  EXPECT_EQ(text.line(0).end, "\r\n");
  EXPECT_EQ(text.line(0).text, "G0");
  EXPECT_EQ(text.line(2).end, "");
  EXPECT_EQ(text.raw(2), "G1 X1");
  EXPECT_EQ(ProgramText("").size(), 0U);
  EXPECT_EQ(ProgramText("\n").size(), 1U);
}

// Lines of a file are those of its text, in any order.
TEST(ProgramText, AFileIsReadInAnyOrder) {
  const core::TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 1000; ++i)
    text += "G1 X" + std::to_string(i) + (i % 3 == 0 ? "\r\n" : i % 7 == 0 ? "\n\n" : "\n");
  text += "M2";
  core::write_file(folder / "part.ngc", text);
  const ProgramText file = ProgramText::of_file(folder / "part.ngc"), whole(text);
  ASSERT_EQ(file.size(), whole.size());
  std::string joined;
  for (std::size_t i = 0; i < file.size(); ++i) joined += file.raw(i);
  EXPECT_EQ(joined, text);
  for (const std::size_t i : {std::size_t{900}, std::size_t{3}, std::size_t{64}, std::size_t{63}, file.size() - 1})
    EXPECT_EQ(file.line(i).text, whole.line(i).text) << i;
  EXPECT_EQ(file.line(file.size() - 1).text, "M2");
  std::filesystem::resize_file(folder / "part.ngc", 6);
  EXPECT_THROW(file.raw(900), core::InputError);
  EXPECT_THROW(ProgramText::of_file(folder / "none.ngc"), core::InputError);
}

TEST(ProgramLine, NumbersAreShort) {
  EXPECT_EQ(nc_number(1.50004, 4), "1.5");
  EXPECT_EQ(nc_number(-0.00002, 4), "0.0");
  EXPECT_EQ(nc_number(12.0, 4), "12.0");
  EXPECT_EQ(nc_number(-3.12345, 4), "-3.1235");
}

}  // namespace
}  // namespace thermotwin::nc
