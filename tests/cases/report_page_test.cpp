// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a diagnosis in a browser without a window: it draws, it turns, it complains of nothing.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "core/file.h"
#include "tests/cases/toy.h"

namespace {

using namespace thermotwin;
using cases::toy_run;

std::string browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    if (std::system((std::string("command -v ") + name + " >/dev/null 2>&1").c_str()) == 0) return name;
  return "";
}

struct Page {
  std::string document, log;
};

/// @param folder  for the browser's own files: other tests copy the run's while it writes
Page opened(const std::filesystem::path& file, const std::string& hash, const std::filesystem::path& folder) {
  const std::filesystem::path out = folder / "page.html", log = folder / "page.log", home = folder / "browser";
  const std::string command =
      browser() +
      " --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
      "--disable-component-update --disable-sync --enable-logging=stderr --user-data-dir='" +
      home.string() + "' --virtual-time-budget=5000 --dump-dom 'file://" + std::filesystem::absolute(file).string() +
      hash + "' >'" + out.string() + "' 2>'" + log.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  Page page{core::read_file(out), core::read_file(log)};
  std::filesystem::remove_all(home);
  return page;
}

std::string attribute(const std::string& document, const std::string& name) {
  std::smatch found;
  return std::regex_search(document, found, std::regex(name + "=\"([^\"]*)\"")) ? found[1].str() : "";
}

TEST(ReportPage, DrawsTheMachineAndTurnsIt) {
  const std::filesystem::path report = toy_run() / "diagnosis/report.html";
  EXPECT_LT(std::filesystem::file_size(report), 3U * 1024 * 1024);
  const std::string text = core::read_file(report);
  EXPECT_EQ(text.find("http://"), text.find("http://www.w3.org"));  // names of namespaces alone
  EXPECT_EQ(text.find("src="), std::string::npos);
  EXPECT_NE(text.find("source_power of spindle.bearings</span>"), std::string::npos);
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  const cases::Toy own;
  const Page still = opened(report, "", own.path()), turned = opened(report, "#turn", own.path());
  EXPECT_EQ(attribute(still.document, "data-drawn"), "1");
  EXPECT_EQ(attribute(turned.document, "data-drawn"), "2");
  EXPECT_NE(attribute(still.document, "data-angle"), attribute(turned.document, "data-angle"));
  for (const Page& page : {still, turned}) EXPECT_EQ(page.log.find(":CONSOLE"), std::string::npos) << page.log;
  EXPECT_GE(std::count(still.document.begin(), still.document.end(), '\n'), 50);
}

}  // namespace
