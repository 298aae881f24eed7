// SPDX-License-Identifier: GPL-3.0-or-later
// What holds whatever the mesh: heat is balanced, transfer is reciprocal, output rows by adjoint
// solves are the outputs of the displacement field. On machines with every kind of joint, film and
// coolant, linear and quadratic.
#include <gtest/gtest.h>

#include "mesh/machine/kinematics.h"
#include "solver/elastic/assembly.h"
#include "solver/elastic/model.h"
#include "solver/elastic/tcp.h"
#include "solver/operation/layout.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "solver/thermal/system.h"
#include "tests/machines/box_machine.h"
#include "tests/machines/one_body.h"
#include "tests/machines/slide_machine.h"
#include "tests/verification/rig.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

/// [time] stands before the first phase.
std::string insert_time(const std::string& program, const std::string& time) {
  const std::size_t at = program.find("[[phase]]");
  return program.substr(0, at) + time + program.substr(at);
}

TEST(Conservation, HeatOfATransient) {
  // What is stored is what came in by sources, films, mounts and the coolant's flow (backward Euler:
  // at the temperatures of the end of each step).
  for (int order : {1, 2}) {
    const mesh::MachineMesh mesh = with_order(slide_mesh(), order);
    const solver::ThermalSystem system = solver::assemble_thermal(mesh);
    const solver::OperatingModel model(mesh.machine, system.layout);
    solver::IntegratorOptions options;
    options.tolerance = 1e-13;
    options.backward_euler = true;
    solver::ThermalIntegrator integrator(system, options);
    Eigen::MatrixXd state = Eigen::MatrixXd::Constant(system.size, 1, 2.0);
    const Eigen::VectorXd stored_by = system.capacity * Eigen::VectorXd::Ones(system.size);
    Eigen::VectorXd row = model.channels().defaults();
    const auto channel = [&](const char* name) -> double& { return row[model.channels().index(name)]; };
    double in = 0.0, throughput = 0.0;
    const double before = stored_by.dot(state.col(0));
    for (int step = 0; step < 20; ++step) {
      constexpr double h = 60.0;
      channel("spindle.speed_rpm") = 1500.0 * (step % 8);
      channel("axis.X.feed_mm_min") = 6000.0 * (step % 4);
      channel("axis.X.position_mm") = 150.0 * std::sin(0.7 * step);
      const solver::Coefficients c = model.coefficients(row, Eigen::VectorXd::Constant(1, -1.0));
      integrator.advance(state, {c}, h);
      for (std::size_t k = 0; k < system.layout.inputs.size(); ++k) {
        const solver::Input& input = system.layout.inputs[k];
        const Eigen::VectorXd column = system.inputs.col(k);
        const double given = c.q[k] * column.sum();
        double lost = 0.0;
        if (input.kind == solver::InputKind::film_ambient || input.kind == solver::InputKind::contact_ambient)
          lost = c.p[input.term] * state.col(0).dot(column);
        if (input.kind == solver::InputKind::coolant_inlet)
          lost = c.p[input.term] * mesh.machine.coolants[0].specific_heat * state(system.size - 1, 0);
        in += h * (given - lost);
        throughput += h * (std::abs(given) + std::abs(lost));
      }
    }
    EXPECT_GT(throughput, 1e5);
    expect_below({of_order("machine with joints, films and coolant", order), "exact",
                  "heat stored less heat let in, over heat moved"},
                 1e-11, std::abs(stored_by.dot(state.col(0)) - before - in) / throughput);
  }
}

TEST(Conservation, HeatOfARunByItsOwnAccount) {
  // As a run reports it, with the solver's own tolerance: motion, spindle, cutting fluid, a chiller; and
  // a body that radiates by fourth powers, of a material whose properties change with temperature.
  const std::string slide_program =
      "initial_C = 22\noutput_s = 1800\ntime_step_s = 60\n"
      "[[phase]]\nduration_s = 3600\nspindle_rpm = 9000\n[[phase.axis]]\nid = \"X\"\nlow_mm = -150\nhigh_mm = "
      "150\nfeed_mm_min = 20000\n"
      "[[phase]]\nduration_s = 3600\nspindle_rpm = 3000\ncutting_fluid = true\nair_C = [20.0, 26.0]\n";
  mesh::Machine hot = bar_machine();
  hot.materials[0].conductivity_table = {{20.0, 320.0}, {45.0, 30.0}};
  hot.materials[0].specific_heat_table = {{20.0, 320.0}, {470.0, 600.0}};
  hot.films = {constant_film("skin", {"skin"}, 10.0)};
  hot.films[0].emissivity.value = 0.9;
  hot.films[0].exact_radiation = true;
  hot.sources = {heat_source("heater", 60.0, "x0")};
  const std::string hot_program = "initial_C = 20\noutput_s = 1800\ntime_step_s = 120\n[[phase]]\nduration_s = 1200\n";
  const std::pair<std::string, std::string> schemes[] = {{"SDIRK2", ""},
                                                         {"backward Euler", "[time]\nscheme = \"backward_euler\"\n"},
                                                         {"error control", "[time]\ntolerance_K = 0.01\n"}};
  for (int order : {1, 2}) {
    const Bench slide(with_order(slide_mesh(), order)), bar(bar_mesh(hot, order));
    for (const auto& [name, keys] : schemes) {
      const auto of_slide = slide.run(insert_time(slide_program, keys), 1e-9),
                 of_bar = bar.run(insert_time(hot_program, keys), 1e-9);
      EXPECT_GT(of_slide.heat.throughput(), 1e5);
      EXPECT_GT(of_bar.heat.stored(), 1e3);
      expect_below({of_order("machine with joints, films and chiller, " + name, order), "exact",
                    "stored less let in, over the throughput"},
                   1e-10, of_slide.heat.gap());
      expect_below({of_order("hot bar, nonlinear, " + name, order), "exact", "stored less let in, over the throughput"},
                   1e-10, of_bar.heat.gap());
    }
  }
}

TEST(Reciprocity, OfHeat) {
  // Without coolant flow the temperature at b by a source at a is that at a by a source at b, in the
  // frequency domain at any shift.
  for (int order : {1, 2}) {
    const mesh::MachineMesh mesh = with_order(slide_mesh(), order);
    const solver::ThermalSystem system = solver::assemble_thermal(mesh);
    const solver::OperatingModel model(mesh.machine, system.layout);
    Eigen::VectorXd row = model.channels().defaults();
    row[model.channels().index("coolant.main.on")] = 0.0;
    const solver::Coefficients c = model.coefficients(row, Eigen::VectorXd::Zero(1));
    Eigen::MatrixXd sources(system.size, 3);
    int count = 0;
    for (std::size_t k = 0; k < system.layout.inputs.size() && count < 3; ++k)
      if (system.layout.inputs[k].kind == solver::InputKind::source) sources.col(count++) = system.inputs.col(k);
    ASSERT_EQ(count, 3);
    const Eigen::MatrixXd transfer = sources.transpose() * solver::solve_shifted(system, c, 1e-4, sources);
    expect_below({of_order("reciprocity of heat transfer", order), "exact, no coolant flow", "asymmetry over transfer"},
                 1e-12, (transfer - transfer.transpose()).norm() / transfer.norm());
  }
}

TEST(Reciprocity, OfElasticity) {
  // Betti: the work of one load along the displacement by another.
  for (int order : {1, 2}) {
    const mesh::TetMesh box = shaken_box({0.4, 0.3, 0.2}, {4, 3, 3}, order);
    const solver::ElasticBody body = solver::assemble_elastic(box, steel(), "box");
    Eigen::MatrixXd loads(3 * box.nodes(), 2);
    for (Index i = 0; i < box.nodes(); ++i) {
      const Vector3d p = box.points.col(i);
      loads.block<3, 1>(3 * i, 0) = Vector3d(p.y(), p.x() * p.z(), 1.0);
      loads.block<3, 1>(3 * i, 1) = Vector3d(p.z() * p.z(), -p.x(), p.y());
    }
    solver::clear_fixed(body, loads);
    const Eigen::MatrixXd work = loads.transpose() * solver::SparseFactor(body.stiffness).solve(loads);
    expect_below({of_order("reciprocity of elasticity", order), "exact (Betti)", "asymmetry over work"}, 1e-12,
                 std::abs(work(0, 1) - work(1, 0)) / work.norm());
  }
}

TEST(Adjoint, OutputRowsAreTheOutputsOfTheDisplacement) {
  for (int order : {1, 2}) {
    const mesh::MachineMesh mesh = with_order(box_machine_mesh(), order);
    const solver::ThermalSystem thermal = solver::assemble_thermal(mesh);
    const solver::ElasticModel elastic(mesh, thermal);
    const Eigen::VectorXd temperature = uneven_temperature(mesh, thermal.size);
    double worst = 0.0;
    for (const mesh::Pose& pose : {box_pose(0, 0), box_pose(0.137, -0.061), box_pose(-0.2, 0.1)}) {
      const solver::OutputRows rows = elastic.output_rows(pose);
      const auto direct = elastic.outputs_of(elastic.displacement(temperature, pose), pose);
      EXPECT_GT(direct.tool.head<3>().norm(), 1e-6);
      worst = std::max({worst, (rows.tool * temperature - direct.tool).norm() / direct.tool.norm(),
                        (rows.table_axis * temperature - direct.table_axis).norm() / direct.table_axis.norm(),
                        (rows.table_own * temperature - direct.table_own).norm() / direct.table_own.norm()});
    }
    expect_below({of_order("machine of five bodies, three poses", order), "exact",
                  "adjoint rows times T less outputs of u, over outputs"},
                 1e-9, worst);
  }
}

TEST(Machine, EvenTemperatureOnlyScalesIt) {
  // One material, tapes that expand alike, soft mounts: the error is alpha T times the way from the
  // table's surface to the tool's.
  BoxMachineOptions options;
  options.mount_normal = options.mount_tangential = 1e4;
  for (int order : {1, 2}) {
    const mesh::MachineMesh mesh = with_order(box_machine_mesh(options), order);
    const solver::ThermalSystem thermal = solver::assemble_thermal(mesh);
    const solver::ElasticModel elastic(mesh, thermal);
    const double strain = 11.5e-6 * 2.0;
    const Eigen::VectorXd temperature = Eigen::VectorXd::Constant(thermal.size, 2.0);
    double worst = 0.0;
    for (const mesh::Pose& pose : {box_pose(0, 0), box_pose(0.137, -0.061)}) {
      const solver::OutputRows rows = elastic.output_rows(pose);
      const solver::TcpError error = solver::tcp_error(mesh.machine, pose, rows.tool * temperature,
                                                       rows.table_axis * temperature, rows.table_own * temperature);
      const Vector3d nose(0.0, 0.125, 0.25 + pose[1]), table(pose[0], 0.0, 0.05);
      Vector3d growth = solver::tcp_position(mesh.machine, pose) - table;
      growth.z() = 0.0;
      worst = std::max(worst, (error.error.head<3>() - strain * (nose - table - growth)).norm() / strain);
    }
    expect_below({of_order("machine of five bodies, evenly warm", order), "exact",
                  "TCP error less alpha T times way, over alpha T 1 m"},
                 1e-4, worst);
  }
}

}  // namespace
}  // namespace thermotwin::test
