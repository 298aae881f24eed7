// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/linear_system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/config.h"
#include "core/error.h"
#include "core/matrix_market.h"
#include "core/text.h"
#include "reduction/systems/names_keys.h"

namespace thermotwin::reduction {
namespace {

using core::InputError;
using Eigen::Index;
namespace fs = std::filesystem;

std::string shape(const Sparse& matrix) { return fmt::format("{} x {}", matrix.rows(), matrix.cols()); }

double largest(const Sparse& matrix) {
  double value = 0;
  for (Index k = 0; k < matrix.nonZeros(); ++k) value = std::max(value, std::abs(matrix.valuePtr()[k]));
  return value;
}

/// Codes that assemble both triangles by themselves differ by rounding.
bool is_symmetric(const Sparse& matrix) {
  constexpr double rounding = 1e-14;
  const Sparse transposed = matrix.transpose();
  const Sparse difference = matrix - transposed;
  return largest(difference) <= rounding * largest(matrix);
}

Sparse symmetrised(const Sparse& matrix) {
  const Sparse transposed = matrix.transpose();
  Sparse mean = 0.5 * (matrix + transposed);
  mean.makeCompressed();
  return mean;
}

Sparse identity(Index n) {
  Sparse matrix(n, n);
  matrix.setIdentity();
  matrix.makeCompressed();
  return matrix;
}

void require_shape(const fs::path& file, const Sparse& matrix, Index rows, Index columns, const std::string& why) {
  if (matrix.rows() != rows || matrix.cols() != columns)
    throw InputError(file.string(), shape(matrix), fmt::format("{} x {}, {}", rows, columns, why));
}

void require_entries(const fs::path& file, const Sparse& matrix, const std::string& what) {
  if (largest(matrix) == 0.0) throw InputError(file.string(), "no entry other than 0", what);
}

/// A matrix whose products with itself and with others are numbers.
Sparse read_matrix(const fs::path& file) {
  constexpr double most = 1e100;
  Sparse matrix = core::read_matrix_market(file);
  const double value = largest(matrix);
  if (value > most || (value > 0.0 && value < 1.0 / most)) {
    throw InputError(file.string(), fmt::format("a largest entry of {:.6g}", value),
                     "1e-100 to 1e100, since reduction multiplies entries; scale it by other units");
  }
  return matrix;
}

std::vector<ParameterMatrix> read_films(const fs::path& folder, Index n) {
  const std::string prefix = "A_film_";
  std::vector<ParameterMatrix> films;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    const std::string stem = file.stem().string();
    if (file.extension() != ".mtx" || !stem.starts_with(prefix)) continue;
    if (stem.size() == prefix.size()) throw InputError(file.string(), "no name of the parameter", "A_film_NAME.mtx");
    films.push_back({stem.substr(prefix.size()), read_matrix(file)});
    require_shape(file, films.back().matrix, n, n, "as A.mtx");
  }
  std::sort(films.begin(), films.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return films;
}

}  // namespace

namespace {

/// Names and values of names.toml.
void read_names(const fs::path& file, LinearSystem& system) {
  const core::Config config = core::Config::load(file, &names_keys());
  const core::Node root = config.root();
  root.schema(1);
  system.names_text = config.text();
  std::vector<std::string> known, told;
  for (const ParameterMatrix& film : system.films) known.push_back(film.name);
  const auto require_new = [](const core::Node& table, std::vector<std::string>& names, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) != names.end())
      throw InputError(table.place("name"), "'" + name + "' named twice", "each name once");
    names.push_back(name);
  };
  for (const core::Node& table : root.tables("film")) {
    const std::string name = table.text("name");
    const auto film = std::find(known.begin(), known.end(), name);
    if (film == known.end()) {
      throw InputError(table.place("name"), "'" + name + "'",
                       "a NAME of the files A_film_NAME.mtx beside it" +
                           (known.empty() ? std::string() : " (nearest: " + core::nearest(name, known) + ")"));
    }
    require_new(table, told, name);
    system.films[film - known.begin()].value = table.number("value");
    table.text("unit");
    table.finish();
  }
  if (!told.empty() && told.size() != known.size()) {
    throw InputError(file.string(), fmt::format("{} [[film]] tables", told.size()),
                     fmt::format("none, or one for each of the {} films", known.size()));
  }
  const auto names = [&](const char* key, Index count, std::vector<std::string>& all) {
    for (const core::Node& table : root.tables(key)) {
      require_new(table, all, table.text("name"));
      table.text("unit");
      if (table.has("value")) table.number("value");
      table.finish();
    }
    if (!all.empty() && std::ssize(all) != count) {
      throw InputError(file.string(), fmt::format("{} [[{}]] tables", all.size(), key),
                       fmt::format("none, or one for each of the {} of the matrices", count));
    }
  };
  names("input", system.base.inputs(), system.input_names);
  names("output", system.base.outputs(), system.output_names);
  root.finish();
}

}  // namespace

StateSpace LinearSystem::at(const std::vector<double>& values) const {
  StateSpace system = base;
  for (std::size_t j = 0; j < films.size(); ++j) {
    system.A = Sparse(system.A + values[j] * films[j].matrix);
    system.symmetric = system.symmetric && is_symmetric(films[j].matrix);
  }
  if (system.symmetric) system.A = symmetrised(system.A);
  system.A.makeCompressed();
  return system;
}

LinearSystem read_linear_system(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError(folder.string(), "no such folder",
                     "a folder with A.mtx, B.mtx, C.mtx and, if it is not the identity, E.mtx");
  }
  const auto file = [&](const char* name) { return folder / (std::string(name) + ".mtx"); };
  const auto read = [&](const char* name) {
    if (!fs::exists(file(name), error)) {
      throw InputError(file(name).string(), "no such file",
                       "A.mtx, B.mtx and C.mtx; E.mtx, D.mtx and A_film_NAME.mtx where there are any");
    }
    return read_matrix(file(name));
  };
  LinearSystem system;
  system.folder = folder;
  StateSpace& base = system.base;
  base.A = read("A");
  const Index n = base.A.rows();
  if (base.A.cols() != n) throw InputError(file("A").string(), shape(base.A), "a square matrix");

  base.identity = !fs::exists(file("E"), error);
  base.E = base.identity ? identity(n) : read("E");
  require_shape(file("E"), base.E, n, n, "as A.mtx");

  const Sparse b = read("B"), c = read("C");
  if (b.rows() != n) {
    require_shape(file("B"), b, n, b.cols(),
                  b.cols() == n ? "its transpose: one column per input" : "a row for each state of A.mtx");
  }
  if (c.cols() != n) {
    require_shape(file("C"), c, c.rows(), n,
                  c.rows() == n ? "its transpose: one row per output" : "a column for each state of A.mtx");
  }
  require_entries(file("B"), b, "one or more entries: the system has no input");
  require_entries(file("C"), c, "one or more entries: the system has no output");
  base.B = Eigen::MatrixXd(b);
  base.C = Eigen::MatrixXd(c);
  base.D = Eigen::MatrixXd::Zero(base.outputs(), base.inputs());
  if (fs::exists(file("D"), error)) {
    const Sparse d = read("D");
    require_shape(file("D"), d, base.outputs(), base.inputs(),
                  "a row for each row of C.mtx, a column for each column of B.mtx");
    base.D = Eigen::MatrixXd(d);
    system.has_feedthrough = true;
  }
  system.films = read_films(folder, n);
  if (fs::exists(folder / "names.toml", error)) read_names(folder / "names.toml", system);

  base.symmetric = is_symmetric(base.A) && is_symmetric(base.E);
  if (base.symmetric) {
    base.A = symmetrised(base.A);
    base.E = symmetrised(base.E);
  }
  return system;
}

ReducedLinearSystem ReducedLinearSystem::at(const std::vector<double>& values) const {
  ReducedLinearSystem system = *this;
  for (std::size_t j = 0; j < films.size(); ++j) system.A += values[j] * films[j];
  system.films.clear();
  return system;
}

ReducedLinearSystem project(const LinearSystem& system, const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
  ReducedLinearSystem reduced;
  const auto between = [&](const Sparse& matrix) -> Eigen::MatrixXd { return left.transpose() * (matrix * right); };
  reduced.E = between(system.base.E);
  reduced.A = between(system.base.A);
  reduced.B = left.transpose() * system.base.B;
  reduced.C = system.base.C * right;
  reduced.D = system.base.D;
  for (const ParameterMatrix& film : system.films) reduced.films.push_back(between(film.matrix));
  return reduced;
}

}  // namespace thermotwin::reduction
