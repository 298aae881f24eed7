// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/control/control_profile.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "nc/control/control_keys.h"
#include "tests/core/reference_page.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::nc {
namespace {

mesh::Machine machine() {
  mesh::Machine machine;
  machine.axes.resize(2);
  machine.axes[0].id = "X";
  machine.axes[0].rapid = 0.5;
  machine.axes[1].id = "C";
  machine.axes[1].kind = mesh::AxisKind::rotary;
  return machine;
}

TEST(ControlProfile, ReferencePageIsThatOfTheReader) {
  core::expect_reference_page("control", control_keys(), "nc_tests");
}

TEST(ControlProfile, BuiltInOnesAreRead) {
  const ControlProfile linuxcnc = ControlProfile::load("linuxcnc", machine());
  EXPECT_EQ(linuxcnc.words.size(), 3U);
  EXPECT_EQ(linuxcnc.axes[0].speed, 0.5);
  EXPECT_EQ(linuxcnc.axes[0].acceleration, 3.0);
  EXPECT_NEAR(linuxcnc.axes[1].acceleration, 26.1799388, 1e-6);
  EXPECT_EQ(linuxcnc.moves, 2e7);
  EXPECT_GT(ControlProfile::load("fanuc", machine()).words.size(), 10U);
  EXPECT_EQ(ControlProfile::load("fanuc", machine()).dialect, Dialect::fanuc);
  EXPECT_TRUE(linuxcnc.block_delete);
  EXPECT_THROW(ControlProfile::load("heidenhain", machine()), core::InputError);
}

TEST(ControlProfile, WordsThatContradictEachOtherAreRefused) {
  const core::TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    core::write_file(folder / "own.toml", "schema = 1\n" + text);
    try {
      ControlProfile::load((folder / "own.toml").string(), machine());
    } catch (const core::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string skip = "[[word]]\nword = \"M21\"\naction = \"skip\"\n";
  EXPECT_EQ(message(skip), "");
  EXPECT_NE(message(skip + "[[word]]\nword = \"M021\"\naction = \"refuse\"\n").find("'M021' a second time"),
            std::string::npos);
  EXPECT_NE(message(skip + "by = \"M8\"\n").find("own.toml:5"), std::string::npos) << message(skip + "by = \"M8\"\n");
}

TEST(ControlProfile, AxesToolsAndOffsetsAreInSi) {
  const ControlProfile profile = ControlProfile::parse(
      "schema = 1\nacceleration_m_s2 = 2\n[[axis]]\nid = \"C\"\nacceleration_deg_s2 = 180\nrapid_deg_min = 3600\n"
      "[[tool]]\nnumber = 3\nlength_mm = 120\ndiameter_mm = 16\n[[work_offset]]\nnumber = 1\nX_mm = 5\nC_deg = 90\n",
      "test", machine());
  EXPECT_DOUBLE_EQ(profile.axes[0].acceleration, 2.0);
  EXPECT_NEAR(profile.axes[1].acceleration, 3.14159265, 1e-8);
  EXPECT_NEAR(profile.axes[1].speed, 1.04719755, 1e-8);
  EXPECT_DOUBLE_EQ(profile.tools[0].offset[2], 0.12);
  EXPECT_DOUBLE_EQ(profile.work_offsets[0].offset[0], 0.005);
  EXPECT_NEAR(profile.work_offsets[0].offset[5], 1.57079633, 1e-8);
  EXPECT_THROW(ControlProfile::parse("schema = 1\n[[axis]]\nid = \"Q\"\n", "test", machine()), core::InputError);
  EXPECT_THROW(ControlProfile::parse("schema = 1\n[[word]]\nword = \"G1\"\naction = \"replace\"\n", "test", machine()),
               core::InputError);
  EXPECT_THROW(
      ControlProfile::parse("schema = 1\n[[word]]\nword = \"G1\"\naction = \"skip\"\nsays = \"a)b\"\n", "t", machine()),
      core::InputError);
}

TEST(ToolTable, HasTheWordsOfLinuxCnc) {
  const core::TemporaryFolder folder;
  core::write_file(folder / "t.tbl", "T1 P1 Z+12.5 D6 ;end mill\n\nT2 P2 X-1 Z3 I45 J-45 Q2\r\n");
  const std::vector<Tool> tools = read_tool_table(folder / "t.tbl");
  ASSERT_EQ(tools.size(), 2U);
  EXPECT_DOUBLE_EQ(tools[0].offset[2], 0.0125);
  EXPECT_DOUBLE_EQ(tools[0].diameter, 0.006);
  EXPECT_DOUBLE_EQ(tools[1].offset[0], -0.001);
  EXPECT_EQ(tools[1].orientation, 2);
  core::write_file(folder / "t.tbl", "T1 P1 Zx\n");
  EXPECT_THROW(read_tool_table(folder / "t.tbl"), core::InputError);
}

}  // namespace
}  // namespace thermotwin::nc
