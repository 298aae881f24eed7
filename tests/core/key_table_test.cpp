// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/key_table.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "core/config.h"
#include "core/error.h"
#include "core/key_reference.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::core {
namespace {

const KeyTable& file() {
  static const KeyTable wheel{"gear.wheel",
                              "A wheel.",
                              {
                                  key::text("id", required, "Its name."),
                                  key::uncertain("mass_kg", "kg", {0.1, 10.0}, 2.0, "Its mass."),
                              }};
  static const KeyTable table{"gear.toml",
                              "A gear.",
                              {
                                  key::number("pitch_mm", "mm", positive, required, "Its pitch."),
                                  key::number("load_N", "N", {0.0, 1e3}, 5.0, "Its load.").or_list(),
                                  key::whole("teeth", 3, 99, 17.0, "How many."),
                                  key::flag("hardened", true, "It is hard."),
                                  key::word("kind", {"spur", "worm"}, "spur", "What it is."),
                                  key::reference("axis", "axis", Absent{"stands still"}, "What turns it."),
                                  key::number("<axis>_mm", "mm", any_number, Absent{}, "Where an axis stands."),
                                  key::tables("wheel", wheel, Absent{}, "Its wheels."),
                              }};
  return table;
}

std::string refusal(const std::string& text, void (*read)(const Node&)) {
  const Config config = Config::parse(text, "gear.toml", &file());
  return message_of<InputError>([&] { read(config.root()); });
}

void expect_holds(const std::string& message, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    EXPECT_NE(message.find(word), std::string::npos) << word << " not in " << message;
}

TEST(KeyTable, GivesWhatAnAbsentKeyMeans) {
  const Config config = Config::parse("[[wheel]]\nid = \"a\"", "gear.toml", &file());
  const Node root = config.root();
  EXPECT_EQ(root.number("load_N"), 5.0);
  EXPECT_EQ(root.integer("teeth"), 17);
  EXPECT_TRUE(root.boolean("hardened"));
  EXPECT_EQ(root.choice("kind"), "spur");
  EXPECT_EQ(root.text_or("axis", ""), "");
  const Uncertain mass = root.tables("wheel").front().uncertain("mass_kg");
  EXPECT_EQ(mass.value, 2.0);
  EXPECT_EQ(mass.std_percent, 0.0);
}

TEST(KeyTable, HoldsWhatIsAllowed) {
  expect_holds(refusal("", [](const Node& node) { node.number("pitch_mm"); }), {"pitch_mm", "missing", "above 0"});
  expect_holds(refusal("load_N = 2000", [](const Node& node) { node.number("load_N"); }), {"2000", "from 0 to 1000"});
  expect_holds(refusal("load_N = [1, 2000]", [](const Node& node) { node.numbers("load_N"); }),
               {"load_N[2]", "2000", "from 0 to 1000"});
  expect_holds(refusal("teeth = 2", [](const Node& node) { node.integer("teeth"); }), {"2", "from 3 to 99"});
  expect_holds(refusal("kind = \"bevel\"", [](const Node& node) { node.choice("kind"); }), {"bevel", "spur, worm"});
  expect_holds(refusal("[[wheel]]\nmass_kg = {value = 11, std_percent = 5}",
                       [](const Node& node) { node.tables("wheel").front().uncertain("mass_kg"); }),
               {"gear.toml:2 wheel[1].mass_kg", "11", "from 0.1 to 10"});
}

TEST(KeyTable, AReaderMayNarrowWhatIsAllowed) {
  expect_holds(refusal("load_N = 7",
                       [](const Node& node) {
                         node.number("load_N", Range{0.0, 6.0});
                       }),
               {"7", "from 0 to 6"});
}

TEST(KeyTable, AReaderAsksOnlyForItsRows) {
  const Config config = Config::parse("pitch = 1", "gear.toml", &file());
  const Node root = config.root();
  EXPECT_THROW(root.number("pitch"), std::logic_error);
  EXPECT_THROW((void)root.has("pitch"), std::logic_error);
  EXPECT_THROW(root.text("load_N"), std::logic_error);
  EXPECT_THROW(root.uncertain("load_N"), std::logic_error);
  EXPECT_THROW(root.numbers("pitch_mm"), std::logic_error);
}

TEST(KeyTable, TellsUnknownKeysFromThoseWithoutMeaning) {
  expect_holds(refusal("toth = 5", [](const Node& node) { node.finish(); }), {"unknown key", "nearest is teeth"});
  expect_holds(refusal("teeth = 5", [](const Node& node) { node.finish(); }), {"teeth", "no meaning here"});
  expect_holds(refusal("Q_mm = 5", [](const Node& node) { node.number_or("X_mm", 0.0), node.finish(); }),
               {"Q_mm", "unknown key", "nearest is X_mm"});
}

TEST(KeyTable, ARowOfPatternHoldsForEveryAxis) {
  const Config config = Config::parse("X_mm = 3\nY2_mm = 4", "gear.toml", &file());
  EXPECT_EQ(config.root().number("X_mm"), 3.0);
  EXPECT_EQ(config.root().number("Y2_mm"), 4.0);
  EXPECT_THROW(config.root().number("_mm"), std::logic_error);
  EXPECT_EQ(file().find("pitch_mm")->unit, "mm");
  EXPECT_EQ(file().find("pitch_mm")->says, "Its pitch.");
}

TEST(KeyTable, IsTheReference) {
  const std::string page = key_reference(file());
  expect_holds(page, {"# gear.toml\n\nA gear.\n", "| `pitch_mm` | number, mm | **required** | above 0 | Its pitch. |",
                      "| `load_N` | number, or several, N | 5 | 0 to 1000 | Its load. |",
                      "| `teeth` | whole number | 17 | 3 to 99 | How many. |",
                      "| `hardened` | true or false | true |  | It is hard. |",
                      "| `kind` | word | \"spur\" | `spur`, `worm` | What it is. |",
                      "| `axis` | id of axis | stands still |  | What turns it. |", "\n## gear.wheel\n\nA wheel.\n",
                      "| `mass_kg` | number *u*, kg | 2 | 0.1 to 10 | Its mass. |"});
}

}  // namespace
}  // namespace thermotwin::core
