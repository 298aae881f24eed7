// SPDX-License-Identifier: GPL-3.0-or-later
// The pages that verbs leave, in a browser without a window: they draw, they turn, choices change the picture, they
// complain of nothing and ask for nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/file.h"
#include "tests/cases/browser.h"
#include "tests/cases/toy.h"

namespace {

using namespace thermotwin;
using cases::browser;
using cases::opened;
using cases::Page;
using cases::toy_run;

TEST(ReportPage, DrawsTheMachineAndTurnsIt) {
  const std::filesystem::path report = toy_run() / "diagnosis/report.html";
  cases::expect_self_contained(report);
  EXPECT_NE(core::read_file(report).find("source_power of spindle.bearings</span>"), std::string::npos);
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  const cases::Toy own;
  const Page still = opened(report, "", own.path()), turned = opened(report, "#turn", own.path());
  EXPECT_EQ(still.attribute("data-drawn"), "1");
  EXPECT_EQ(turned.attribute("data-drawn"), "2");
  EXPECT_NE(still.attribute("data-angle"), turned.attribute("data-angle"));
  for (const Page& page : {still, turned}) cases::expect_quiet(page);
  EXPECT_EQ(still.attribute("data-covered"), "0");  // no label lies on another
  EXPECT_GE(std::count(still.document.begin(), still.document.end(), '\n'), 50);
  cases::expect_turns_and_zooms(report, "machine", own.path());
}

/// Pictures of the machine and of its error over time under several views; all have to differ.
void expect_choices_change_the_picture(const std::filesystem::path& report) {
  cases::expect_self_contained(report);
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  const cases::Toy own;
  std::set<std::string> machines, charts;
  const char* const views[] = {"#load=0&pose=13&time=1", "#load=0&pose=13&time=0.5", "#load=1&pose=13&time=1",
                               "#load=0&pose=0&time=1", "#load=0&pose=13&time=1&turn=0.6"};
  for (const char* view : views) {
    const Page page = opened(report, view, own.path());
    cases::expect_quiet(page);
    EXPECT_NE(page.attribute_of("machine", "data-picture"), "");
    machines.insert(page.attribute_of("machine", "data-picture"));
    charts.insert(page.attribute_of("scene-chart", "data-picture"));
  }
  EXPECT_EQ(machines.size(), std::size(views));
  EXPECT_EQ(charts.size(), std::size(views) - 1);  // a turn leaves the chart
  const Page again = opened(report, views[0], own.path());
  EXPECT_TRUE(machines.contains(again.attribute_of("machine", "data-picture")));
  cases::expect_turns_and_zooms(report, "machine", own.path());
}

TEST(ReportPage, OfRunShowsLoadsPosesAndTimes) {
  expect_choices_change_the_picture(toy_run() / "report.html");
  const std::string text = core::read_file(toy_run() / "report.html");
  EXPECT_NE(text.find("diagnosis/report.html"), std::string::npos);
  EXPECT_NE(text.find("What to do next"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(toy_run() / "scene.bin"));
}

TEST(ReportPage, OfCampaignShowsFieldsOfTheFullModel) {
  const cases::Toy toy;
  const cases::Result result = toy.run({"campaign", toy.path(), "--load", "ambient", "warm_up"});
  ASSERT_EQ(result.status, 0) << result.err;
  expect_choices_change_the_picture(toy.result("campaign/report.html"));
}

TEST(ReportPage, OfReducedCampaignTakesItsFieldsFromBesideTheModel) {
  const cases::Toy toy;
  const cases::Result result =
      toy.run({"campaign", toy.path(), "--reduced", "--model", (toy_run() / "model.rom.h5").string()});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto page = toy.result("campaign_reduced/report.html");
  expect_choices_change_the_picture(page);
  EXPECT_EQ(core::read_file(page).find("\"coefficients\":null"), std::string::npos);
}

TEST(ReportPage, OfAModelAloneShowsArrows) {
  const cases::Toy toy;
  std::filesystem::create_directories(toy.out());
  std::filesystem::copy_file(toy_run() / "model.rom.h5", toy.result("model.rom.h5"));
  const cases::Result result = toy.run({"campaign", toy.path(), "--reduced", "--load", "mixed"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto report = toy.result("campaign_reduced/report.html");
  cases::expect_self_contained(report);
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  const Page page = opened(report, "", toy.path());
  cases::expect_quiet(page);
  EXPECT_EQ(page.attribute_of("machine", "data-drawn"), "1");
}

TEST(ReportPage, OfValidateShowsMachinesAndTheirErrorsOverTime) {
  const cases::Toy toy;
  for (const char* study : {"--power-off", "--failed-sensors", ""}) {
    std::vector<std::string> arguments{"validate", toy.path(),
                                       "--model",  (toy_run() / "model.rom.h5").string(),
                                       "--truth",  (toy_run() / "reference.rom.h5").string(),
                                       "--draws",  "3"};
    if (*study != 0) arguments.emplace_back(study);
    const cases::Result result = toy.run(arguments);
    ASSERT_EQ(result.status, 0) << result.err;
    const auto report = toy.result("validation/report.html");
    cases::expect_self_contained(report);
    if (browser().empty()) continue;
    cases::expect_quiet(opened(report, "", toy.path()));
  }
  const std::string text = core::read_file(toy.result("validation/report.html"));
  EXPECT_NE(text.find("class=\"area band\""), std::string::npos);
  EXPECT_NE(text.find("10th percentile"), std::string::npos);
}

TEST(ReportPage, OfEvaluateShowsALeaderboardAndChannels) {
  const cases::Toy toy;
  const cases::Result result = toy.run({"evaluate", toy.path(), "--data", (toy_run() / "measurement").string(),
                                        "--model", (toy_run() / "model.rom.h5").string()});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto report = toy.result("evaluation/report.html");
  cases::expect_self_contained(report);
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  const Page page = opened(report, "", toy.path());
  cases::expect_quiet(page);
  EXPECT_NE(page.document.find("hidden=\"\""), std::string::npos);  // one channel shows, others wait to be chosen
}

// A page that cannot be written is no reason to lose the verb's results.
TEST(ReportPage, ThatCannotBeWrittenLeavesTheVerbItsResults) {
  const cases::Toy toy;
  std::filesystem::create_directories(toy.result("campaign/report.html/taken"));
  const cases::Result result = toy.run({"campaign", toy.path(), "--load", "ambient"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "report.html is left out");
  EXPECT_TRUE(std::filesystem::exists(toy.result("campaign/ambient/tcp.csv")));
}

}  // namespace
