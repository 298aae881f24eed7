// SPDX-License-Identifier: GPL-3.0-or-later
// An independent code on the same mesh: the decks that the program writes, run by CalculiX, against
// our own temperatures and displacements at every node.

#include <gtest/gtest.h>

#include <iterator>

#include "mesh/machine/kinematics.h"
#include "solver/campaign/simulation.h"
#include "solver/elastic/assembly.h"
#include "solver/linear/sparse_factor.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/element_rules.h"
#include "solver/thermal/integrator.h"
#include "tests/machines/box_machine.h"
#include "tests/machines/slide_machine.h"
#include "tests/verification/calculix_run.h"
#include "tests/verification/rig.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

constexpr double of_the_range = 1e-4, of_the_largest = 1e-3;

std::string element(int order) { return order == 1 ? "C3D4" : "C3D10"; }

/// Node by node, over the range of the temperatures.
double difference(const Eigen::VectorXd& theirs_C, const Eigen::VectorXd& ours_C) {
  EXPECT_EQ(theirs_C.size(), ours_C.size());
  if (theirs_C.size() != ours_C.size()) return 1e300;
  const double range = ours_C.maxCoeff() - ours_C.minCoeff();
  EXPECT_GT(range, 1.0) << "nothing to compare";
  return (theirs_C - ours_C).cwiseAbs().maxCoeff() / range;
}

void expect_temperatures(const std::string& name, const std::string& source, const Eigen::VectorXd& theirs_C,
                         const Eigen::VectorXd& ours_C, const std::string& when, double bound = of_the_range) {
  const double found = difference(theirs_C, ours_C);
  if (bound > of_the_range) {
    expect_value({name, source, "largest difference of T" + when + ", % of its range"}, 0.0, 100.0 * found,
                 100.0 * bound);
  } else
    expect_below({name, source, "largest difference of T" + when + ", over its range"}, bound, found);
}

void expect_displacements(const std::string& name, const std::string& source, const Eigen::MatrixXd& theirs,
                          const Eigen::MatrixXd& ours) {
  ASSERT_EQ(theirs.cols(), ours.cols());
  const double largest = ours.colwise().norm().maxCoeff();
  double found = 0.0;
  for (Index i = 0; i < ours.cols(); ++i)
    if (std::isfinite(theirs(0, i))) found = std::max(found, (theirs.col(i) - ours.col(i)).norm() / largest);
  expect_below({name, source, "largest difference of displacement, over the largest"}, of_the_largest, found);
}

solver::LoadProgram program(const std::string& text, const mesh::Machine& machine) {
  return solver::LoadProgram::parse("schema = 1\n" + text, "loads/load.toml", machine);
}

/// Temperatures at the corners of the program, degC, by backward Euler at its steps.
Eigen::MatrixXd transient(const mesh::MachineMesh& mesh, const solver::ThermalSystem& system,
                          const solver::LoadProgram& load) {
  const solver::OperatingModel model(mesh.machine, system.layout);
  solver::IntegratorOptions options;
  options.backward_euler = true;
  options.tolerance = 1e-12;
  solver::ThermalIntegrator integrator(system, options);
  Eigen::MatrixXd state = Eigen::MatrixXd::Constant(system.size, 1, load.initial_C() - mesh.machine.reference_C);
  std::vector<Eigen::VectorXd> corners;
  double from = 0.0;
  for (const double end : load.step_ends()) {
    integrator.advance(
        state, {model.coefficients(load.row(from, end), Eigen::VectorXd::Zero(std::ssize(mesh.machine.coolants)))},
        end - from);
    if (load.is_corner(end))
      corners.push_back((state.col(0).head(mesh.nodes()).array() + mesh.machine.reference_C).matrix());
    from = end;
  }
  Eigen::MatrixXd all(mesh.nodes(), std::ssize(corners));
  for (std::size_t i = 0; i < corners.size(); ++i) all.col(i) = corners[i];
  return all;
}

/// L-shaped body: an upright wall on a foot, cut from a structured box.
mesh::TetMesh angle_bracket(int order) {
  const mesh::TetMesh box = order == 1 ? box_mesh({0, 0, 0}, {0.32, 0.12, 0.4}, {16, 6, 20})
                                       : box_mesh({0, 0, 0}, {0.32, 0.12, 0.4}, {8, 2, 10});
  std::vector<int> number(box.nodes(), -1);
  mesh::TetMesh bracket;
  std::vector<Index> kept;
  for (Index e = 0; e < box.elements(); ++e) {
    Vector3d centre = Vector3d::Zero();
    for (int i = 0; i < 4; ++i) centre += 0.25 * box.points.col(box.tets(i, e));
    if (centre.x() < 0.12 || centre.z() < 0.12) kept.push_back(e);
  }
  bracket.tets.resize(4, std::ssize(kept));
  int nodes = 0;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    for (int i = 0; i < 4; ++i) {
      int& of = number[box.tets(i, kept[k])];
      if (of < 0) of = nodes++;
      bracket.tets(i, k) = of;
    }
  }
  bracket.points.resize(3, nodes);
  for (Index i = 0; i < box.nodes(); ++i)
    if (number[i] >= 0) bracket.points.col(number[i]) = box.points.col(i);
  mesh::build_boundary(bracket, "bracket");
  for (int f = 0; f < bracket.face_count(); ++f) {
    const Vector3d normal = bracket.face_normal(f), centre = bracket.face_centre(f);
    if (normal.z() < -0.9)
      bracket.groups["foot"].push_back(f);
    else if (normal.z() > 0.9 && centre.z() > 0.39)
      bracket.groups["top"].push_back(f);
    else if (normal.y() > 0.9)
      bracket.groups["side"].push_back(f);
    else if (normal.x() > 0.9)
      bracket.groups["front"].push_back(f);
  }
  mesh::set_order(bracket, order);
  return bracket;
}

/// Two films that share a side, a source over one more film; not the same conductivity in all directions.
mesh::MachineMesh bracket_machine(int order) {
  mesh::Machine machine;
  machine.reference_C = 20.0;
  machine.order = order;
  machine.spindle_max_rpm = 12000;
  machine.materials = {steel()};
  machine.materials[0].conductivity_tensor = Eigen::Matrix3d{{45, 4, 0}, {4, 40, -3}, {0, -3, 52}};
  machine.bodies = {body("bracket")};
  machine.surfaces = {surface("foot", "bracket", {"foot"}), surface("side", "bracket", {"side"}),
                      surface("top", "bracket", {"top"}), surface("front", "bracket", {"front"})};
  machine.ambients = {ambient("air", 23.0), ambient("foundation", 18.0)};
  machine.films = {constant_film("side", {"side", "front"}, 25.0),
                   constant_film("front", {"front", "top"}, 10.0, "foundation"),
                   constant_film("foot", {"foot"}, 150.0, "foundation")};
  machine.sources = {source("motor", "machine.on", {0, 1}, {0, 40}, {on_surface("top")}),
                     source("spindle", "spindle.speed_rpm", {0, 12000}, {0, 120},
                            {on_surface("top", 0.5), on_surface("front", 0.25)})};
  return machine_mesh(machine, {angle_bracket(order)});
}

class CalculiXDeck : public ::testing::TestWithParam<int> {
protected:
  void SetUp() override {
    if (!have_ccx()) GTEST_SKIP() << "CalculiX (ccx) is not installed";
  }
};

TEST_P(CalculiXDeck, OfOneBodySteadyAndBent) {
  const int order = GetParam();
  const mesh::MachineMesh mesh = bracket_machine(order);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh, solver::ElementRules::reduced);
  const solver::OperatingModel model(mesh.machine, system.layout);
  const Eigen::VectorXd temperature =
      solver::solve_steady(system, model.coefficients(model.channels().defaults(), Eigen::VectorXd(0)));
  const solver::ElasticBody elastic = solver::assemble_elastic(mesh.bodies[0], mesh.machine.materials[0], "bracket");
  Eigen::MatrixXd load = elastic.thermal_load * temperature;
  solver::clear_fixed(elastic, load);
  const Eigen::VectorXd motion = solver::SparseFactor(elastic.stiffness).solve(load).col(0);

  const CalculiX ccx(mesh, {});
  const std::string name = of_order("bracket", order), source = "CalculiX, the same mesh of " + element(order);
  ASSERT_EQ(ccx.temperatures().cols(), 1);
  expect_temperatures(name, source, ccx.temperatures().col(0), temperature.array() + 20.0, ", steady");
  expect_displacements(name, source, ccx.displacement(),
                       Eigen::Map<const Eigen::MatrixXd>(motion.data(), 3, mesh.nodes()));
}

TEST_P(CalculiXDeck, OfOneBodyOverALoadProgram) {
  const int order = GetParam();
  const mesh::MachineMesh mesh = bracket_machine(order);
  const solver::LoadProgram load = program(R"(initial_C = 21.0
time_step_s = 100
output_s = 10000
[[phase]]
duration_s = 1200
spindle_rpm = 9000
air_C = [21.0, 27.0]
[[phase]]
duration_s = 1000
spindle_rpm = 3000
foundation_C = 16.0
[[phase]]
duration_s = 90
machine_on = false
)",
                                           mesh.machine);
  solver::DeckOptions options;
  options.program = &load;
  options.heat_only = true;
  const CalculiX ccx(mesh, options);
  EXPECT_EQ(ccx.summary().steps, 3U);
  EXPECT_EQ(ccx.summary().increments, 12 + 10 + 1);
  const Eigen::MatrixXd theirs = ccx.temperatures();
  const std::string source = "CalculiX, the same mesh of " + element(order);
  const Eigen::MatrixXd ours = transient(mesh, solver::assemble_thermal(mesh, solver::ElementRules::reduced), load);
  ASSERT_EQ(theirs.cols(), ours.cols());
  double worst = 0.0;
  for (Index i = 0; i < ours.cols(); ++i) worst = std::max(worst, difference(theirs.col(i), ours.col(i)));
  expect_below(
      {of_order("bracket", order), source, "largest difference of T at the ends of three phases, over its range"},
      of_the_range, worst);
  // What our own rules differ by: the error of either code on this mesh, which both lose with it.
  const double rules = difference(theirs.col(1), transient(mesh, solver::assemble_thermal(mesh), load).col(1));
  if (order == 1) {
    EXPECT_GT(rules, of_the_range) << "the reduced rules would not be needed";
  }
  expect_value({of_order("bracket", order), source, "the same with our own, exact rules, after 2200 s, % of the range"},
               0.0, 100.0 * rules, 0.5);
}

TEST_P(CalculiXDeck, OfMaterialsOverTemperature) {
  // Ours takes properties at the middle of a step, CalculiX at its end: alike to first order.
  const int order = GetParam();
  mesh::MachineMesh mesh = bracket_machine(order);
  mesh::Material& material = mesh.machine.materials[0];
  material.conductivity_tensor.reset();
  material.conductivity_table = {{0, 60, 200}, {60, 35, 25}};
  material.specific_heat_table = {{0, 100}, {420, 600}};
  material.conductivity = material.conductivity_table(20.0);
  material.specific_heat = {material.specific_heat_table(20.0), 0.0};
  mesh.machine.sources[0].laws[0].power = {0, 700};
  const solver::LoadProgram load = program(
      "initial_C = 20\ntime_step_s = 600\noutput_s = 3600\n[time]\nscheme = \"backward_euler\"\n[[phase]]\nduration_s "
      "= 3600\n[[phase]]\nduration_s = 14400\n",
      mesh.machine);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh, solver::ElementRules::reduced);
  ASSERT_TRUE(system.local);
  const solver::OperatingModel model(mesh.machine, system.layout);
  solver::IntegratorOptions backward;
  backward.backward_euler = true;
  solver::ThermalIntegrator integrator(system, backward);
  solver::SimulationOptions quiet;
  quiet.progress = false;
  Eigen::VectorXd early, late;
  solver::simulate(integrator, model, {&load}, quiet, [&](const solver::OutputState& output) {
    if (output.index == 1) early = output.state.head(mesh.nodes()).array() + 20.0;
    late = output.state.head(mesh.nodes()).array() + 20.0;
  });
  solver::DeckOptions options;
  options.program = &load;
  options.heat_only = true;
  const CalculiX ccx(mesh, options);
  const Eigen::MatrixXd theirs = ccx.temperatures();
  const std::string name = of_order("bracket, properties over temperature", order),
                    source = "CalculiX, " + element(order);
  ASSERT_GE(theirs.cols(), 2);
  expect_temperatures(name, source, theirs.col(0), early, " after 3600 s", 0.01);
  expect_temperatures(name, source, theirs.rightCols<1>(), late, " after 18000 s", 0.01);
}

/// Two boxes, one on the other with a gap between; the lower surface of the upper one is the slave.
mesh::MachineMesh stack(int order, const Eigen::Vector3i& below, const Eigen::Vector3i& above, const Vector3d& low,
                        const Vector3d& high, double conductance) {
  mesh::Machine m;
  m.reference_C = 20.0;
  m.order = order;
  m.materials = {steel()};
  m.bodies = {body("base"), body("block")};
  m.surfaces = {surface("base.foot", "base", {"z0"}),
                surface("base.top", "base", {"z1"}),
                surface("base.skin", "base", {"x0", "y0", "y1"}),
                surface("block.foot", "block", {"z0"}),
                surface("block.top", "block", {"z1"}),
                surface("block.skin", "block", {"x1"})};
  m.ambients = {ambient("air", 22.0), ambient("foundation", 15.0)};
  m.films = {constant_film("foot", {"base.foot"}, 400.0, "foundation"),
             constant_film("skin", {"base.skin", "block.skin"}, 30.0)};
  m.sources = {
      source("motor", "machine.on", {0, 1}, {0, 100}, {on_surface("block.top", 0.8), at_joint("seat", 0.2, 0.3)})};
  mesh::JointSpec seat;
  seat.id = "seat";
  seat.kind = "bolted";
  seat.slave = "block.foot";
  seat.master = "base.top";
  seat.conductance = {conductance, 0.0};
  m.joints = {seat};
  return machine_mesh(m,
                      {box_of_order({0, 0, 0}, {0.2, 0.16, 0.1}, below, order), box_of_order(low, high, above, order)});
}

TEST_P(CalculiXDeck, OfAContactGap) {
  const int order = GetParam();
  struct Case {
    std::string name;
    Eigen::Vector3i above;
    Vector3d low, high;
  };
  const Case all[] = {{"contact gap, meshes that match", {4, 3, 2}, {0, 0, 0.1}, {0.2, 0.16, 0.2}},
                      {"contact gap, meshes that do not match", {5, 4, 2}, {0.03, 0.02, 0.101}, {0.17, 0.13, 0.2}}};
  for (const Case& c : all) {
    const mesh::MachineMesh mesh = stack(order, {4, 3, 2}, c.above, c.low, c.high, 1500.0);
    const solver::LoadProgram load = program(
        "initial_C = 20\ntime_step_s = 250\noutput_s = 10000\n[[phase]]\nduration_s = 1500\nair_C = "
        "22\n[[phase]]\nduration_s = 1000\nair_C = 30\n",
        mesh.machine);
    const Eigen::MatrixXd ours = transient(mesh, solver::assemble_thermal(mesh, solver::ElementRules::reduced), load);
    solver::DeckOptions options;
    options.program = &load;
    options.heat_only = true;
    const CalculiX ccx(mesh, options);
    const Eigen::MatrixXd theirs = ccx.temperatures();
    ASSERT_EQ(theirs.cols(), 2);
    expect_temperatures(of_order(c.name, order), "CalculiX, gap conductance, " + element(order), theirs.col(1),
                        ours.col(1), " after 2500 s");
  }
}

TEST_P(CalculiXDeck, OfTheTwoCubesOfContact7) {
  // CalculiX's example: a small cube, turned by 45 degrees, on a large one, a gap conductance between.
  // Its own answer is on two elements; this is its problem on tetrahedra. Density times 1e6, so that
  // its 0.006 s are 6000 s.
  const int order = GetParam();
  mesh::TetMesh large =
      box_mesh({0, 0, 0}, {1, 1, 1}, order == 1 ? Eigen::Vector3i(10, 10, 6) : Eigen::Vector3i(5, 5, 3));
  mesh::TetMesh small =
      box_mesh({-0.1, -0.1, 1.0}, {0.1, 0.1, 1.2}, order == 1 ? Eigen::Vector3i(4, 4, 4) : Eigen::Vector3i(2, 2, 2));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(M_PI / 4, Vector3d::UnitZ()).toRotationMatrix();
  small.points = ((turn * small.points).colwise() + Vector3d(0.5, 0.5, 0.0)).eval();
  mesh::set_order(large, order);
  mesh::set_order(small, order);
  mesh::Machine m;
  m.reference_C = 0.0;
  m.order = order;
  m.materials = {heat_material(0.01, 7.8e-3, 1000.0)};
  m.bodies = {body("large"), body("small")};
  m.surfaces = {surface("cold", "large", {"z0"}), surface("top", "large", {"z1"}), surface("foot", "small", {"z0"}),
                surface("hot", "small", {"z1"})};
  m.ambients = {ambient("zero", 0.0), ambient("thousand", 1000.0)};
  m.films = {constant_film("cold", {"cold"}, 1e4, "zero"), constant_film("hot", {"hot"}, 1e4, "thousand")};
  mesh::JointSpec gap;
  gap.id = "gap";
  gap.kind = "bolted";
  gap.slave = "foot";
  gap.master = "top";
  gap.conductance = {1.0, 0.0};
  m.joints = {gap};
  const mesh::MachineMesh mesh = machine_mesh(m, {large, small});
  const solver::LoadProgram load = program(
      "initial_C = 0\ntime_step_s = 300\noutput_s = 10000\n[[phase]]\nduration_s = 600\n[[phase]]\nduration_s = 5400\n",
      mesh.machine);
  const Eigen::MatrixXd ours = transient(mesh, solver::assemble_thermal(mesh, solver::ElementRules::reduced), load);
  solver::DeckOptions options;
  options.program = &load;
  options.heat_only = true;
  const CalculiX ccx(mesh, options);
  const Eigen::MatrixXd theirs = ccx.temperatures();
  ASSERT_EQ(theirs.cols(), 2);
  const std::string name = of_order("contact7, two cubes", order),
                    source = "CalculiX, its problem on " + element(order);
  expect_temperatures(name, source, theirs.col(0), ours.col(0), " after a tenth of the time");
  expect_temperatures(name, source, theirs.col(1), ours.col(1), " at the end");
}

TEST_P(CalculiXDeck, OfAMachineWithJointsAndScales) {
  const int order = GetParam();
  mesh::Machine machine = box_machine();
  machine.order = order;
  machine.sources = {
      source("motor", "machine.on", {0, 1}, {0, 300}, {on_surface("head.nose", 0.6), at_joint("Z_guide", 0.4, 0.5)})};
  // The bed's top in two parts, each the master of one joint: where joints share one, the deck has to
  // exchange the sides of the second, and ccx then differs by 2e-3 to 5e-3 of the range.
  std::vector<mesh::TetMesh> bodies = box_machine_mesh().bodies;
  bodies[0] = box_mesh({-0.5, -0.4, -0.3}, {0.5, 0.4, -0.1}, {8, 8, 2});
  for (const int face : bodies[0].groups.at("z1"))
    bodies[0].groups[bodies[0].face_centre(face).y() < 0.2 ? "ways" : "seat"].push_back(face);
  machine.surfaces.push_back(surface("bed.ways", "bed", {"ways"}));
  machine.surfaces.push_back(surface("bed.seat", "bed", {"seat"}));
  machine.joints[1].master = "bed.ways";
  machine.joints[3].master = "bed.seat";
  const mesh::MachineMesh mesh = with_order(machine_mesh(machine, std::move(bodies)), order);
  const mesh::Pose pose = box_pose(0.2, -0.1, M_PI / 6);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh, solver::ElementRules::reduced);
  const solver::OperatingModel model(mesh.machine, system.layout);
  Eigen::VectorXd row = model.channels().defaults();
  row[model.channels().index("axis.X.position_mm")] = 200.0;
  row[model.channels().index("axis.Z.position_mm")] = -100.0;
  row[model.channels().index("axis.C.position_deg")] = 30.0;
  const Eigen::VectorXd temperature = solver::solve_steady(system, model.coefficients(row, Eigen::VectorXd(0)));
  solver::DeckOptions options;
  options.pose = pose;
  const CalculiX ccx(mesh, options);
  ASSERT_EQ(ccx.temperatures().cols(), 1);
  const std::string name = of_order("machine of five bodies, off its home", order),
                    source = "CalculiX, the same mesh of " + element(order);
  expect_temperatures(name, source, ccx.temperatures().col(0), temperature.array() + 20.0, ", steady");

  // At its temperatures: tapes of scales, pads, a turned table.
  const solver::ElasticModel elastic(mesh, system);
  Eigen::Matrix3Xd motion = elastic.displacement(ccx.temperatures().col(0).array() - 20.0, pose);
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    auto of_body = motion.middleCols(mesh.first_node[b], mesh.bodies[b].nodes());
    of_body = (mesh::body_transform(mesh.machine, b, pose).linear() * of_body).eval();
  }
  expect_displacements(name, source, ccx.displacement(), motion);
}

INSTANTIATE_TEST_SUITE_P(Order, CalculiXDeck, ::testing::Values(1, 2),
                         [](const ::testing::TestParamInfo<int>& order) { return element(order.param); });

}  // namespace
}  // namespace thermotwin::test
