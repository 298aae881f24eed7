// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/dialect/siemens_reader.h"

#include <gtest/gtest.h>

#include <sstream>

#include "core/error.h"

namespace thermotwin::nc {
namespace {

constexpr int five_axes = 0x37;  // X Y Z B C

class SiemensLanguage : public testing::Test {
protected:
  /// The program's lines in LinuxCNC's language.
  std::string translated(const std::string& program) {
    SiemensReader reader(control, five_axes, "part.mpf");
    std::istringstream lines(program);
    std::string text;
    std::size_t number = 0;
    for (std::string line; std::getline(lines, line);) text += reader.translate(line, ++number) + "\n";
    return text;
  }
  std::string message(const std::string& program) {
    try {
      translated(program);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }
  ControlProfile control;
};

TEST_F(SiemensLanguage, MotionStaysAndNumbersGo) {
  EXPECT_EQ(translated("%_N_PART_MPF\n;$PATH=/_N_WKS_DIR\nN10 G17 G90 G71\nN20 g0 X10Y-5.5 z+.25\nG33 Z-1 K2\n"),
            "\n\nG17 G21\nG0 X10 Y-5.5 Z0.25\nG33 K2 Z-1\n");
}

TEST_F(SiemensLanguage, AddressesWithAnEqualsSign) {
  EXPECT_EQ(translated("S1=3000 M1=3\nG2 X10 Y=5 CR=12.5 F=800\nG3 X0 Y0 I=AC(5) J=AC(0)\nG3 X1 I2 TURN=2\n"),
            "S3000 M3\nG2 R12.5 F800 X10 Y5\nG3 G90.1 I5 J0 X0 Y0\nG3 P3 G91.1 I2 X1\n");
}

TEST_F(SiemensLanguage, ParametersAreWorkedOut) {
  EXPECT_EQ(
      translated("R1=10 R2=R1*2+SIN(30)\nG1 X=R1 Y=-(R2 - 0.5)/4 F=R1 * 100\nX=SQRT(POT(3)+POT(4)) Y=ATAN2(1,1)\n"),
      "\nG1 F1000 X10 Y-5\nX5 Y45\n");
  EXPECT_NE(message("G1 X=R7\n").find("part.mpf:1: R7 without a value"), std::string::npos);
}

TEST_F(SiemensLanguage, SensesOfCoordinates) {
  EXPECT_EQ(translated("G1 X10 Y10 F100\nX=IC(5)\nX=IC(5) Y0\nG91 X1 Y=AC(3)\nG90 X0\n"),
            "G1 F100 X10 Y10\nG91 X5\nG90 X20 Y0\nG91 X1 Y3\nG90 X0\n");
  EXPECT_NE(message("G1 X=IC(5) Y2\n").find("from an unknown place"), std::string::npos);
}

TEST_F(SiemensLanguage, RotaryAxesTakeTheWayThatIsAsked) {
  EXPECT_EQ(translated("C350\nC=DC(10)\nC=ACN(300)\nC=ACP(10)\n"), "C350\nC370\nC300\nC370\n");
  EXPECT_NE(message("X=DC(10)\n").find("rotary axes"), std::string::npos);
}

TEST_F(SiemensLanguage, FramesAddAndEnd) {
  EXPECT_EQ(translated("TRANS X10 C30\nATRANS X5 Z=2*3\nTRANS Y1\nROT\nG54\nG507\nG500\n"),
            "G52 X10 Y0 Z0 B0 C30\nG52 X15 Y0 Z6 B0 C30\nG52 X0 Y1 Z0 B0 C0\nG52 X0 Y0 Z0 B0 C0\nG54\nG59.1\nG59.3\n");
  EXPECT_NE(message("ROT RPL=30\n").find("part.mpf:1: 'ROT'"), std::string::npos);
  control.work_offsets.push_back({9, Nine::Zero(), 0});
  EXPECT_NE(message("G500\n").find("work offset 9"), std::string::npos);
}

TEST_F(SiemensLanguage, UnitsScaleTheFrame) {
  EXPECT_EQ(translated("TRANS X25.4\nG70\nATRANS X1\n"), "G52 X25.4 Y0 Z0 B0 C0\nG20\nG52 X2 Y0 Z0 B0 C0\n");
}

// G70 and G71 are the unit of lengths alone, G700 and G710 that of F as well. LinuxCNC has one unit for both, takes F
// before the unit of its line, and keeps the speed of a feed that holds on.
TEST_F(SiemensLanguage, FeedsHaveTheUnitOfTheirWords) {
  EXPECT_EQ(translated("G710 G1 X1 F10\n"), "G21 G1 F10 X1\n");
  EXPECT_EQ(translated("G700 G1 X1 F10\n"), "G20 G1 F254 X1\n");
  EXPECT_EQ(translated("G70 G1 X1 F254\n"), "G20 G1 F254 X1\n");
  EXPECT_EQ(translated("G1 X1 F254\nG70\nX2\nG71\nX3\n"), "G1 F254 X1\nG20\nX2\nG21\nX3\n");
  EXPECT_EQ(translated("G93 G1 X1 F2\nG70 X2 F3\n"), "G93 G1 F2 X1\nG20 F3 X2\n") << "F of G93 has no unit of length";
}

// The first rotary word counts from the start position; a work offset turns the program's zero.
TEST_F(SiemensLanguage, RotaryAxesBeginWhereTheyStand) {
  EXPECT_EQ(translated("G1 C=ACN(350) F600\n"), "G1 F600 C-10\n");
  EXPECT_EQ(translated("C=DC(350)\nG55\nC=ACP(10)\n"), "C-10\nG55\nC10\n");
  Nine turned = Nine::Zero();
  turned[5] = 3.14159265358979;
  control.work_offsets.push_back({2, turned, 0});
  EXPECT_EQ(translated("G0 C30\nG55\nC=DC(0)\nC=DC(200)\n"), "G0 C30\nG55\nC0\nC-160\n");
}

TEST_F(SiemensLanguage, StatementsWithoutAnEffectVanish) {
  EXPECT_EQ(translated("EXTERN POCKET(REAL, INT)\nCYCLE800()\nL1: G1 X1\nMARKE_2: X2\nG25 S100\nG26 X100 Z50\n"
                       "FGROUP()\nFGROUP(X, Y, Z) X3\nR3=7 MOD 4 R4=7 DIV 4\nX=R3 Y=R4\n"),
            "\n\nG1 X1\nX2\n\n\n\nX3\n\nX3 Y1\n");
  EXPECT_NE(message("FGROUP(Z)\n").find("FGROUP(X, Y, Z)"), std::string::npos);
}

TEST_F(SiemensLanguage, ToolLengthsHoldFromTheChange) {
  control.tools.push_back({});
  control.tools.back().number = 7;
  control.tools.back().name = "Mill_D10";
  EXPECT_EQ(translated("T=\"MILL_D10\" D1\nM6\nSUPA G0 Z0 D0\nD1\nT0 M6\n"),
            "T7\nM6 G43\nG0 G49 G53 Z0\nG43\nT0 M6 G49\n");
  EXPECT_NE(message("T=\"DRILL\"\n").find("Mill_D10"), std::string::npos);
  EXPECT_NE(message("T7 M6\nSUPA G0 Z0\n").find("part.mpf:2: machine coordinates with a tool length"),
            std::string::npos);
  EXPECT_NE(message("D2\n").find("D0 or D1"), std::string::npos);
}

TEST_F(SiemensLanguage, DwellsAreSecondsOrRevolutions) {
  EXPECT_EQ(translated("S600 M3\nG4 F2.5\nG4 S30\n"), "S600 M3\nG4 P2.5\nG4 P3\n");
  EXPECT_NE(message("G4 S30\n").find("behind a spindle speed"), std::string::npos);
}

TEST_F(SiemensLanguage, PathModes) {
  EXPECT_EQ(translated("G60\nG641 ADIS=0.05\nADIS=0.1\nG9 X1\nX2\nG642\n"),
            "G61.1\nG64 P0.05\nG64 P0.1\nG61.1 X1\nG64 P0.1 X2\nG64\n");
}

TEST_F(SiemensLanguage, TransformationsAreMarkers) {
  EXPECT_EQ(translated("TRAORI\nORIWKS ORIAXES\nTRAFOOF\n"), "(thermotwin:tcp on)\n\n(thermotwin:tcp off)\n");
  EXPECT_NE(message("TRAORI(2)\n").find("TRAORI(1)"), std::string::npos);
}

TEST_F(SiemensLanguage, CommentsTextsAndLabelsVanish) {
  EXPECT_EQ(translated("MSG(\"a ) ; text\") G1 X1 ; Y2\nSTART: X2\n/1 X3\nFFWON SOFT COMPCAD\n:20 M30\n"),
            "G1 X1\nX2\n/X3\n\nM30\n");
}

TEST_F(SiemensLanguage, WhatIsNotReadIsNamedWithItsLine) {
  for (const char* statement : {"GOTOF END", "IF R1==2", "CYCLE81(1,2)", "A3=0.5 B3=0", "CIP X1 I1=2", "G111 X1", "L6",
                                "POCKET", "M2=3", "G58", "$AA_IM[X]", "RND=2", "G1 X1)", "X=5+", "X=1/0", "FB=3"})
    EXPECT_NE(message(std::string("G1\n") + statement + "\n").find("part.mpf:2:"), std::string::npos) << statement;
}

TEST_F(SiemensLanguage, TheProfileComesFirst) {
  WordRule skip, by, refused;
  skip.name = "CYCLE81";
  by.name = "TC";
  by.by = "M6";
  by.action = WordRule::Action::replace;
  refused.name = "MSG";
  refused.action = WordRule::Action::refuse;
  control.words = {skip, by, refused};
  EXPECT_EQ(translated("CYCLE81(1,2) X1\nTC(3)\n"), "X1\nM6\n");
  EXPECT_NE(message("MSG(\"a\")\n"), "");
}

}  // namespace
}  // namespace thermotwin::nc
