// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/toml_place.h"

#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::core {
namespace {

TEST(TomlPlace, NamesTheLineOfAKey) {
  const std::string text = "a = 1\n\n[tcp]\npoint = [1]\n";
  EXPECT_EQ(toml_place(text, "m.toml", "tcp", "point"), "m.toml:4 tcp.point");
  EXPECT_EQ(toml_place(text, "m.toml", "", "a"), "m.toml:1 a");
  EXPECT_EQ(toml_place("a = ", "m.toml", "tcp", "point"), "m.toml tcp.point");
  EXPECT_EQ(toml_place(text, "m.toml", "workspace", "X"), "m.toml workspace.X");
  EXPECT_EQ(toml_place(std::filesystem::path("none.toml"), "tcp", "point"), "none.toml tcp.point");
}

TEST(TomlPlace, NamesTheLineOfAnId) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "of monday");  // a place ends at its last space, not at the path's
  const std::filesystem::path file = folder / "of monday" / "channels.toml";
  write_file(file, "[[channel]]\nid = \"T1\"\n[[channel]]\nkind = \"x\"\n[[channel]]\nid = \"T2\"\n");
  const std::string name = file.string();
  EXPECT_EQ(toml_places_of_ids(file, "channel", {"T2", "T3", "T1"}),
            (std::vector<std::string>{name + ":6 channel 'T2'", name + " channel 'T3'", name + ":2 channel 'T1'"}));
  std::filesystem::remove(file);
  EXPECT_EQ(toml_places_of_ids(file, "channel", {"T1"}), std::vector<std::string>{name + " channel 'T1'"});
}

}  // namespace
}  // namespace thermotwin::core
