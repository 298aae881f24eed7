// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "tests/machines/box_machine.h"

namespace thermotwin::diagnosis {
namespace {

long marked(const Scene& scene, const std::string& id, int number) {
  for (const Scene::Body& body : scene.bodies) {
    if (body.id == id) return std::count(body.marked.begin(), body.marked.end(), number);
  }
  ADD_FAILURE() << id;
  return 0;
}

// The guide and the column's foot share bed.top, which is larger than what they touch.
TEST(Scene, JointsOnOneMasterAreMarkedAtTheirSlavesEachInItsColour) {
  const mesh::MachineMesh mesh = test::box_machine_mesh();
  const Scene scene = make_scene(mesh, {make_parameter(Kind::contact_conductance, "X_guide"),
                                        make_parameter(Kind::contact_conductance, "column_foot")});
  EXPECT_EQ(marked(scene, "bed", 1) + marked(scene, "bed", 2), 0);
  EXPECT_GT(marked(scene, "slide", 1), 0);
  EXPECT_EQ(marked(scene, "slide", 2), 0);
  EXPECT_GT(marked(scene, "column", 2), 0);
  EXPECT_EQ(marked(scene, "column", 1), 0);
  ASSERT_EQ(scene.legend.size(), 2U);
  EXPECT_NE(scene.legend[0].colour, scene.legend[1].colour);
  const std::string page = scene_html(scene);
  for (const Scene::Entry& entry : scene.legend)
    EXPECT_NE(page.find("background:" + entry.colour + "\"></i>" + entry.words), std::string::npos) << entry.words;
}

TEST(Scene, SixCausesHaveSixColours) {
  std::vector<Parameter> causes;
  for (const char* joint : {"mounts", "X_guide", "C_bearing", "column_foot", "Z_guide"})
    causes.push_back(make_parameter(Kind::contact_conductance, joint));
  causes.push_back(make_parameter(Kind::heat_capacity, "head"));
  std::set<std::string> colours;
  for (const Scene::Entry& entry : make_scene(test::box_machine_mesh(), causes).legend) colours.insert(entry.colour);
  EXPECT_EQ(colours.size(), causes.size());
}

TEST(Scene, CausesOfLittleProbabilityAreNotMarked) {
  Diagnosis diagnosis;
  for (const double probability : {0.76, 0.05, 0.01}) {
    RankedCause cause;
    cause.parameter = make_parameter(Kind::contact_conductance, "X_guide");
    cause.probability = probability;
    diagnosis.ambiguous_set.push_back(cause);
  }
  EXPECT_EQ(marked_causes(diagnosis).size(), 2U);
}

}  // namespace
}  // namespace thermotwin::diagnosis
