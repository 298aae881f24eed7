// SPDX-License-Identifier: GPL-3.0-or-later
// The command line itself: help, wrong words, what goes to which output.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>

#include "tests/cases/help.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

TEST(Usage, EveryVerbExplainsItselfWithAnExample) {
  const std::vector<std::string> all = verbs();
  for (const char* verb :
       {"run", "mesh", "simulate", "campaign", "reduce", "compensate", "evaluate", "diagnose", "export"})
    EXPECT_NE(std::find(all.begin(), all.end(), verb), all.end()) << verb;
  for (const std::string& verb : all) {
    const Result help = thermotwin({verb, "--help"});
    EXPECT_EQ(help.status, 0) << verb;
    EXPECT_EQ(help.err, "") << verb;
    const std::size_t example = help.out.find("Example:");
    ASSERT_NE(example, std::string::npos) << verb;
    EXPECT_NE(help.out.find("thermotwin " + verb + " ", example), std::string::npos) << verb;
    for (const char* option : {"--out", "--threads", "--quiet", "--json"}) EXPECT_SAYS(help.out, option) << verb;
  }
}

TEST(Usage, HelpOfAnUnknownVerbNamesTheNearestOne) {
  const Result result = thermotwin({"compensat", "--help"});
  EXPECT_EQ(result.status, 2);
  EXPECT_SAYS(result.err, "unknown verb 'compensat'");
  EXPECT_SAYS(result.err, "nearest: compensate");
}

TEST(Usage, VerbsAreListedInGroups) {
  const std::string help = thermotwin({"--help"}).out;
  std::size_t last = 0;
  for (const char* group : {"Machine:", "Compute:", "Measure:", "Control:"}) {
    const std::size_t at = help.find(std::string("\n") + group + "\n");
    ASSERT_NE(at, std::string::npos) << help;
    EXPECT_GT(at, last) << group;
    last = at;
  }
  EXPECT_EQ(verbs().front(), "mesh");
  EXPECT_EQ(verbs().back(), "offsets");
}

TEST(Usage, TheProgramStartsWithoutMesherRendererAndMultigrid) {
  FILE* listing = ::popen("ldd " THERMOTWIN_PROGRAM, "r");
  ASSERT_NE(listing, nullptr);
  std::string libraries;
  for (int c = std::fgetc(listing); c != EOF; c = std::fgetc(listing)) libraries += static_cast<char>(c);
  ASSERT_EQ(::pclose(listing), 0);
  EXPECT_SAYS(libraries, "libc.so");
  for (const char* library : {"libgmsh", "libTKernel", "libGL.", "libX11", "libvtkRendering", "libpetsc", "libmpi."})
    EXPECT_EQ(libraries.find(library), std::string::npos) << library;
}

TEST(Usage, HelpAndVersionAreNoErrors) {
  const Result help = thermotwin({"--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_SAYS(help.out, "130 interrupted");
  const Result version = thermotwin({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_TRUE(version.out.starts_with("thermotwin ")) << version.out;
}

TEST(Usage, WrongWordsGetTheNearestRightOne) {
  struct Wrong {
    std::vector<std::string> arguments;
    std::vector<std::string> said;
  };
  const std::string toy = toy_case().string();
  const std::vector<Wrong> all = {
      {{"simulat", toy}, {"'simulat'", "nearest: simulate"}},
      {{"run", toy, "--treads", "2"}, {"'--treads'", "nearest: --threads"}},
      {{"run", toy, "--threads", "two"}, {"--threads", "two", "0 to 1024"}},
      {{"run", toy, "--threads", "-1"}, {"--threads", "-1", "0 to 1024"}},
      {{"run"}, {"CASE"}},
      {{"simulate", toy}, {"--load"}},
      {{"mesh", toy, "more"}, {"more"}},
      {{"evaluate", toy}, {"--data"}},
      {{"export", toy}, {"--calculix"}},
      {{"reduce", toy, "--order", "abc"}, {"--order", "'abc'", "a whole number from 0 to 2000, or observer"}},
      {{"export", toy, "--calculix", "--steady-at", "60"}, {"--steady-at", "--load"}},
      {{"compensate", "model.rom.h5", "--json"}, {"--json", "--out FILE"}},
      {{"--treads"}, {"'--treads'"}},
      {{}, {"--help"}},
  };
  for (const Wrong& wrong : all) {
    const Result result = thermotwin(wrong.arguments);
    EXPECT_EQ(result.status, 2) << result.err;
    EXPECT_EQ(result.out, "");
    for (const std::string& words : wrong.said) EXPECT_SAYS(result.err, words);
  }
}

// A start in kelvin would be an offset at the guard's limit for hours.
TEST(Usage, AStartTemperatureInKelvinIsRefused) {
  const Toy toy;
  for (const std::string verb : {"compensate", "serve", "export"}) {
    const Result result = toy.run({verb, toy_model(), "--start-C", "293.15"});
    EXPECT_EQ(result.status, 2) << verb << ": " << result.err;
    EXPECT_SAYS(result.err, "293.15");
    EXPECT_SAYS(result.err, "100");
  }
}

TEST(Usage, ResultsGoToStdoutAndProgressToStderr) {
  const Toy toy;
  const std::vector<std::string> mesh{"mesh", toy.path()};
  const Result plain = toy.run(mesh);
  EXPECT_EQ(plain.status, 0);
  EXPECT_SAYS(plain.out, "x_slide");
  EXPECT_FALSE(nlohmann::json::accept(plain.out));

  const Result campaign = toy.run({"simulate", toy.path(), "--load", "ambient", "--quiet"});
  EXPECT_EQ(campaign.status, 0);
  EXPECT_EQ(campaign.err, "");
  EXPECT_SAYS(campaign.out, "dz_um");
}

// One object and nothing else, for every verb; where something went wrong, nothing at all.
TEST(Usage, JsonIsOneObjectOnStdout) {
  const Toy toy;
  toy.take_results();
  const std::string model = toy.result("model.rom.h5").string(), data = toy.result("measurement").string();
  std::vector<std::vector<std::string>> calls = {
      {"mesh", toy.path()},
      {"simulate", toy.path(), "--load", "ambient", "--pose", "X=20,B=30"},
      {"campaign", toy_case().string(), "--resume"},
      {"export", toy.path(), "--calculix", "--heat-only"},
      {"reduce", toy_case().string(), "--resume", "--order", "30"},
      {"evaluate", "--data", data},
      {"evaluate", toy_case().string(), "--data", data, "--model", model},
      {"diagnose", toy_case().string(), "--data", data, "--model", model},
      {"validate", toy_case().string(), "--model", model, "--draws", "1"},
  };
  for (auto& call : calls) {
    call.insert(call.end(), {"--json", "--quiet"});
    const Result result = toy.run(call);
    EXPECT_EQ(result.status, 0) << call.front() << ": " << result.err;
    EXPECT_EQ(result.err, "") << call.front();
    const auto json = nlohmann::json::parse(result.out, nullptr, false);
    EXPECT_TRUE(json.is_object()) << call.front() << ": " << result.out;
    EXPECT_GT(json.size(), 0U) << call.front();
  }
  const Result wrong = toy.run({"simulate", toy.path(), "--load", "nosuch", "--json"});
  EXPECT_EQ(wrong.status, 3);
  EXPECT_EQ(wrong.out, "");
  EXPECT_NE(wrong.err, "");
}

}  // namespace
}  // namespace thermotwin::cases
