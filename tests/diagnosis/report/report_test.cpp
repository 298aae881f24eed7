// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/report.h"

#include <gtest/gtest.h>

#include "tests/diagnosis/diagnosed_rods.h"

namespace thermotwin::diagnosis {
namespace {

std::string page_of(const Diagnosis& d) {
  const mesh::Machine machine = lumped::machine();
  return report_html(d, &machine, {});
}

/// From a heading of the page to the next one.
std::string section(const std::string& page, const std::string& heading) {
  const std::size_t begin = page.find("<h2>" + heading + "</h2>");
  if (begin == std::string::npos) return "";
  return page.substr(begin, page.find("<h2>", begin + 1) - begin);
}

const Diagnosis& diagnosed() {
  static const Diagnosis d =
      lumped::run(lumped::measure({{lumped::find(Kind::source_power, "motor"), 1.6}}, {.seed = 21}));
  return d;
}

TEST(Report, ANegativeGainIsRed) {
  Diagnosis d = diagnosed();
  const std::string red = "<span class=\"bad\">";
  EXPECT_EQ(page_of(d).find(red), std::string::npos) << d.reduction_percent;
  d.reduction_percent = -12.0;
  const std::string page = page_of(d);
  EXPECT_NE(page.find(red + "-12"), std::string::npos);
  EXPECT_NE(page.find(".bad { color:#b3261e"), std::string::npos);
}

TEST(Report, SaysWhatToDoIfOnlyOneThingCanBeDone) {
  Diagnosis d = diagnosed();
  d.next = {"spindle_6000", "T4_reading", "two causes differ by 3 K there", 2.5, {"With more heat it rises by 4 K"}};
  const std::string next = section(page_of(d), "Next measurement");
  EXPECT_NE(next.find("If you can only do one thing, measure <strong>T4_reading</strong> under"), std::string::npos)
      << next;
  EXPECT_NE(next.find("for 2.5 h"), std::string::npos) << next;
  EXPECT_NE(next.find("With more heat it rises by 4 K"), std::string::npos) << next;
  d.next = {
      .load = {}, .channel = {}, .why = "every program of the case shows the same", .duration_h = 0, .outcomes = {}};
  EXPECT_EQ(page_of(d).find("If you can only do one thing"), std::string::npos);
}

TEST(Report, ListsTheSmallestChangeOfEachKindThatTheRecordCanShow) {
  ASSERT_GT(diagnosed().detectable.size(), 3U);
  const std::string shown = section(page_of(diagnosed()), "What the record can show");
  ASSERT_FALSE(shown.empty());
  std::size_t rows = 0;
  for (std::size_t at = shown.find("<tr"); at != std::string::npos; at = shown.find("<tr", at + 1)) ++rows;
  EXPECT_EQ(rows, 1 + diagnosed().detectable.size()) << shown;
}

}  // namespace
}  // namespace thermotwin::diagnosis
