// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/candidates.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::study {
namespace {

/// Places on one body.
std::vector<Eigen::Vector3d> on_body(const std::vector<Place>& places, int body) {
  std::vector<Eigen::Vector3d> points;
  for (const Place& place : places)
    if (place.body == body) points.push_back(place.point);
  return points;
}

double nearest(const std::vector<Eigen::Vector3d>& points) {
  double least = 1e9;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) least = std::min(least, (points[i] - points[k]).norm());
  return least;
}

bool any_at_z(const std::vector<Eigen::Vector3d>& points, double z) {
  return std::any_of(points.begin(), points.end(), [&](const auto& point) { return std::abs(point.z() - z) < 1e-9; });
}

TEST(SensorPlaces, KeepTheirDistanceAndLeaveContactsOut) {
  const mesh::MachineMesh mesh = test::slide_mesh(2);
  PlaceRules rules;
  rules.spacing = 0.04;
  const std::vector<Place> places = sensor_places(mesh, rules);
  const auto bed = on_body(places, 0), slide = on_body(places, 1);
  EXPECT_GE(nearest(bed), 0.04);
  EXPECT_LT(nearest(bed), 0.06);
  EXPECT_GE(nearest(slide), 0.04);
  // The mesh's nodes at home, in the numbers of the whole machine.
  for (const Place& place : places)
    EXPECT_EQ(mesh.bodies[place.body].points.col(place.node - mesh.first_node[place.body]), place.point);
  // The slide's pad covers its lower face, the rail the bed's upper one, the mount the feet.
  EXPECT_FALSE(any_at_z(bed, 0.1) || any_at_z(bed, 0.0) || any_at_z(slide, 0.101));
  EXPECT_TRUE(any_at_z(slide, 0.16));
  rules.on_contacts = true;
  const std::vector<Place> more = sensor_places(mesh, rules);
  EXPECT_TRUE(any_at_z(on_body(more, 0), 0.1) && any_at_z(on_body(more, 1), 0.101));
}

TEST(SensorPlaces, FollowBodiesAndSurfacesThatAreNamed) {
  const mesh::MachineMesh mesh = test::slide_mesh(2);
  PlaceRules rules;
  rules.spacing = 0.02;
  rules.bodies = {"slide"};
  rules.without = {"slide.top"};
  const std::vector<Place> places = sensor_places(mesh, rules);
  EXPECT_TRUE(on_body(places, 0).empty());
  EXPECT_FALSE(any_at_z(on_body(places, 1), 0.16));
  rules.bodies.clear();
  rules.without = {"bed"};
  EXPECT_TRUE(on_body(sensor_places(mesh, rules), 0).empty());
  rules.without = {"bed", "slide"};
  EXPECT_THROW(sensor_places(mesh, rules), core::InputError);
  rules.without = {"slied"};
  EXPECT_THROW(sensor_places(mesh, rules), core::InputError);
}

TEST(SensorPlaces, LeaveBodiesOutThatTurnWithoutEnd) {
  mesh::Machine machine = test::slide_machine();
  machine.axes[0].endless = true;
  const mesh::MachineMesh mesh = test::slide_mesh(2, machine);
  PlaceRules rules;
  EXPECT_TRUE(on_body(sensor_places(mesh, rules), 1).empty());
  EXPECT_FALSE(on_body(sensor_places(mesh, rules), 0).empty());
  rules.on_rotating = true;
  EXPECT_FALSE(on_body(sensor_places(mesh, rules), 1).empty());
}

// In a film of a rotating disc, `fraction` is the share of the surface that turns.
TEST(SensorPlaces, LeaveBodiesOutThatTurnWithASpindle) {
  mesh::Machine machine = test::slide_machine();
  mesh::FilmSpec film;
  film.surfaces = {"slide.top"};
  film.kind = mesh::FilmKind::rotating_disc;
  film.axis = "spindle";
  for (const double fraction : {0.3, 1.0}) {
    film.fraction = fraction;
    machine.films = {film};
    const mesh::MachineMesh mesh = test::slide_mesh(2, machine);
    PlaceRules rules;
    EXPECT_EQ(on_body(sensor_places(mesh, rules), 1).empty(), fraction == 1.0);
    rules.on_rotating = true;
    EXPECT_FALSE(on_body(sensor_places(mesh, rules), 1).empty());
  }
}

}  // namespace
}  // namespace thermotwin::study
