// SPDX-License-Identifier: GPL-3.0-or-later
// A material that is wrong in all its bodies, on a machine that is measured on a finer mesh, with other parameters and
// noise.
#include <gtest/gtest.h>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/judge/diagnosis.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "tests/machines/meshed_boxes.h"

namespace {

using namespace thermotwin;
using diagnosis::Diagnosis;
using diagnosis::Kind;

compensation::Measurement measured(Kind kind, const std::string& where, double value) {
  const mesh::Machine machine = compensation::perturbed(
      diagnosis::with_parameter(meshed::machine(), diagnosis::make_parameter(kind, where), value), 13, 0.7);
  std::vector<mesh::Pose> poses;
  for (const char* pose : {"X=0,Z=0", "X=150,Z=80", "X=-150,Z=-80"})
    poses.push_back(mesh::parse_pose(machine, pose, "test"));
  return compensation::measure_virtually(meshed::full_model(machine, 2), meshed::load(machine, "shift", meshed::shift),
                                         poses,
                                         {.sensor_noise_K = 0.03, .probe_noise_um = 0.2, .seed = 13, .mesh_cache = {}});
}

double probability(const Diagnosis& d, Kind kind, const std::string& where) {
  for (const diagnosis::RankedCause& cause : d.ranking)
    if (cause.parameter.kind == kind && cause.parameter.where == where) return cause.probability;
  return 0.0;
}

TEST(DiagnoseMaterial, WhatIsWrongInAllItsBodiesIsOneCause) {
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(), measured(Kind::heat_capacity, "iron", 1.25), {});
  ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << d.sentence;
  ASSERT_EQ(d.causes.size(), 1U) << d.sentence;
  EXPECT_EQ(name_of(d.causes[0].parameter), "heat_capacity of iron") << d.sentence;
  EXPECT_NEAR(d.causes[0].value, 1.25, 0.06);
  ASSERT_FALSE(d.extended_machine_text.empty()) << d.sentence;
  const mesh::Machine extended = mesh::parse_machine(d.extended_machine_text, "boxes/machine.toml");
  EXPECT_EQ(extended.materials.size(), meshed::machine().materials.size()) << "no body has a copy";
  EXPECT_NE(d.actions.front().find("material iron (bed, "), std::string::npos) << d.actions.front();
}

/// What a coarse mesh bends differently may come as a second cause.
TEST(DiagnoseMaterial, ItsExpansionIsToldFromThatOfABody) {
  const Diagnosis all = diagnosis::diagnose(meshed::reduced(), measured(Kind::expansion_coefficient, "iron", 1.25), {});
  EXPECT_GT(probability(all, Kind::expansion_coefficient, "iron"), 0.95) << all.sentence;
  EXPECT_LT(probability(all, Kind::expansion_coefficient, "bed"), 0.05) << all.sentence;
  const Diagnosis one =
      diagnosis::diagnose(meshed::reduced(), measured(Kind::expansion_coefficient, "column", 1.4), {});
  EXPECT_GT(probability(one, Kind::expansion_coefficient, "column"), 0.9) << one.sentence;
  EXPECT_LT(probability(one, Kind::expansion_coefficient, "iron"), 0.05) << one.sentence;
}

}  // namespace
