// SPDX-License-Identifier: GPL-3.0-or-later
// `export --matrices`, and back through `reduce --matrices`: the same equation, the same reduced model.
#include <Eigen/LU>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <complex>
#include <iterator>

#include "core/config.h"
#include "core/file.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/model_file.h"
#include "reduction/model/reduced_model.h"
#include "reduction/systems/system_file.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/export/matrix_export.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;
using Eigen::MatrixXcd;

/// C (s E - A)^-1 B.
MatrixXcd transfer(const Eigen::MatrixXd& e, const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                   const Eigen::MatrixXd& c, double frequency) {
  const MatrixXcd pencil =
      std::complex<double>(0.0, frequency) * e.cast<std::complex<double>>() - a.cast<std::complex<double>>();
  return c.cast<std::complex<double>>() * pencil.partialPivLu().solve(b.cast<std::complex<double>>());
}

std::vector<core::Node> tables_of(const core::Config& names, const char* key) { return names.root().tables(key); }

TEST(ExportMatrices, ComeBackAsTheSameReducedModel) {
  const Toy toy;
  toy.take_results();
  const Result exported = toy.run({"export", toy.path(), "--matrices", "--json", "--quiet"});
  ASSERT_EQ(exported.status, 0) << exported.err;
  const json summary = json::parse(exported.out);
  const std::filesystem::path folder = toy.result("matrices");
  const core::Config names = core::Config::load(folder / "names.toml");
  const auto films = tables_of(names, "film"), inputs = tables_of(names, "input"), outputs = tables_of(names, "output");
  EXPECT_EQ(summary["films"].get<std::size_t>(), films.size());
  EXPECT_SAYS(summary["notes"].dump(), "linearised at the reference temperature of 20 degC: radiation = ");

  // At the values as the machine stands, both reductions are of the same system.
  const std::string out = toy.file("reduced");
  const Result reduced =
      thermotwin({"reduce", "--matrices", folder.string(), "--tolerance", "1e-6", "--out", out, "--json"});
  ASSERT_EQ(reduced.status, 0) << reduced.err;
  EXPECT_TRUE(json::parse(reduced.out)["bound_holds"].get<bool>());
  // What comes out is again such a folder, with the names and values that it had.
  EXPECT_EQ(read(std::filesystem::path(out) / "names.toml"), read(folder / "names.toml"));
  const Result again = thermotwin({"reduce", "--matrices", out, "--order", "20", "--out", toy.file("again"), "--json"});
  EXPECT_EQ(again.status, 0) << again.err;
  std::vector<std::string> film_names;
  const reduction::ReducedLinearSystem back =
      reduction::read_system(std::filesystem::path(out) / reduction::system_file_name, &film_names);
  ASSERT_EQ(back.films.size(), films.size());
  const reduction::ReducedModel own = reduction::read_model(toy.result("model.rom.h5"));
  const reduction::ReducedSystem& system = own.system;
  ASSERT_EQ(system.terms.size(), films.size());
  ASSERT_EQ(static_cast<std::size_t>(system.inputs.cols()), inputs.size());

  Eigen::MatrixXd own_a = -system.conduction, back_a = back.A;
  for (std::size_t j = 0; j < films.size(); ++j) {
    const double value = films[j].number("value");
    own_a -= value * system.terms[j];
    const auto at = std::find(film_names.begin(), film_names.end(), films[j].text("name")) - film_names.begin();
    back_a += value * back.films[at];
  }
  // A source of 1 W, and an ambient of 1 K above the reference.
  Eigen::MatrixXd drive = Eigen::MatrixXd::Zero(std::ssize(inputs), 2);
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    const std::string name = inputs[k].text("name");
    if (name.starts_with("source.")) drive(k, 0) = 1.0;
    for (const core::Node& film : films)
      if (name == film.text("name") + ".ambient") drive(k, 1) = film.number("value");
  }
  ASSERT_GT(drive.col(0).sum(), 0.0);
  ASSERT_GT(drive.col(1).sum(), 0.0);
  const auto sensors = std::ssize(own.machine.sensors);
  ASSERT_EQ(outputs.size(), static_cast<std::size_t>(sensors) + 6);
  EXPECT_EQ(outputs[sensors].text("name"), "dx_um");
  for (const double frequency : {0.0, 1e-5, 1e-4, 1e-3}) {
    const MatrixXcd a =
        transfer(system.capacity, own_a, system.inputs * drive, system.sensors.topRows(sensors), frequency);
    const MatrixXcd b = transfer(back.E, back_a, back.B * drive, back.C.topRows(sensors), frequency);
    EXPECT_LT((a - b).norm(), 5e-3 * a.norm()) << frequency;
  }
}

TEST(ExportMatrices, AreTheEquationOfTheMachine) {
  const Toy toy;
  const solver::Case machine_case = solver::read_case(toy.path());
  const solver::FullModel full =
      solver::build_full_model(machine_case.machine, {mesh::size_factor(machine_case.machine, machine_case.size), {}});
  ASSERT_EQ(toy.run({"export", toy.path(), "--matrices", "--quiet"}).status, 0);
  const reduction::LinearSystem read = reduction::read_linear_system(toy.result("matrices"));
  // Whoever reads makes a matrix symmetric that is so but for rounding.
  const auto same = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    return (a - b).norm() <= 1e-15 * b.norm();
  };
  EXPECT_TRUE(same(read.base.E, full.thermal.capacity));
  EXPECT_TRUE(same(read.base.A, -full.thermal.conduction));
  EXPECT_TRUE(same(read.base.B, full.thermal.inputs));
  const auto sensors = std::ssize(full.mesh.machine.sensors);
  EXPECT_TRUE(same(read.base.C.topRows(sensors), full.thermal.sensors.topRows(sensors)));
  const solver::MatrixNames names =
      solver::matrix_names(full.thermal, full.mesh.machine, mesh::Pose::Zero(std::ssize(full.mesh.machine.axes)));
  ASSERT_EQ(read.films.size(), full.thermal.terms.size());
  for (const reduction::ParameterMatrix& film : read.films) {
    const auto at = std::find_if(names.films.begin(), names.films.end(),
                                 [&](const auto& named) { return named.name == film.name; });
    ASSERT_NE(at, names.films.end()) << film.name;
    EXPECT_TRUE(same(film.matrix, -full.thermal.terms[at - names.films.begin()])) << film.name;
    EXPECT_EQ(film.value, at->value) << film.name;
  }
}

TEST(ExportMatrices, BadNamesAreRefused) {
  const Toy toy;
  ASSERT_EQ(toy.run({"export", toy.path(), "--matrices", "--quiet"}).status, 0);
  std::string text = read(toy.result("matrices/names.toml"));
  const auto at = text.find("name = \"film.");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 13, "name = \"filn.");
  core::write_file(toy.result("matrices/names.toml"), text);
  const Result wrong =
      thermotwin({"reduce", "--matrices", toy.result("matrices").string(), "--out", toy.file("reduced")});
  EXPECT_EQ(wrong.status, 3);
  EXPECT_SAYS(wrong.err, "filn.");
  EXPECT_SAYS(wrong.err, "nearest: film.");
  const auto of_film = text.find("[[film]]");
  text.erase(of_film, text.find("[[film]]", of_film + 1) - of_film);
  core::write_file(toy.result("matrices/names.toml"), text);
  const Result fewer =
      thermotwin({"reduce", "--matrices", toy.result("matrices").string(), "--out", toy.file("reduced")});
  EXPECT_EQ(fewer.status, 3);
  EXPECT_SAYS(fewer.err, "one for each of the");
  EXPECT_EQ(toy.run({"export", toy.path(), "--matrices", "--calculix"}).status, 2);
  EXPECT_EQ(toy.run({"export", toy.path()}).status, 2);
}

}  // namespace
}  // namespace thermotwin::cases
