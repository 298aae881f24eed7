// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/place.h"

#include <gtest/gtest.h>

#include "tests/diagnosis/judge/boxed_column.h"

namespace {

using namespace thermotwin;

TEST(Place, IsSaidAsAFitterWouldSayIt) {
  const reduction::ReducedModel model = diagnosis::boxed_column();
  EXPECT_EQ(diagnosis::place_in_words("column", {-0.2, 0.1, 0.8}, model),
            "the top left rear of column, 800 mm above the table, near sensor T3");
  EXPECT_EQ(diagnosis::place_in_words("column", {0.0, -0.1, 0.5}, model),
            "the front of column, 500 mm above the table, near sensor T2");
  EXPECT_EQ(diagnosis::place_in_words("column", {0.2, 0.0, -0.5}, model),
            "the bottom right of column, 500 mm below the table");
}

mesh::SurfaceSpec surface(const std::string& id, const mesh::Rule& rule) {
  mesh::SurfaceSpec spec;
  spec.id = id;
  spec.body = "column";
  spec.any_of = {rule};
  return spec;
}

TEST(Place, NamesTheNearestSurfaceOfTheBody) {
  reduction::ReducedModel model = diagnosis::boxed_column();
  const Eigen::Vector3d inside(0.12, 0.02, 0.9);
  EXPECT_EQ(diagnosis::place_of("column", inside, model).surface, "") << "it has none";
  EXPECT_EQ(diagnosis::place_of("column", inside, model).on_skin, Eigen::Vector3d(0.2, 0.1, 1.0));
  mesh::Rule window, roof, group;
  window.box_min = {0.199, -0.1, 0.70}, window.box_max = {0.201, 0.1, 0.94};
  group.group = "skin";
  model.machine.surfaces = {surface("column.group", group), surface("column.all", {}),
                            surface("column.window", window)};
  model.machine.surfaces[1].any_of.clear();
  const diagnosis::PlaceOfCause at_window = diagnosis::place_of("column", inside, model);
  EXPECT_EQ(at_window.surface, "column.window");
  EXPECT_NEAR(at_window.surface_m, 0.06, 1e-12);
  EXPECT_EQ(diagnosis::place_in_words("column", inside, model),
            "the top right of column, 900 mm above the table, 60 mm from column.window, near sensor T3");
  roof.plane_point = Eigen::Vector3d(0, 0, 1), roof.plane_normal = Eigen::Vector3d::UnitZ();
  model.machine.surfaces.push_back(surface("column.roof", roof));
  EXPECT_EQ(diagnosis::place_of("column", inside, model).surface, "column.roof");
  EXPECT_EQ(diagnosis::place_in_words("column", inside, model),
            "the top right of column, 900 mm above the table, on column.roof, near sensor T3");
  // A plane reaches beyond the body: where no part of the skin lies on it, it is no place.
  model.machine.surfaces.back().any_of.front().plane_point = Eigen::Vector3d(0, 0, 0.95);
  EXPECT_EQ(diagnosis::place_of("column", inside, model).surface, "column.window");
  EXPECT_EQ(diagnosis::place_of("bed", inside, model).surface, "") << "another body";
}

}  // namespace
