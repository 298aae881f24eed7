// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/vtk_grid.h"

#include <limits>

#include "core/error.h"
#include "core/file.h"
#include "core/module.h"
#include "mesh/import/vtk_module.h"

namespace thermotwin::mesh {

namespace {

const VtkModule& vtk_module() {
  static const VtkModule& module = core::module_table<VtkModule>("libthermotwin_vtk.so", "thermotwin_vtk", "VTK files");
  return module;
}

}  // namespace

double VtkArray::number(Eigen::Index entry) const {
  return std::visit(
      [&](const auto& held) -> double {
        if constexpr (!std::is_same_v<std::decay_t<decltype(held)>, std::vector<std::string>>) {
          if (held.rows() > 0 && entry < held.cols()) return held(0, entry);
        }
        return std::numeric_limits<double>::quiet_NaN();
      },
      values);
}

const std::vector<std::string>& VtkArray::texts() const {
  static const std::vector<std::string> none;
  const auto* held = std::get_if<std::vector<std::string>>(&values);
  return held != nullptr ? *held : none;
}

void VtkGrid::add_cell(VtkCell type, const Eigen::VectorXi& corners, Eigen::Index first) {
  types.push_back(std::uint8_t(type));
  for (const int corner : corners) nodes.push_back(first + corner);
  first_node.push_back(std::ssize(nodes));
}

void VtkGrid::add_number(const std::string& name, double value) {
  fields.push_back({name, Eigen::MatrixXd(Eigen::MatrixXd::Constant(1, 1, value)), {}});
}

void VtkGrid::add_texts(const std::string& name, const std::vector<std::string>& lines) {
  fields.push_back({name, lines, {}});
}

const VtkArray* find_array(const std::vector<VtkArray>& arrays, const std::string& name) {
  for (const VtkArray& array : arrays)
    if (array.name == name) return &array;
  return nullptr;
}

void load_vtk() { vtk_module(); }

void write_vtk_file(const std::filesystem::path& path, const VtkGrid& grid, VtkFile kind) {
  // By way of memory: on a full disk VTK leaves a cut-off file and reports success.
  core::write_file(path, vtk_module().file_bytes(grid, kind, path.string()));
}

VtkGrid read_vtk_grid(const std::filesystem::path& path, const std::vector<std::string>& arrays) {
  // VTK would try a missing or foreign file too and print: look first.
  const std::string text = core::read_file(path);
  if (text.find("<VTKFile") == std::string::npos || text.find("UnstructuredGrid") == std::string::npos)
    throw core::MeshError(path.string(), "not a VTK XML unstructured grid", "a .vtu file");
  return vtk_module().read(path, arrays);
}

VtkValues interpolate(const VtkGrid& grid, const Eigen::VectorXd& of_points, const Eigen::Matrix3Xd& at) {
  return vtk_module().interpolate(grid, of_points, at);
}

}  // namespace thermotwin::mesh
