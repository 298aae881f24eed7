// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/system_file.h"

#include <fmt/format.h>

#include <iterator>
#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "core/matrix_market.h"
#include "reduction/linear/hdf5_store.h"

namespace thermotwin::reduction {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using Eigen::MatrixXd;

constexpr char format_name[] = "thermotwin reduced system";
constexpr std::int64_t version = 2;

std::string film_names(const LinearSystem& system) {
  std::string names;
  for (const ParameterMatrix& film : system.films) names += film.name + "\n";
  return names;
}

std::string lines_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += name + "\n";
  return text;
}

std::string bytes_of(const fs::path& path, const LinearSystem& system, const SystemReduction& reduction,
                     const SystemNames* names) {
  const ReducedLinearSystem& model = reduction.model;
  const Index r = model.order(), films = std::ssize(system.films), points = std::ssize(reduction.points);
  StoreWriter writer(path.string());
  writer.text_attribute("/", "format", format_name);
  writer.integer_attribute("/", "version", version);
  writer.integer_attribute("/", "order", r);
  writer.integer_attribute("/", "full_size", system.base.size());
  writer.text_attribute("/", "method", names ? names->method : word(reduction.method));
  const auto matrix = [&](const std::string& name, const MatrixXd& values, const char* columns) {
    writer.matrix("/system/" + name, values);
    writer.describe("/system/" + name, columns, "as the matrices that were given");
  };
  writer.group("/system");
  matrix("E", model.E, "(state, state)");
  matrix("A", model.A, "(state, state)");
  matrix("B", model.B, "(state, input)");
  matrix("C", model.C, "(output, state)");
  matrix("D", model.D, "(output, input)");
  writer.stack("/system/films", model.films, r, r);
  writer.describe("/system/films", "(film, state, state)", "as the matrices that were given");
  writer.text("/system/film_names", film_names(system));
  if (names) {
    writer.text("/system/input_names", lines_of(names->inputs));
    writer.text("/system/output_names", lines_of(names->outputs));
  }

  MatrixXd values(points, films), measures(points, 5);
  for (Index k = 0; k < points; ++k) {
    const PointResult& point = reduction.points[k];
    for (Index j = 0; j < films; ++j) values(k, j) = point.films[j];
    measures.row(k) << point.order, reduction.joined ? -1.0 : point.bound, point.norm.value, point.error.value,
        point.error.frequency;
  }
  writer.group("/points");
  writer.matrix("/points/films", values);
  writer.describe("/points/films", "(point, film)", "factor of the film's matrix");
  writer.matrix("/points/measures", measures);
  writer.describe("/points/measures", "order bound hinf_norm hinf_error frequency",
                  "count, gain, gain, gain, rad/s; bound -1 where there is none");
  for (Index k = 0; k < points; ++k) {
    const std::string name = fmt::format("/points/hankel_{}", k);
    writer.vector(name, reduction.points[k].hankel);
    writer.describe(name, "Hankel singular values, falling", "gain");
  }
  return writer.finish();
}

/// Files of an earlier reduced system that this one has not.
void remove_leftovers(const fs::path& folder, const std::vector<fs::path>& files) {
  std::error_code error;
  if (!fs::exists(folder / system_file_name, error)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path name = entry.path().filename();
    const bool ours =
        name == "D.mtx" || name == "names.toml" || (name.string().starts_with("A_film_") && name.extension() == ".mtx");
    if (ours && std::find(files.begin(), files.end(), name) == files.end()) fs::remove(entry.path(), error);
  }
}

}  // namespace

void check_system_folder(const fs::path& folder, const LinearSystem& system) {
  std::error_code error;
  if (fs::equivalent(folder, system.folder, error)) {
    throw core::InputError("--out " + folder.string(), "the folder of the matrices that are to be reduced",
                           "another folder");
  }
  fs::path there = fs::absolute(folder);
  while (!fs::exists(there, error) && there.has_parent_path() && there != there.parent_path())
    there = there.parent_path();
  if (!fs::is_directory(there, error)) {
    throw core::InputError("--out " + folder.string(), there.string() + " is no folder",
                           "a folder, or a place for a new one");
  }
  if (::access(there.c_str(), W_OK | X_OK) != 0)
    throw core::InputError("--out " + folder.string(), "no permission", "a folder that may be written");
}

void write_system(const fs::path& folder, const LinearSystem& system, const SystemReduction& reduction,
                  const SystemNames* names) {
  const ReducedLinearSystem& model = reduction.model;
  std::error_code error;
  const bool is_new = !fs::exists(folder, error);
  try {
    core::write_files_by(folder, [&](const fs::path& staged) {
      std::vector<fs::path> files;
      const auto add = [&](const std::string& name, const MatrixXd& matrix) {
        files.emplace_back(name + ".mtx");
        core::write_file(staged / files.back(),
                         core::format_matrix_market(matrix, fmt::format("{} of order {} for {} states", name,
                                                                        model.order(), system.base.size())));
      };
      add("E", model.E);
      add("A", model.A);
      add("B", model.B);
      add("C", model.C);
      if (system.has_feedthrough) add("D", model.D);
      for (std::size_t j = 0; j < system.films.size(); ++j) add("A_film_" + system.films[j].name, model.films[j]);
      if (!system.names_text.empty()) {
        files.emplace_back("names.toml");
        core::write_file(staged / files.back(), system.names_text);
      }
      files.emplace_back(system_file_name);
      core::write_file(staged / system_file_name, bytes_of(folder / system_file_name, system, reduction, names));
      remove_leftovers(folder, files);
      return files;
    });
  } catch (...) {
    if (is_new) fs::remove(folder, error);
    throw;
  }
}

ReducedLinearSystem read_system(const fs::path& path, std::vector<std::string>* films) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    throw core::InputError(path.string(), "no such file", "a system.rom.h5 that `thermotwin reduce --matrices` wrote");
  const StoreReader reader(path);
  if (!reader.has_attribute("format") || !reader.has_attribute("version") ||
      reader.text_attribute("format") != format_name)
    reader.fail("an HDF5 file, but not a reduced system", "a system.rom.h5 that `thermotwin reduce --matrices` wrote");
  if (reader.integer_attribute("version") != version) {
    reader.fail(fmt::format("version {} of the file", reader.integer_attribute("version")),
                fmt::format("version {} (write it anew: thermotwin reduce --matrices)", version));
  }
  const std::int64_t order = reader.integer_attribute("order");
  constexpr std::int64_t largest = 100000;
  if (order < 1 || order > largest) reader.fail(fmt::format("order {}", order), fmt::format("1 to {}", largest));
  const Index r = order;
  ReducedLinearSystem model;
  model.E = reader.matrix("/system/E", r, r);
  model.A = reader.matrix("/system/A", r, r);
  model.B = reader.matrix("/system/B", r, StoreReader::any);
  model.C = reader.matrix("/system/C", StoreReader::any, r);
  model.D = reader.matrix("/system/D", model.C.rows(), model.B.cols());
  const std::string names = reader.text("/system/film_names");
  model.films = reader.stack("/system/films", std::count(names.begin(), names.end(), '\n'), r, r);
  if (films) {
    films->clear();
    for (std::size_t from = 0, end; (end = names.find('\n', from)) != std::string::npos; from = end + 1)
      films->push_back(names.substr(from, end - from));
  }
  return model;
}

}  // namespace thermotwin::reduction
