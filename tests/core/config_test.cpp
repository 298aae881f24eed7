// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/config.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "core/unique_id.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::core {
namespace {

Config config_of(const std::string& text) { return Config::parse(text, "machine.toml"); }

/// What the reader's InputError says.
template <class Read>
std::string refusal(const std::string& text, const Read& read) {
  const Config config = config_of(text);
  return message_of<InputError>([&] { read(config.root()); });
}

void expect_holds(const std::string& message, const std::vector<std::string>& parts) {
  EXPECT_NE(message, "");
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' not in: " << message;
  }
}

TEST(Config, ReadsEachKindOfValue) {
  const Config config = config_of(R"(
real = 2.5
whole = 3
yes = true
word = "guide"
point = [1, 2.5, -3e-3]
list = [0, 6000, 12000.5]
names = ["a", "b"]
points = [[0, 1, 2], [2.5, 3, -4]]
sure = 5
unsure = { value = 5.0, std_percent = 10 }
[mesh]
fine = 0.3
)");
  const Node root = config.root();
  EXPECT_EQ(root.number("real"), 2.5);
  EXPECT_EQ(root.number("whole"), 3.0);
  EXPECT_EQ(root.integer("whole", 0, 3), 3);
  EXPECT_TRUE(root.boolean_or("yes", false));
  EXPECT_EQ(root.choice("word", {"guide", "bolted"}), "guide");
  EXPECT_EQ(root.vector3("point"), Eigen::Vector3d(1, 2.5, -3e-3));
  EXPECT_EQ(root.numbers("list"), (std::vector<double>{0, 6000, 12000.5}));
  EXPECT_EQ(root.texts("names"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(root.texts("word"), (std::vector<std::string>{"guide"}));
  Eigen::MatrixX3d points(2, 3);
  points << 0, 1, 2, 2.5, 3, -4;
  EXPECT_EQ(root.points3("points"), points);
  EXPECT_EQ(root.uncertain("sure").value, 5.0);
  EXPECT_EQ(root.uncertain("sure").std_percent, 0.0);
  EXPECT_EQ(root.uncertain("unsure").value, 5.0);
  EXPECT_EQ(root.uncertain("unsure").std_percent, 10.0);
  EXPECT_EQ(root.table("mesh").number("fine"), 0.3);
  EXPECT_NO_THROW(root.finish());
}

TEST(Config, AbsentKeysGiveTheDefaults) {
  const Config config = config_of("");
  const Node root = config.root();
  EXPECT_EQ(root.number_or("a", 1.5), 1.5);
  EXPECT_EQ(root.integer_or("a", 2, 0, 9), 2);
  EXPECT_TRUE(root.boolean_or("a", true));
  EXPECT_EQ(root.text_or("a", "x"), "x");
  EXPECT_EQ(root.choice_or("a", "x", {"x", "y"}), "x");
  EXPECT_EQ(root.uncertain_or("a", {1.0, 5.0}).std_percent, 5.0);
  EXPECT_TRUE(root.texts_or_empty("a").empty());
  EXPECT_TRUE(root.tables("a").empty());
  EXPECT_FALSE(root.table_if("a"));
  EXPECT_FALSE(root.has("a"));
}

TEST(Config, KeysAreInTheOrderOfTheFile) {
  const Config config = config_of("z = 1\na = 2\nm = 3\n[b]\n[aa]\n");
  EXPECT_EQ(config.root().keys(), (std::vector<std::string>{"z", "a", "m", "b", "aa"}));
  EXPECT_NE(message_of<InputError>([&] { config.root().finish(); }), "") << "keys() counts none as known";
}

TEST(Config, MissingKeyNamesItsTableAndAMisspelling) {
  const auto read = [](const Node& root) { root.tables("material").at(1).number("density_kg_m3"); };
  const std::string message =
      refusal("[[material]]\nid = \"a\"\n[[material]]\nid = \"b\"\ndensty_kg_m3 = 7200\n", read);
  expect_holds(message, {"machine.toml:3 material[2].density_kg_m3", "missing", "densty_kg_m3"});
  expect_holds(refusal("", [](const Node& root) { root.text("name"); }), {"machine.toml name", "missing"});
}

TEST(Config, UnknownKeyNamesTheNearestKnownOne) {
  const std::string message = refusal("[mesh]\ncoarse = 1\nfin = 0.3\n", [](const Node& root) {
    const Node mesh = root.table("mesh");
    mesh.number("coarse");
    mesh.number_or("fine", 0.5);
    root.finish();
    mesh.finish();
  });
  expect_holds(message, {"machine.toml:3 mesh.fin", "unknown key", "nearest is fine"});
}

TEST(Config, UnknownTablesAndInnerKeysAreFound) {
  expect_holds(refusal("[[fim]]\nid = 1\n",
                       [](const Node& root) {
                         root.tables("film");
                         root.finish();
                       }),
               {"machine.toml:1 fim", "nearest is film"});
  expect_holds(refusal("a = {value = 1, std_percent = 2, sdt = 3}\n", [](const Node& root) { root.uncertain("a"); }),
               {"machine.toml:1 a.sdt", "unknown key"});
}

TEST(Config, TwoNodesOfATableShareWhatTheyKnow) {
  const Config config = config_of("[mesh]\na = 1\nb = 2\n");
  config.root().table("mesh").number("a");
  config.root().table("mesh").number("b");
  EXPECT_NO_THROW(config.root().table("mesh").finish());
}

TEST(Config, NodesOutliveAMoveOfTheConfig) {
  Config config = config_of("[mesh]\na = 1\n");
  const Node mesh = config.root().table("mesh");
  const Config moved = std::move(config);
  EXPECT_EQ(mesh.number("a"), 1.0);
  EXPECT_EQ(mesh.place("a"), "machine.toml:2 mesh.a");
}

TEST(Config, WrongTypesAreRefused) {
  const auto number = [](const Node& root) { root.number("a"); };
  expect_holds(refusal("a = \"5\"", number), {"machine.toml:1 a", "\"5\"", "without quotes"});
  expect_holds(refusal("a = true", number), {"true", "a finite number"});
  expect_holds(refusal("a = [1]", number), {"an array of 1"});
  expect_holds(refusal("a = {value = 1, std_percent = 1}", number), {"a table"});
  expect_holds(refusal("a = 2020-01-01", number), {"date"});
  expect_holds(refusal("a = 1.0", [](const Node& root) { root.integer("a", 0, 9); }), {"an integer from 0 to 9"});
  expect_holds(refusal("a = 1", [](const Node& root) { root.boolean_or("a", true); }), {"true or false"});
  expect_holds(refusal("a = 1", [](const Node& root) { root.text("a"); }), {"quotes"});
  expect_holds(refusal("a = 1", [](const Node& root) { root.texts("a"); }), {"array"});
  expect_holds(refusal("a = [\"x\", 1]", [](const Node& root) { root.texts("a"); }), {"a[2]"});
  expect_holds(refusal("a = [1, 2]", [](const Node& root) { root.vector3("a"); }), {"[x, y, z]"});
  expect_holds(refusal("a = [1, \"2\"]", [](const Node& root) { root.numbers("a"); }), {"a[2]", "\"2\""});
  expect_holds(refusal("a = 1", [](const Node& root) { root.numbers("a"); }), {"array of numbers"});
  expect_holds(refusal("a = [[1, 2, 3], [3]]", [](const Node& root) { root.points3("a"); }), {"a[2]", "[x, y, z]"});
  expect_holds(refusal("a = 1", [](const Node& root) { root.table("a"); }), {"[a]"});
  expect_holds(refusal("[a]", [](const Node& root) { root.tables("a"); }), {"[[a]]"});
  expect_holds(refusal("[[a]]", [](const Node& root) { root.table("a"); }), {"one table"});
  expect_holds(refusal("a = \"flim\"",
                       [](const Node& root) {
                         root.choice("a", {"film", "joint"});
                       }),
               {"machine.toml:1 a", "\"flim\"", "one of: film, joint"});
}

TEST(Config, RangesAreInclusiveAndNeverHoldNan) {
  const auto within = [](double low, double high) {
    return [=](const Node& root) { root.number("a", Range{low, high}); };
  };
  EXPECT_EQ(refusal("a = 0", within(0, 1)), "");
  EXPECT_EQ(refusal("a = 1.0", within(0, 1)), "");
  expect_holds(refusal("a = 1.01", within(0, 1)), {"1.01", "a number from 0 to 1"});
  expect_holds(refusal("a = nan", within(-1e300, 1e300)), {"nan"});
  expect_holds(refusal("a = inf", within(-1e300, 1e300)), {"inf"});
  expect_holds(refusal("a = 0", [](const Node& root) { root.number("a", positive); }), {"above 0"});
  expect_holds(refusal("a = -1", [](const Node& root) { root.number("a", non_negative); }), {"at least 0"});
  expect_holds(refusal("a = -1", [](const Node& root) { root.uncertain("a", positive); }), {"above 0"});
  expect_holds(refusal("a = {value = 1, std_percent = -1}", [](const Node& root) { root.uncertain("a"); }),
               {"a.std_percent", "at least 0"});
  expect_holds(refusal("a = 99999999999", [](const Node& root) { root.integer("a", 0, 9); }), {"from 0 to 9"});
}

TEST(Config, PlacesOfNestedTables) {
  const Config config = config_of("[[coolant]]\nid = \"main\"\n[[coolant.segment]]\nid = \"s\"\n\nvolume_l = 1\n");
  const Node segment = config.root().tables("coolant").at(0).tables("segment").at(0);
  EXPECT_EQ(segment.place(), "machine.toml:3 coolant[1].segment[1]");
  EXPECT_EQ(segment.place("volume_l"), "machine.toml:6 coolant[1].segment[1].volume_l");
  EXPECT_EQ(config.root().place(), "machine.toml");
}

TEST(Config, BrokenFilesSayLineAndColumn) {
  const auto problem = [](const std::string& text) { return message_of<InputError>([&] { config_of(text); }); };
  expect_holds(problem("a = 1\nb = \n"), {"machine.toml:2:"});
  expect_holds(problem("a = 1\na = 2\n"), {"machine.toml:2:"});
  expect_holds(problem("a = 1\nb = \"\xCC\x83\xCC\""), {"machine.toml:2:8", "0xcc", "UTF-8"});
  // Letters that the parser meets outside of quotes as it sees them: behind a bare word, and behind an empty text.
  expect_holds(problem("a = 1\nb = [60of\"ä\"]"), {"machine.toml:2:"});
  expect_holds(problem("\"\"\"\"es\\\\\xEF\xBB\xBEurat_mi=0-o"), {"machine.toml:1:"});
  EXPECT_EQ(config_of("a.\"b\" = \"ä\" # ä\n").root().table("a").text("b"), "ä");
  expect_holds(problem("\xFF"), {"machine.toml:1:1"});
  expect_holds(problem("a = \"ä\" # ä\nb = ä\n"), {"machine.toml:2:5", "0xc3", "quotes"});
}

TEST(Config, LinesThatAreNoTomlSayWhatIsMeant) {
  const auto problem = [](const std::string& text) { return message_of<InputError>([&] { config_of(text); }); };
  expect_holds(problem("a = 0,26 # x\n"), {"machine.toml:1:", "a decimal point: a = 0.26"});
  expect_holds(problem("b = 1\na = steel\n"), {"machine.toml:2:", "a text in quotes: a = \"steel\""});
  expect_holds(problem("a = True\n"), {"small letters: a = true"});
  expect_holds(problem("[a]\nb = 1\n[a]\nb = 2\n"), {"machine.toml:3:", "of several ones [[a]] each"});
  expect_holds(problem("a = 1,2,3\n"), {"TOML 1.0"});
}

TEST(Config, LoadsAFileAndKeepsItsText) {
  const TemporaryFolder folder;
  write_file(folder / "case.toml", "schema = 1\n");
  const Config config = Config::load(folder / "case.toml");
  EXPECT_EQ(config.text(), "schema = 1\n");
  EXPECT_EQ(config.source(), (folder / "case.toml").string());
  EXPECT_THROW(Config::load(folder / "none.toml"), InputError);
}

TEST(Config, ANewerSchemaNamesBothVersions) {
  EXPECT_EQ(config_of("schema = 1").root().schema(1), 1);
  expect_holds(message_of<InputError>([] { config_of("schema = 3").root().schema(1); }),
               {"schema", "schema 3, of a newer thermotwin", "allowed: schema 1"});
  EXPECT_THROW(config_of("a = 1").root().schema(1), InputError);
}

TEST(UniqueId, RefusesEmptyDoubleAndOddIds) {
  std::vector<std::string> seen;
  EXPECT_NO_THROW(require_unique_id("bed.skin-2_b", "here", seen));
  EXPECT_NO_THROW(require_unique_id("bed", "here", seen));
  expect_holds(message_of<InputError>([&] { require_unique_id("bed", "m.toml:4", seen); }),
               {"m.toml:4", "bed", "second time"});
  for (const char* id : {"", "a b", "a,b", "ä", "a/b"}) {
    EXPECT_THROW(require_unique_id(id, "here", seen), InputError) << id;
  }
}

}  // namespace
}  // namespace thermotwin::core
