// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/files.h"

#include <cstring>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_fields.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::solver {
namespace {

template <class Matrix>
void append(std::string& bytes, const Matrix& matrix) {
  const std::int64_t shape[2] = {matrix.rows(), matrix.cols()};
  bytes.append(reinterpret_cast<const char*>(shape), sizeof shape);
  bytes.append(reinterpret_cast<const char*>(matrix.data()), matrix.size() * sizeof(typename Matrix::Scalar));
}

/// Takes a matrix from the front of the bytes.
std::optional<Eigen::MatrixXd> take_matrix(std::string_view& bytes) {
  std::int64_t shape[2];
  if (bytes.size() < sizeof shape) return std::nullopt;
  std::memcpy(shape, bytes.data(), sizeof shape);
  if (shape[0] < 0 || shape[1] < 0 || shape[0] > 1'000'000'000 || shape[1] > 1'000'000'000) return std::nullopt;
  const std::size_t size = sizeof(double) * shape[0] * shape[1];
  if (bytes.size() < sizeof shape + size) return std::nullopt;
  Eigen::MatrixXd matrix(shape[0], shape[1]);
  std::memcpy(matrix.data(), bytes.data() + sizeof shape, size);
  bytes.remove_prefix(sizeof shape + size);
  return matrix;
}

/// Matrices in a file of their own say which result they belong to: a later result without them leaves the file.
void write_matrices(const std::filesystem::path& path, const std::string& hash,
                    const std::vector<const Eigen::MatrixXd*>& matrices) {
  std::string bytes;
  for (const Eigen::MatrixXd* matrix : matrices) append(bytes, *matrix);
  core::write_file(path, hash + core::content_hash(bytes) + bytes);
}

/// @return false if there is no such file, it belongs to another result, or it is damaged
bool read_matrices(const std::filesystem::path& path, const std::string& hash,
                   const std::vector<Eigen::MatrixXd*>& matrices) {
  if (!std::filesystem::exists(path)) return false;
  const std::string bytes = core::read_file(path);
  if (!bytes.starts_with(hash)) return false;
  std::string_view rest = std::string_view(bytes).substr(hash.size());
  const std::string_view sum = rest.substr(0, hash.size());
  rest.remove_prefix(sum.size());
  if (sum != core::content_hash(rest)) return false;
  for (Eigen::MatrixXd* matrix : matrices) {
    auto taken = take_matrix(rest);
    if (!taken) return false;
    *matrix = std::move(*taken);
  }
  return rest.empty();
}

/// Tables in the order of `done`.
constexpr const char* tables[] = {"tcp.csv", "sensors.csv", "inputs.csv", "heat.csv"};

/// What `done` says: what made the result, and that its tables are still the ones that were made.
std::string stamp(const std::filesystem::path& folder, const std::string& hash) {
  std::string bytes;
  for (const char* name : tables) bytes += core::content_hash(core::read_file(folder / name));
  return hash + "\n" + core::content_hash(bytes) + "\n";
}

}  // namespace

std::string hash_of_mesh(const mesh::MachineMesh& mesh) {
  std::string bytes;
  for (const mesh::TetMesh& body : mesh.bodies) {
    append(bytes, body.points);
    append(bytes, body.tets);
    append(bytes, body.tet_edges);
  }
  return core::content_hash(bytes);
}

std::string hash_of_load(const FullModel& model, const std::string& mesh_hash, const LoadProgram& load,
                         const std::vector<mesh::Pose>& poses, const CampaignOptions& options) {
  std::string bytes = "campaign 4 " + model.mesh.machine.hash + mesh_hash + load.name();
  const TimeOptions time = load.time();
  bytes += word(time.scheme);
  if (time.scheme == TimeScheme::adaptive)
    append(bytes, Eigen::Vector4d(time.tolerance_K, time.shortest_step, time.longest_step, options.refine));
  append(bytes, options.start);
  bytes += model.thermal.solver == LinearSolver::direct ? "heat direct " : "heat iterative ";
  bytes += model.elastic.summary().solver == LinearSolver::direct ? "elasticity direct" : "elasticity iterative";
  // The program as the model sees it: every step and its row.
  const std::vector<double> ends = load.step_ends(options.refine), outputs = load.output_times();
  append(bytes, Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(ends.data(), std::ssize(ends))));
  append(bytes, Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(outputs.data(), std::ssize(outputs))));
  append(bytes, Eigen::VectorXd::Constant(1, load.initial_C()).eval());
  double from = 0.0;
  for (double end : ends) append(bytes, load.row(from, end)), from = end;
  for (const mesh::Pose& pose : poses) append(bytes, pose);
  return core::content_hash(bytes);
}

std::string hash_of_block(const std::vector<std::string>& hashes_of_loads) {
  std::string bytes;
  for (const std::string& hash : hashes_of_loads) bytes += hash;
  return core::content_hash(bytes);
}

void write_result(const std::filesystem::path& folder, LoadResult& result, const std::string& hash) {
  core::write_files_by(folder, [&](const std::filesystem::path& staged) {
    std::vector<std::filesystem::path> files;
    core::Table* made[] = {&result.tcp, &result.sensors, &result.inputs, &result.heat_flows};
    for (std::size_t i = 0; i < std::size(tables); ++i) {
      core::write_csv(staged / tables[i], *made[i], table_digits);
      *made[i] = core::read_csv(staged / tables[i]);
      files.emplace_back(tables[i]);
    }
    if (result.snapshots.size() > 0) {
      write_matrices(staged / "snapshots.bin", hash, {&result.snapshots});
      files.emplace_back("snapshots.bin");
    }
    if (result.fields.modes.size() > 0) {
      write_matrices(staged / "fields.bin", hash, {&result.fields.modes, &result.fields.coefficients});
      files.emplace_back("fields.bin");
    }
    core::write_file(staged / "done", stamp(staged, hash));
    files.emplace_back("done");
    return files;
  });
}

std::optional<LoadResult> read_result(const std::filesystem::path& folder, const std::string& load,
                                      const std::string& hash, const CampaignOptions& options) {
  LoadResult result;
  result.load = load;
  try {
    if (!std::filesystem::exists(folder / "done") || core::read_file(folder / "done") != stamp(folder, hash))
      return std::nullopt;
    if (options.keep_snapshots && !read_matrices(folder / "snapshots.bin", hash, {&result.snapshots}))
      return std::nullopt;
    if (options.field_modes > 0 &&
        !read_matrices(folder / "fields.bin", hash, {&result.fields.modes, &result.fields.coefficients})) {
      // A reduction left all temperatures: fields come from them, with the same bits.
      Eigen::MatrixXd all;
      if (!read_matrices(folder / "snapshots.bin", hash, {&all})) return std::nullopt;
      const Eigen::MatrixXd kept = all(Eigen::all, thinned(all.cols(), LoadFields::most_times));
      result.fields = compressed(kept, options.field_modes);
    }
    result.tcp = core::read_csv(folder / "tcp.csv");
    result.sensors = core::read_csv(folder / "sensors.csv");
    result.inputs = core::read_csv(folder / "inputs.csv");
    result.heat_flows = core::read_csv(folder / "heat.csv");
  } catch (const core::InputError&) {
    return std::nullopt;  // a damaged folder is run anew
  }
  return result;
}

Unused why_unused(const std::filesystem::path& folder, const std::string& hash) {
  if (!std::filesystem::exists(folder / "done")) return Unused::none_there;
  try {
    const std::string done = core::read_file(folder / "done");
    if (!done.starts_with(hash + "\n")) return Unused::other_inputs;
    return done == stamp(folder, hash) ? Unused::no_temperatures : Unused::changed_tables;
  } catch (const core::InputError&) {
    return Unused::changed_tables;
  }
}

std::optional<LoadResult> read_result(const std::filesystem::path& folder, const std::string& load,
                                      const CampaignOptions& options) {
  if (!std::filesystem::exists(folder / "done")) return std::nullopt;
  const std::string made_of = core::read_file(folder / "done");
  return read_result(folder, load, made_of.substr(0, made_of.find('\n')), options);
}

std::vector<std::filesystem::path> result_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files(std::begin(tables), std::end(tables));
  for (const char* matrices : {"snapshots.bin", "fields.bin"})
    if (std::filesystem::exists(folder / matrices)) files.emplace_back(matrices);
  files.emplace_back("done");
  return files;
}

}  // namespace thermotwin::solver
