// SPDX-License-Identifier: GPL-3.0-or-later
// docs/reference has a page for each file that a user writes, made from the table that its reader uses;
// THERMOTWIN_REFERENCE=docs/reference writes them anew.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "compensation/measurement/channel_keys.h"
#include "core/file.h"
#include "core/key_reference.h"
#include "mesh/machine/machine_keys.h"
#include "reduction/systems/names_keys.h"
#include "solver/campaign/case_keys.h"
#include "solver/operation/load_keys.h"

namespace thermotwin::compensation {
namespace {

struct Page {
  std::string name;
  const core::KeyTable* keys;
  std::vector<std::string> readers;  ///< folders or files of the readers' sources
};

std::vector<Page> pages() {
  return {{"machine", &mesh::machine_keys(), {"mesh/machine"}},
          {"case", &solver::case_keys(), {"solver/campaign/case.cpp", "solver/operation/time_options.cpp"}},
          {"load", &solver::load_keys(), {"solver/operation"}},
          {"channels", &channel_keys(), {"compensation/measurement"}},
          {"names", &reduction::names_keys(), {"reduction/systems"}}};
}

std::string text_of(const Page& page) {
  return "<!-- SPDX-License-Identifier: GPL-3.0-or-later -->\n<!-- Made from the reader's table of keys; the test "
         "ReferencePages writes it. -->\n" +
         core::key_reference(*page.keys);
}

void collect(const core::KeyTable& table, std::set<const core::KeyTable*>& tables) {
  if (!tables.insert(&table).second) return;
  for (const core::Key& key : table.keys)
    if (key.keys != nullptr) collect(*key.keys, tables);
}

std::set<const core::KeyTable*> tables_of(const core::KeyTable& file) {
  std::set<const core::KeyTable*> tables;
  collect(file, tables);
  return tables;
}

TEST(ReferencePages, AreThoseOfTheReaders) {
  for (const Page& page : pages()) {
    const std::string name = "docs/reference/" + page.name + ".md";
    if (const char* folder = std::getenv("THERMOTWIN_REFERENCE"))
      core::write_file(std::filesystem::path(folder) / (page.name + ".md"), text_of(page));
    EXPECT_EQ(core::read_file(std::string(THERMOTWIN_SOURCE_DIR) + "/" + name), text_of(page))
        << "write it anew: THERMOTWIN_REFERENCE=docs/reference build/tests/compensation_tests "
           "--gtest_filter=ReferencePages.*";
  }
}

TEST(ReferencePages, EveryRowIsASentenceWithItsUnit) {
  for (const Page& page : pages()) {
    for (const core::KeyTable* table : tables_of(*page.keys)) {
      EXPECT_TRUE(table->says.ends_with(".")) << table->name;
      std::set<std::string> names;
      for (const core::Key& key : table->keys) {
        EXPECT_TRUE(names.insert(key.name).second) << table->name << " " << key.name << " twice";
        EXPECT_TRUE(key.says.ends_with(".") || key.says.ends_with("...")) << table->name << " " << key.name;
        EXPECT_LE(std::count(key.says.begin(), key.says.end(), ' '), 40) << table->name << " " << key.name;
        const bool number = key.kind == core::KeyKind::number || key.kind == core::KeyKind::uncertain;
        EXPECT_TRUE(!number || !key.unit.empty()) << table->name << " " << key.name << " has no unit";
        if (const auto* value = std::get_if<double>(&key.otherwise)) {
          EXPECT_TRUE(key.range.holds(*value)) << table->name << " " << key.name << " = " << *value;
        }
        if (const auto* word = std::get_if<std::string>(&key.otherwise); word && key.kind == core::KeyKind::word) {
          EXPECT_NE(std::find(key.words.begin(), key.words.end(), *word), key.words.end()) << key.name;
        }
      }
    }
  }
}

TEST(ReferencePages, EveryRowIsReadBySomeReader) {
  for (const Page& page : pages()) {
    std::string text;
    for (const std::string& reader : page.readers) {
      const std::filesystem::path path = std::filesystem::path(THERMOTWIN_SOURCE_DIR) / reader;
      if (!std::filesystem::is_directory(path)) {
        text += core::read_file(path);
        continue;
      }
      for (const auto& entry : std::filesystem::directory_iterator(path))
        if (entry.path().extension() == ".cpp" && !entry.path().stem().string().ends_with("_keys"))
          text += core::read_file(entry.path());
    }
    for (const core::KeyTable* table : tables_of(*page.keys)) {
      for (const core::Key& key : table->keys) {
        if (key.is_pattern() || key.name == "schema") continue;
        // Keys with the unit of an axis are put together from their first part.
        const std::string stem = key.name.substr(0, key.name.find('_'));
        EXPECT_TRUE(text.find("\"" + key.name + "\"") != std::string::npos ||
                    (table->name == "phase.axis" && text.find("key(\"" + stem + "\")") != std::string::npos))
            << table->name << " " << key.name << " is asked for by nobody";
      }
    }
  }
}

}  // namespace
}  // namespace thermotwin::compensation
