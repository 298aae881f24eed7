// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Results of `study tests` as tables and a page.

#include <optional>
#include <string>
#include <vector>

#include "study/tests/test_choice.h"
#include "study/tests/test_confirmation.h"
#include "tools/study/study.h"

namespace thermotwin::tools {

/// A chosen test, and the tests that it is compared with.
struct TestStudy {
  std::string machine;
  std::vector<study::UncertainParameter> parameters;
  double prior_um2 = 0;
  study::TestPath chosen, iso;
  std::vector<study::TestPath> random;  ///< orders
  std::size_t best_random = 0;
  double leave_um = 0;           ///< what the test may leave; 0: not stated
  double greedy_um2 = 0;         ///< left by the greedy order after its exchanges
  std::string start = "greedy";  ///< order that the chosen test was exchanged from: or "random_<number>", "iso_230_3"
  std::vector<std::string> left_out;  ///< load programs that set the surroundings' temperature
  std::vector<study::ConfirmedMachine> confirmed;
  /// Hours until so much is left; nothing where none is stated, or where the test leaves more.
  std::optional<double> hours_until(const study::TestPath& path) const {
    return leave_um > 0 ? path.hours_until(leave_um * leave_um) : std::nullopt;
  }
  const study::TestPath& best() const { return random[best_random]; }
  /// What the chosen test leaves below another, percent of the variance.
  double gain_percent(const study::TestPath& other) const { return 100.0 * (1.0 - chosen.end_um2() / other.end_um2()); }
};

/// The parameters whose variance a block lowers most, at most three.
std::string told_by(const TestStudy& study, std::size_t block);

std::vector<std::vector<std::string>> test_table(const TestStudy& study);
/// Standard deviations in percent before and after each test, the largest shares of the TCP's variance first.
std::vector<std::vector<std::string>> parameter_table(const TestStudy& study);
std::string test_sentence(const TestStudy& study);
std::string confirmed_sentence(const TestStudy& study);  ///< empty if none was measured

std::string tests_page(const StudyTestsOptions& options, const TestStudy& study);

}  // namespace thermotwin::tools
