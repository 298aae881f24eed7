// SPDX-License-Identifier: GPL-3.0-or-later
// Effects of no kind, on a machine that is measured on a finer mesh, with other parameters and noise: whatever fits
// best, no name of it is sure.
#include <gtest/gtest.h>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/judge/decision.h"
#include "diagnosis/judge/diagnosis.h"
#include "mesh/machine/kinematics.h"
#include "tests/machines/meshed_boxes.h"

namespace {

using namespace thermotwin;
using diagnosis::Diagnosis;
using diagnosis::Kind;

compensation::Measurement measured(const std::string& machine_text, std::uint64_t seed) {
  const mesh::Machine machine =
      compensation::perturbed(mesh::parse_machine(machine_text, "boxes/machine.toml"), seed, 0.7);
  std::vector<mesh::Pose> poses;
  for (const char* pose : {"X=0,Z=0", "X=150,Z=80", "X=-150,Z=-80"})
    poses.push_back(mesh::parse_pose(machine, pose, "test"));
  return compensation::measure_virtually(
      meshed::full_model(machine, 2), meshed::load(machine, "shift", meshed::shift), poses,
      {.sensor_noise_K = 0.03, .probe_noise_um = 0.2, .seed = seed, .mesh_cache = {}});
}

void expect_nothing_sure(const Diagnosis& d) {
  SCOPED_TRACE(d.sentence);
  EXPECT_TRUE(d.verdict == diagnosis::Verdict::ambiguous || d.verdict == diagnosis::Verdict::unexplained);
  EXPECT_EQ(d.ranking.front().parameter.kind, Kind::unknown);
  for (const diagnosis::RankedCause& cause : d.ranking) {
    if (!cause.parameter.name.empty()) {
      EXPECT_LT(cause.probability, diagnosis::sure) << name_of(cause.parameter);
    }
  }
  ASSERT_FALSE(d.actions.empty());
  EXPECT_NE(d.actions.front().find("no known kind of cause explains it"), std::string::npos) << d.actions.front();
}

/// Cast iron at 46 W/mK, and something that hardly conducts.
TEST(DiagnoseOutside, AConductivityIsNoCapacityForSure) {
  std::string text = meshed::replaced(meshed::machine_text(), "id = \"head\"\nmaterial = \"iron\"\n",
                                      "id = \"head\"\nmaterial = \"other\"\n");
  text = meshed::replaced(text, "[[body]]\nid = \"bed\"",
                          "[[material]]\nid = \"other\"\ndensity_kg_m3 = 7200\nspecific_heat_J_kgK = 500\n"
                          "conductivity_W_mK = 12\nexpansion_1_K = 11e-6\nyoung_GPa = 120\npoisson = 0.26\n"
                          "[[body]]\nid = \"bed\"");
  expect_nothing_sure(diagnosis::diagnose(meshed::reduced(), measured(text, 13), {}));
}

/// All displacements in one direction jump at 4 h and half back at 8 h.
TEST(DiagnoseOutside, AToolThatSlipsIsNoScaleForSure) {
  compensation::Measurement slipped = measured(meshed::machine_text(), 14);
  for (const compensation::MeasuredChannel& channel : slipped.channels) {
    if (channel.quantity != "dz") continue;
    for (Eigen::Index i = 0; i < slipped.data.values.rows(); ++i) {
      const double hour = slipped.data.values(i, 0) / 3600.0;
      slipped.data.values(i, channel.column) += hour > 8.0 ? 6.0 : hour > 4.0 ? 12.0 : 0.0;
    }
  }
  expect_nothing_sure(diagnosis::diagnose(meshed::reduced(), slipped, {}));
}

}  // namespace
