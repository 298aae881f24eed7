// SPDX-License-Identifier: GPL-3.0-or-later
// docs/reference/study.md is made from the table of keys.
#include "study/plan/plan_keys.h"

#include <gtest/gtest.h>

#include "tests/core/reference_page.h"

namespace thermotwin::study {
namespace {

TEST(StudyPlanKeys, AreTheReferencePage) { core::expect_reference_page("study", variant_plan_keys(), "study_tests"); }

}  // namespace
}  // namespace thermotwin::study
