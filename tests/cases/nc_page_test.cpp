// SPDX-License-Identifier: GPL-3.0-or-later
// The page that `nc` leaves: it draws the path, choices change the picture, and its tables hold what the files hold.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <regex>
#include <set>

#include "core/table.h"
#include "tests/cases/browser.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

/// Two tools: a pocket of circles, then a face on the tilted and turning table.
const char* const two_tools =
    "G21 G90 G64 P0.01\nT1 M6\nM3 S9000\nG0 X-40 Y0 Z60\no1 repeat [12]\nG91\nG1 Z-1 F3000\nG90\nG2 I40 J0 F6000\n"
    "o1 endrepeat\nG0 Z80\nT2 M6\nM3 S4000\nG0 X0 Y0\nG1 Z60 F3000\nB20 C90\nX30\nC180\nX60 B0\nG0 Z90\nM2\n";

class NcPage : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
    toy.write("control.toml", "schema = 1\n[[tool]]\nnumber = 1\nlength_mm = 30\n[[tool]]\nnumber = 2\n");
  }
  void run(const std::string& text, std::vector<std::string> more = {}) {
    toy.write("part.ngc", text);
    std::vector<std::string> arguments = {"nc", toy_model(), toy.file("part.ngc"), "--control",
                                          toy.file("control.toml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = toy.run(arguments);
    ASSERT_EQ(result.status, 0) << result.err;
    expect_self_contained(page());
  }
  fs::path page() const { return toy.result("report.html"); }
  Toy toy;
};

TEST_F(NcPage, ChoicesChangeThePicture) {
  run(two_tools);
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  std::set<std::string> pictures;
  const char* const views[] = {"#time=0",          "#time=0.6",        "#time=0&colour=1", "#time=0&colour=2",
                               "#time=0&colour=3", "#time=0&colour=4", "#time=0&turn=0.5", "#time=0&rapid=0"};
  for (const char* view : views) {
    const Page shown = opened(page(), view, toy.path());
    expect_quiet(shown);
    EXPECT_NE(shown.attribute_of("path", "data-picture"), "");
    pictures.insert(shown.attribute_of("path", "data-picture"));
  }
  EXPECT_EQ(pictures.size(), std::size(views));
  const Page again = opened(page(), views[0], toy.path());
  EXPECT_TRUE(pictures.contains(again.attribute_of("path", "data-picture")));
  expect_turns_and_zooms(page(), "path", toy.path());
}

// The point of the largest error is the one that the page begins with, and its line is in blocks.csv.
TEST_F(NcPage, NamesTheLineOfTheLargestError) {
  run(two_tools);
  const core::Table blocks = core::read_csv(toy.result("blocks.csv"));
  const Eigen::ArrayXd rapid = blocks.column("rapid");
  const Eigen::ArrayXd length = (blocks.column("dx_um").array().square() + blocks.column("dy_um").array().square() +
                                 blocks.column("dz_um").array().square())
                                    .sqrt() *
                                (1.0 - rapid);
  const std::string text = read(page());
  const std::string words = "The largest TCP error of a cut is ";
  const std::size_t at = text.find(words);
  ASSERT_NE(at, std::string::npos);
  // Between the ends of moves it may be a little larger.
  EXPECT_NEAR(std::stod(text.substr(at + words.size())), length.maxCoeff(), 0.05 * length.maxCoeff() + 0.1);
  EXPECT_SAYS(text, "<td>T1</td>");
  EXPECT_SAYS(text, "<td>T2</td>");
  EXPECT_SAYS(text, "None: all moves end within the workspace of the model.");
  EXPECT_SAYS(text, "--rewrite path");
  const core::Table operations = core::read_csv(toy.result("operations.csv"));
  EXPECT_NEAR(operations.column("mean_feed_mm_min")[1], 2900.0, 101.0) << "angles are no millimetres";
}

TEST_F(NcPage, ListsMovesBeyondTheWorkspaceAndTheSeries) {
  run("G21 G90\nT1 M6\nM3 S12000\nG0 X0 Z60\nG1 B95 F6000\nX1 F6000\nB0\nX100 F12000\nX0\nG4 P300\nM2\n",
      {"--repeat", "5", "--tolerance", "2"});
  const std::string text = read(page());
  EXPECT_SAYS(text, "pose outside of the workspace of the model");
  EXPECT_SAYS(text, "<td>5 to 6</td>");
  EXPECT_SAYS(text, "Series of parts");
  EXPECT_SAYS(text, "The first good part is number");
  EXPECT_SAYS(text, "The series has not settled");
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  const Page shown = opened(page(), "", toy.path());
  expect_quiet(shown);
  // The path is that of the last part; the page begins with its largest error, the end of the colours.
  std::smatch end, length;
  ASSERT_TRUE(std::regex_search(shown.document, end, std::regex("id=\"path-range\">[^<]*<i [^>]*></i>([0-9.]+)")));
  ASSERT_TRUE(std::regex_search(shown.document, length, std::regex("; length ([0-9.]+)")));
  EXPECT_EQ(length[1].str(), end[1].str());
}

// A long program keeps the page small; the page says how far it is thinned.
TEST_F(NcPage, OfALongProgramIsThinned) {
  std::string text = "G21 G90 F6000\n";
  for (int i = 0; i < 100000; ++i)
    text += fmt::format("G1 X{:.3f} Y{:.3f} Z{:.3f}\n", 40.0 * std::sin(0.7 * i), 30.0 * std::cos(1.3 * i),
                        60.0 + 10.0 * std::sin(0.01 * i));
  run(text + "M2\n", {"--no-blocks"});
  EXPECT_LT(fs::file_size(page()), 3U * 1024 * 1024);
  EXPECT_SAYS(read(page()), "the others lie within");
  run(text + "M2\n", {"--no-blocks", "--rewrite", "path"});
  EXPECT_SAYS(read(page()), "part.corrected.ngc is the corrected program");
}

TEST_F(NcPage, IsLeftOutOnRequestAndWithoutAModel) {
  toy.write("part.ngc", "G21 G90\nG0 X10\nM2\n");
  ASSERT_EQ(toy.run({"nc", toy_model(), toy.file("part.ngc"), "--no-page"}).status, 0);
  EXPECT_FALSE(fs::exists(page()));
  ASSERT_EQ(toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc")}).status, 0);
  EXPECT_FALSE(fs::exists(page()));
  ASSERT_EQ(toy.run({"nc", toy_model(), toy.file("part.ngc")}).status, 0);
  expect_self_contained(page());
}

}  // namespace
}  // namespace thermotwin::cases
