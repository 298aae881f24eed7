// SPDX-License-Identifier: GPL-3.0-or-later
// A loose sensor takes on the air of the film where it hangs: of a volume, of a fluid, or of the hall.
#include <gtest/gtest.h>

#include "diagnosis/response/response.h"
#include "reduction/basis/reduce.h"
#include "solver/operation/channels.h"
#include "solver/operation/load_program.h"
#include "tests/machines/boxes.h"

namespace {

using namespace thermotwin;
using Eigen::Index;
using Eigen::MatrixXd;

/// The boxes with a cabin around the head, warmed by the head, with a sensor in it, and a sensor beside the fluid.
mesh::Machine with_cabin() {
  mesh::Machine machine = test::small_machine();
  std::erase(machine.films[0].surfaces, "head.front");
  mesh::FilmSpec film;
  film.id = "front";
  film.surfaces = {"head.front"};
  film.ambient = "cabin";
  film.coefficient.value = 15;
  machine.films.push_back(film);
  mesh::VolumeSpec cabin;
  cabin.id = "cabin";
  cabin.capacity.value = 3000;
  mesh::VolumeExchange exchange;
  exchange.with = "air";
  exchange.conductance.value = 0.5;
  cabin.exchanges = {exchange};
  machine.volumes = {cabin};
  mesh::SensorSpec inside, wet;
  inside.id = "T3";
  inside.volume = "cabin";
  wet.id = "T4";
  wet.body = "table";
  wet.point = {0.05, 0.05, 0.2};
  machine.sensors.push_back(inside);
  machine.sensors.push_back(wet);
  machine.films[1].surfaces = {"slide.sides"};  // the disc leaves the table's top to the fluid
  return machine;
}

mesh::MachineMesh meshed(mesh::Machine machine) {
  std::vector<mesh::TetMesh> bodies = test::small_machine_mesh().bodies;
  return test::machine_mesh(std::move(machine), std::move(bodies));
}

TEST(LooseSensor, TakesOnTheAirOfItsFilm) {
  const solver::FullModel full = test::full_model(meshed(with_cabin()));
  const reduction::ReducedModel model = reduction::reduce(full, {}, {}, {.order = 40, .parts = false});
  ASSERT_TRUE(model.sensor_air.has_value());
  EXPECT_EQ(model.sensor_air->film, Eigen::Vector4i(0, 3, -1, 2));

  const solver::LoadProgram load = solver::LoadProgram::parse(R"(schema = 1
initial_C = 20
time_step_s = 120
output_s = 600
position = { X_mm = 0, Z_mm = 0 }
[[phase]]
name = "warm"
duration_h = 2
spindle_rpm = 9000
air_C = 20
cutting_fluid_C = 26
)",
                                                              "p.toml", model.machine);
  diagnosis::Observations plan;
  const std::vector<double> ends = load.step_ends();
  plan.points.resize(std::ssize(ends) + 1);
  plan.points[0] = 0.0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Index at = i;
    plan.points[at + 1] = ends[i];
    const Eigen::VectorXd row = load.row(plan.points[at], ends[i]);
    if (i == 0) plan.rows.resize(std::ssize(ends), row.size());
    plan.rows.row(at) = row.transpose();
  }
  plan.end = ends.back();
  plan.start_C = 20;
  for (const char* sensor : {"T1", "T2", "T3", "T4"}) {
    diagnosis::ObservedChannel channel;
    channel.channel.id = channel.channel.sensor = sensor;
    channel.channel.kind = compensation::ChannelKind::temperature;
    plan.channels.push_back(channel);
  }
  const diagnosis::Response response(model, plan);
  const MatrixXd fixed = response.at_points(model.machine);
  mesh::Machine loose = model.machine;
  for (const int s : {0, 1, 3}) loose.sensors[s].air_share = 1.0;
  const MatrixXd hanging = response.at_points(loose);
  const Index last = fixed.rows() - 1;
  ASSERT_GT(fixed(last, 2), 20.5) << "the cabin is not warm";
  ASSERT_GT(fixed(last, 1), fixed(last, 2) + 0.5) << "the head is no warmer than the cabin";
  EXPECT_LT((hanging.col(1) - fixed.col(2)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((hanging.col(3).array() - 26.0).abs().maxCoeff(), 1e-9);
  EXPECT_LT((hanging.col(0).array() - 20.0).abs().maxCoeff(), 1e-9);
  EXPECT_EQ(hanging.col(2), fixed.col(2));
}

}  // namespace
