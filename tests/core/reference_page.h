// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A page of docs/reference that is made from the table of keys of a reader. THERMOTWIN_REFERENCE=docs/reference writes
// it anew. A source that includes this needs THERMOTWIN_SOURCE_DIR (tests/CMakeLists.txt).

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/file.h"
#include "core/key_reference.h"

namespace thermotwin::core {

/// @param name  of the page, without .md  @param program  the test program, for the message
inline void expect_reference_page(const std::string& name, const KeyTable& keys, const std::string& program) {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string test = std::string(info->test_suite_name()) + "." + info->name();
  const std::string text =
      "<!-- SPDX-License-Identifier: GPL-3.0-or-later -->\n<!-- Made from the reader's table of keys; the test " +
      test + " writes it. -->\n" + key_reference(keys);
  if (const char* folder = std::getenv("THERMOTWIN_REFERENCE"))
    write_file(std::filesystem::path(folder) / (name + ".md"), text);
  EXPECT_EQ(read_file(std::string(THERMOTWIN_SOURCE_DIR) + "/docs/reference/" + name + ".md"), text)
      << "write it anew: THERMOTWIN_REFERENCE=docs/reference build/tests/" << program << " --gtest_filter=" << test;
}

}  // namespace thermotwin::core
