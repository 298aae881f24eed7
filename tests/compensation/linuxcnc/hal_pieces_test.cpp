// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/linuxcnc/hal_pieces.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "compensation/control/control_model.h"
#include "core/error.h"
#include "tests/compensation/control/twin_of_lumps.h"
#include "tests/compensation/linuxcnc/mill.h"

namespace thermotwin::compensation {
namespace {

const ControlModel& lumps() {
  static const ControlModel model(test::lumps_with_lines());
  return model;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(HalPieces, JoinSignalsThatAreThereAndMakeTheOthers) {
  const test::Mill mill;
  const HalPieces pieces = hal_pieces(read_hal_config(mill.ini(), mill.library()), lumps().data(), "/twin");
  EXPECT_TRUE(has(pieces.hal, "net X-here => thermotwin.axis.X.position_mm\n")) << pieces.hal;
  EXPECT_TRUE(has(pieces.hal, "net speed => thermotwin.spindle.speed_rpm\n")) << pieces.hal;
  EXPECT_TRUE(has(pieces.hal, "net is-on => thermotwin-guard.machine-is-on\n")) << pieces.hal;
  EXPECT_TRUE(has(pieces.hal, "net thermotwin-joint-1-pos-cmd joint.1.pos-cmd => thermotwin.axis.Y.position_mm\n"));
  EXPECT_TRUE(has(pieces.hal, "net thermotwin-joint-1-pos-cmd => thermotwin-guard.position-")) << "one link a pin";
  EXPECT_TRUE(has(pieces.hal, "addf thermotwin-guard fast-thread\n"));
  EXPECT_TRUE(has(pieces.hal, fmt::format("setp axis.x.eoffset-scale {:g}\n", 1e-6 / 25.4))) << "machine in inch";
  EXPECT_TRUE(has(pieces.hal, "setp thermotwin-guard.um-per-unit 25400\n"));
  EXPECT_FALSE(has(pieces.hal, "feed")) << "feeds follow from positions";
  EXPECT_TRUE(has(pieces.ini, "[AXIS_X]")) << "its offsets need a share of velocity";
  EXPECT_FALSE(has(pieces.ini, "[AXIS_Z]")) << "it has one";
  EXPECT_TRUE(has(pieces.ini, "FOLDER = /twin\n"));
}

TEST(HalPieces, AreRefusedWhereTheyWouldNotFit) {
  const auto refused = [](const std::string& from, const std::string& to, const std::string& hal,
                          const std::string& named) {
    test::Mill mill(from, to);
    if (!hal.empty()) mill.write("mill.hal", hal);
    try {
      hal_pieces(read_hal_config(mill.ini(), mill.library()), lumps().data(), "/twin");
      ADD_FAILURE() << named << " was taken";
    } catch (const core::InputError& error) {
      EXPECT_TRUE(has(error.what(), named)) << error.what();
    }
  };
  refused("trivkins", "xyzbc-trt-kins", "", "trivkins: external offsets act before");
  refused("coordinates=XYYZ", "coordinates=XY", "", "no axis Z");
  refused("", "", "net other mux.out => axis.x.eoffset-counts\n",
          "mill.hal:1: axis.x.eoffset-counts is linked to other");
  refused("", "", "loadrt abs names=thermotwin-guard\n", "a component is named thermotwin-guard");
}

TEST(HalPieces, ANameBreaksNoLine) {
  const test::Mill mill;
  ControlData named = lumps().data();
  named.name = "mill\nloadrt evil";
  const HalConfig config = read_hal_config(mill.ini(), mill.library());
  EXPECT_FALSE(has(hal_pieces(config, named, "/twin").hal, "\nloadrt evil"));
  EXPECT_THROW(hal_pieces(config, lumps().data(), "/twin\nHALCMD = evil"), core::InputError);
}

/// The model process of an exported folder, killed and cut off, beside a twin that never stops.
class ModelProcess : public ::testing::Test {
protected:
  struct Figures {
    double apart = 1e9, offset_um = 0, fastest = 1e9, longest_s = 1e9;
    long answers = 0;
  };
  static std::string run(const std::string& command) {
    std::string text;
    FILE* pipe = popen(command.c_str(), "r");
    std::array<char, 4096> part{};
    for (std::size_t count = 0; (count = fread(part.data(), 1, part.size(), pipe)) > 0;)
      text.append(part.data(), count);
    return pclose(pipe) == 0 ? text : "failed: " + text;
  }
  static const std::string& folder() {
    static const test::Scratch scratch;
    static const std::string built = [] {
      const std::filesystem::path path = scratch.path();
      write_linuxcnc(path, lumps().data(), lumps().model(), HalPieces{});
      const std::string cc = "cc -std=c99 -O2 -ffp-contract=off -Wall -Wextra -Werror -Icore -I. ";
      const std::string said = run(fmt::format(
          "cd {0} && rm core/main.c && {1} -c core/*.c && {1} thermotwin_model.c *.o -o thermotwin_model -lm 2>&1 && "
          "for program in drive send_rows; do {1} {2}/tests/compensation/linuxcnc/$program.c model_link.c "
          "process_link.c *.o -o $program -lm 2>&1; done",
          path.string(), cc, THERMOTWIN_SOURCE_DIR));
      EXPECT_EQ(said, "");
      return path.string();
    }();
    return built;
  }
  /// Answers of send_rows and the lines of the model. @param groups  as send_rows takes them
  static std::string rows(const std::string& state, int session, const std::string& groups,
                          const std::string& before = "") {
    return run(fmt::format("cd {} && {} ./send_rows ./thermotwin_model {}.state {} {} 2>&1", folder(), before, state,
                           session, groups));
  }
  /// Makes the saved states those of another model.
  static void exchange_model(const std::string& state) {
    for (const char* end : {"", ".old", ".live"}) {
      const std::string path = fmt::format("{}/{}.state{}", folder(), state, end);
      if (!std::filesystem::exists(path)) continue;
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      constexpr long hash_at = 32;  // after session, time, magic and version
      file.seekg(hash_at);
      const int byte = file.get();
      file.seekp(hash_at);
      file.put(static_cast<char>(byte ^ 1));
    }
  }
  static Figures drive(const std::string& what, int count, int seed) {
    Figures figures;
    const std::string state = fmt::format("{}/{}.state", folder(), what);
    std::istringstream said(run(fmt::format("cd {0} && ./drive ./thermotwin_model {1} {2} {3} {4} 2>{2}.log", folder(),
                                            state, what, count, seed)));
    said >> figures.apart >> figures.offset_um >> figures.fastest >> figures.longest_s >> figures.answers;
    return figures;
  }
};

TEST_F(ModelProcess, GoesOnAfterAHundredKills) {
  const Figures figures = drive("kills", 100, 5);
  EXPECT_GT(figures.answers, 500);
  EXPECT_GT(figures.offset_um, 1.0) << "nothing to lose";
  // A second of machine time may be lost, during which the last row holds; a step takes effect as much later.
  EXPECT_LT(figures.apart, 0.1) << figures.apart;
  EXPECT_GT(figures.fastest, 0.1);
  EXPECT_LT(figures.fastest, 1.001) << "over the set rate";
  EXPECT_LT(figures.longest_s, 2.0);
}

TEST_F(ModelProcess, GoesOnAfterTwentyPowerCuts) {
  const Figures figures = drive("cuts", 20, 6);
  EXPECT_GT(figures.answers, 15000);
  EXPECT_GT(figures.offset_um, 1.0);
  // Up to 20 s of machine time are lost before the hour in which the machine is off.
  EXPECT_LT(figures.apart, 0.2);
  EXPECT_LT(figures.fastest, 1.001) << "over the set rate";
  EXPECT_LT(figures.longest_s, 2.0);
}

TEST_F(ModelProcess, KeepsTheStateOfAnotherModel) {
  EXPECT_EQ(rows("foreign", 1, "1000000:6000:60").find("refused"), std::string::npos);
  exchange_model("foreign");
  const std::filesystem::path state = std::filesystem::path(folder()) / "foreign.state";
  const std::string foreign = core::read_file(state);
  // Long enough for three saves, which write over STATE.old.
  const std::string said = rows("foreign", 1, "1000061:6000:1 1000062:6000:40");
  for (const char* words : {"foreign.state: of another model", "foreign.state.refused: keeps the refused state", " 1 "})
    EXPECT_TRUE(has(said, words)) << words << said;
  EXPECT_EQ(core::read_file(state.string() + ".refused"), foreign);
  EXPECT_NE(core::read_file(state), foreign);
  // A second one does not take the place of the first.
  exchange_model("foreign");
  const std::string second = core::read_file(state);
  rows("foreign", 1, "1000110:6000:30");
  EXPECT_EQ(core::read_file(state.string() + ".refused"), foreign);
  EXPECT_EQ(core::read_file(state.string() + ".refused.1"), second);
  EXPECT_FALSE(has(rows("foreign", 1, "1000150:6000:1"), "refused")) << "its own state is there again";
}

TEST_F(ModelProcess, AClockThatWasSetIsAFaultAndEndsNothing) {
  const auto fault = [](const std::string& said) {
    int status = -9;
    unsigned bits = 99;
    const std::size_t answer = said.rfind('\n', said.size() - 2);
    std::sscanf(said.c_str() + (answer == std::string::npos ? 0 : answer + 1), "%d %u", &status, &bits);
    return bits;
  };
  EXPECT_EQ(fault(rows("clock", 1, "1000000:6000:60")), 0U);
  const std::string back = rows("clock", 2, "900000:6000:60");
  EXPECT_EQ(fault(back), 4U) << back;
  EXPECT_TRUE(has(back, "clock: is behind the saved state; time goes on from there")) << back;
  const std::string ahead = rows("clock", 3, fmt::format("{}:6000:60", 1000000 + 40 * 86400));
  EXPECT_EQ(fault(ahead), 8U) << ahead;
  EXPECT_TRUE(has(ahead, "more than 7 days after the saved state; the start is cold")) << ahead;
  // Within a session no clock leaps; a row that does is not used.
  const std::string within = rows("clock_within", 1, "1000000:6000:60 5000000:6000:1 1000061:6000:1");
  EXPECT_TRUE(has(within, "\n-1 0 ")) << within;
  EXPECT_TRUE(has(within, "row at 5000000.000 s: time does not rise, or leaps")) << within;
  EXPECT_FALSE(has(within, "has ended")) << within;
}

TEST_F(ModelProcess, AFullDiskIsAFaultUntilThereIsRoom) {
  const std::string full = rows("full", 1, "1000000:6000:40", "trap '' XFSZ; ulimit -f 0;");
  EXPECT_TRUE(has(full, " 2 ")) << full;
  EXPECT_TRUE(has(full, "File too large")) << full;
  EXPECT_FALSE(has(full, "has ended")) << full;
  EXPECT_EQ(full.find("File too large"), full.rfind("File too large")) << "said once";
  const std::string room = rows("full", 1, "1000041:6000:40");
  EXPECT_TRUE(has(room, " 0 ")) << room;
}

TEST_F(ModelProcess, APinOfNanIsNotGivenAndOneOfInfinityIsNamed) {
  // Unlike nan, infinity is no value that is missing on purpose.
  const std::string said = rows("pins", 1, "1000000:6000:60 1000060:nan:200 1000260:nan:140 1000400:inf:1");
  std::istringstream lines(said);
  std::vector<int> statuses;
  for (std::string line; std::getline(lines, line);) {
    int status = 0;
    if (std::sscanf(line.c_str(), "%d ", &status) == 1) statuses.push_back(status);
  }
  ASSERT_EQ(statuses.size(), 4U) << said;
  EXPECT_NE(statuses[1], TT_INPUT_MISSING) << said;
  EXPECT_EQ(statuses[2], TT_INPUT_MISSING) << said;
  EXPECT_EQ(statuses[3], TT_INPUT_MISSING) << said;
  EXPECT_TRUE(has(said, "status input_missing spindle.speed_rpm=missing")) << said;
  const std::string infinite = rows("infinite", 1, "1000000:6000:60 1000070:inf:1");
  EXPECT_TRUE(has(infinite, "status input_missing spindle.speed_rpm=unreadable")) << infinite;
}

TEST_F(ModelProcess, OfAStateThatIsTakenIsRefused) {
  const std::string said =
      run(fmt::format("cd {} && (sleep 2 | ./thermotwin_model two.state) & sleep 0.5; cd {} && ./thermotwin_model "
                      "two.state </dev/null 2>&1; "
                      "echo status $?",
                      folder(), folder()));
  EXPECT_TRUE(has(said, "another model goes on from this state")) << said;
  EXPECT_TRUE(has(said, "status 3")) << said;
}

}  // namespace
}  // namespace thermotwin::compensation
