// SPDX-License-Identifier: GPL-3.0-or-later
// docs/reference/study.md is made from the table of keys; THERMOTWIN_REFERENCE=docs/reference writes it anew.
#include "study/plan/plan_keys.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "core/file.h"
#include "core/key_reference.h"

namespace thermotwin::study {
namespace {

TEST(StudyPlanKeys, AreTheReferencePage) {
  const std::string text =
      "<!-- SPDX-License-Identifier: GPL-3.0-or-later -->\n<!-- Made from the reader's table of keys; the test "
      "StudyPlanKeys writes it. -->\n" +
      core::key_reference(variant_plan_keys());
  if (const char* folder = std::getenv("THERMOTWIN_REFERENCE"))
    core::write_file(std::filesystem::path(folder) / "study.md", text);
  EXPECT_EQ(core::read_file(std::string(THERMOTWIN_SOURCE_DIR) + "/docs/reference/study.md"), text)
      << "write it anew: THERMOTWIN_REFERENCE=docs/reference build/tests/study_tests --gtest_filter=StudyPlanKeys.*";
}

}  // namespace
}  // namespace thermotwin::study
