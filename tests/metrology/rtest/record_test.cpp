// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/record.h"

#include <gtest/gtest.h>

#include "metrology/rtest/record_keys.h"
#include "tests/core/reference_page.h"

namespace thermotwin::metrology {
namespace {

TEST(RTestRecord, UsualErrorsOfTheAxesThatMove) {
  const mesh::KinematicChain chain = mesh::KinematicChain::parse("V [w C' B' b Y X Z t]", "test");
  const auto errors = [&](const std::vector<std::string>& moved) { return usual_errors(chain, moved); };
  using Names = std::vector<std::string>;
  EXPECT_EQ(errors({"C"}), (Names{"X0C", "Y0C", "Z0T", "A0C", "B0C", "C0C", "R0T"}));
  EXPECT_EQ(errors({"B"}), (Names{"X0B", "Y0T", "Z0B", "A0B", "B0B", "C0B"}));
  EXPECT_EQ(errors({"B", "C"}), (Names{"X0B", "Z0B", "A0B", "C0B", "X0C", "Y0C", "Z0T", "A0C", "B0C", "C0C", "R0T"}));
  const mesh::KinematicChain head = mesh::KinematicChain::parse("V [w b X Y Z C A t]", "test");
  EXPECT_EQ(usual_errors(head, {"C", "A"}),
            (Names{"X0C", "Y0C", "A0C", "B0C", "X0A", "Y0A", "Z0A", "A0A", "B0A", "C0A"}));
}

TEST(RTestRecord, ReferencePageIsThatOfTheReader) {
  core::expect_reference_page("rtest", record_keys(), "metrology_tests");
}

}  // namespace
}  // namespace thermotwin::metrology
