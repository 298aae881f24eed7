// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/linuxcnc/hal_pieces.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <sstream>

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
          "{1} {2}/tests/compensation/linuxcnc/drive.c model_link.c process_link.c *.o -o drive -lm 2>&1",
          path.string(), cc, THERMOTWIN_SOURCE_DIR));
      EXPECT_EQ(said, "");
      return path.string();
    }();
    return built;
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
