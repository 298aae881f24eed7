// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/resources.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "mesh/machine_mesh.h"
#include "study/units/unit_files.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;

constexpr double bytes_per_number = 14.0;  // of a table, with its comma
// Half of what `simulate` took on cases/vmc5, coarse, linear tetrahedra: 0.33 GiB with 19,021 nodes.
constexpr double bytes_per_node = 6e3;
constexpr double process_bytes = 50e6;

}  // namespace

std::vector<std::size_t> pending_units(const fs::path& study, const std::vector<Unit>& units, const Part& part) {
  std::vector<std::size_t> pending;
  for (std::size_t u = part.index; u < units.size(); u += part.of)
    if (!has_result(study, units[u])) pending.push_back(u);
  return pending;
}

double table_bytes(double numbers) { return bytes_per_number * numbers; }

Eigen::Index nodes_of_mesh(const mesh::Machine& machine, double size_factor, const fs::path& cache) {
  try {
    return mesh::build_machine_mesh(machine, {size_factor, cache}).nodes();
  } catch (const core::MeshError&) {
    return 0;
  }
}

double model_bytes(Eigen::Index nodes) { return nodes > 0 ? process_bytes + bytes_per_node * nodes : 0.0; }

double free_disk(fs::path folder) {
  std::error_code error;
  for (folder = fs::absolute(folder); !fs::exists(folder, error) && folder.has_relative_path();)
    folder = folder.parent_path();
  const fs::space_info space = fs::space(folder, error);
  return error ? std::numeric_limits<double>::infinity() : 1.0 * space.available;
}

void require_disk(const fs::path& study, double bytes) {
  const double available = free_disk(study);
  if (available >= bytes) return;
  throw core::InputError(
      study.string(), fmt::format("the tables take {:.3g} GiB, {:.3g} GiB are available", bytes / GiB, available / GiB),
      "a disk with room for them, or fewer or shorter runs");
}

void require_memory(const MemoryWanted& wanted, const std::string& place, double available_bytes) {
  if (wanted.bytes <= available_bytes) return;
  throw core::InputError(place,
                         fmt::format("{} need {:.3g} GiB, {:.3g} GiB of memory are available", wanted.words,
                                     wanted.bytes / GiB, available_bytes / GiB),
                         wanted.remedy);
}

}  // namespace thermotwin::study
