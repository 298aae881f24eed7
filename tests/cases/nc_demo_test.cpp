// SPDX-License-Identifier: GPL-3.0-or-later
// LinuxCNC's five-axis demonstration programs run whole: the boat on a chain with B and C, the impeller on one with A
// and C. They come with the package linuxcnc-uspace.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The file of the package; empty: it is not there.
fs::path demo(const std::string& name) {
  for (const char* root : {"/usr/share/linuxcnc/ncfiles", "/usr/share/doc/linuxcnc/examples/sample-configs/sim"}) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root, ignored))
      if (entry.path().filename() == name) return entry.path();
  }
  return {};
}

/// Lines with an axis word.
long lines_with_axes(const std::string& text, const std::string& letters) {
  const std::regex axis("[" + letters + "] *-?[0-9.]");
  std::istringstream lines(text);
  long count = 0;
  for (std::string line; std::getline(lines, line);)
    count += line.front() != '(' && std::regex_search(line, axis) ? 1 : 0;
  return count;
}

class NcDemo : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
    toy.write("control.toml",
              "schema = 1\n[[word]]\nword = \"M428\"\naction = \"tcp_on\"\n[[word]]\nword = \"M429\"\naction = "
              "\"tcp_off\"\n[[tool]]\nnumber = 1\n");
  }
  /// Runs the program on a machine of a case whose travels are wide. @return the summary
  json run(const fs::path& machine, const fs::path& program) const {
    std::string text = read(machine);
    text = std::regex_replace(text, std::regex("\ntravel_mm = [^\n]*"), "\ntravel_mm = [-2000, 2000]");
    text = std::regex_replace(text, std::regex("\ntravel_deg = [^\n]*"), "\ntravel_deg = [-360, 360]");
    fs::copy(machine.parent_path(), toy.file("../wide"), fs::copy_options::recursive);
    toy.write("../wide/machine.toml", text);
    const Result result = toy.run(
        {"nc", toy.file("../wide/machine.toml"), program.string(), "--control", toy.file("control.toml"), "--json"});
    EXPECT_EQ(result.status, 0) << result.err;
    return result.status == 0 ? json::parse(result.out) : json();
  }
  Toy toy;
};

/// With THERMOTWIN_LINUXCNC set the file must be there.
#define REQUIRE_DEMO(file, name)                                                                         \
  if ((file).empty()) {                                                                                  \
    ASSERT_EQ(std::getenv("THERMOTWIN_LINUXCNC"), nullptr) << "linuxcnc-uspace came without " << (name); \
    GTEST_SKIP() << "no " << (name);                                                                     \
  }

TEST_F(NcDemo, TheBoatRunsWhole) {
  const fs::path boat = demo("boat-xyzbc.ngc");
  REQUIRE_DEMO(boat, "boat-xyzbc.ngc");
  const json summary = run(toy.file("machine.toml"), boat);
  const long lines = lines_with_axes(read(boat), "XYZBC");
  EXPECT_GT(lines, 1700);
  // A line that names where the control is moves nothing.
  EXPECT_LE(summary["moves"], lines);
  EXPECT_GT(summary["moves"], 0.98 * static_cast<double>(lines));
  EXPECT_EQ(summary["tool_changes"], 1);
  for (const char* axis : {"X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg"}) {
    const double travel = summary["travel"][axis];
    EXPECT_GT(travel, 10.0) << axis;
    EXPECT_NEAR(summary["travel_rows"][axis].get<double>(), travel, 1e-9 * travel) << axis;
  }
}

TEST_F(NcDemo, TheImpellerRunsWholeOnAChainWithA) {
  const fs::path impeller = demo("impeller-7bl-xyzac.ngc");
  REQUIRE_DEMO(impeller, "impeller-7bl-xyzac.ngc");
  const json summary = run(toy_case() / "../../../cases/ac5/machine.toml", impeller);
  EXPECT_EQ(summary["moves"], lines_with_axes(read(impeller), "XYZAC"));
  for (const char* axis : {"X_mm", "Y_mm", "Z_mm", "A_deg", "C_deg"}) {
    const double travel = summary["travel"][axis];
    EXPECT_GT(travel, 100.0) << axis;
    EXPECT_NEAR(summary["travel_rows"][axis].get<double>(), travel, 1e-9 * travel) << axis;
  }
}

}  // namespace
}  // namespace thermotwin::cases
