// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Content of a VTK XML file as plain data, with functions to read and write it. The VTK library is in a module that is
// loaded at run time (vtk_module.h).

#include <Eigen/Core>

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace thermotwin::mesh {

/// Types of cells that are used here, with VTK's numbers.
enum class VtkCell : std::uint8_t { vertex = 1, triangle = 5, tet = 10, triangle_6 = 22, tet_10 = 24 };

struct VtkArray {
  std::string name;
  /// Numbers (components x entries), or texts.
  std::variant<Eigen::MatrixXf, Eigen::MatrixXd, Eigen::MatrixXi, std::vector<std::string>> values;
  std::vector<std::string> components;  ///< names of the components; may be empty

  /// First component of an entry; NaN for an array of texts, or if there is no such entry.
  double number(Eigen::Index entry) const;
  /// @return the texts; empty for an array of numbers
  const std::vector<std::string>& texts() const;
};

struct VtkGrid {
  Eigen::Matrix3Xd points;
  std::vector<std::uint8_t> types;             ///< of the cells, VtkCell or any other of VTK's numbers
  std::vector<std::uint8_t> dimensions;        ///< 0 to 3, of each cell; read_vtk_grid() fills them
  std::vector<Eigen::Index> first_node = {0};  ///< (cells + 1) index into nodes of a cell's first one
  std::vector<Eigen::Index> nodes;             ///< indices into points
  std::vector<VtkArray> point_arrays, cell_arrays, fields;
  std::string shown;  ///< point array that a viewer shows first, or none

  std::size_t cells() const { return types.size(); }
  void add_cell(VtkCell type, const Eigen::VectorXi& corners, Eigen::Index first = 0);
  void add_number(const std::string& name, double value);                          ///< to the fields
  void add_texts(const std::string& name, const std::vector<std::string>& lines);  ///< to the fields
};

/// @return nullptr where no array has the name
const VtkArray* find_array(const std::vector<VtkArray>& arrays, const std::string& name);

enum class VtkFile { unstructured_grid, poly_data };

/// Loads the VTK module before child processes are forked, which then share it.
void load_vtk();

/// Writes a file with appended, compressed data. The file is complete, or it is not written.
/// @throws SolverError where VTK could not make it; InputError (disk full, no permission)
void write_vtk_file(const std::filesystem::path& path, const VtkGrid& grid, VtkFile kind);

/// Reads a VTK XML unstructured grid.
/// @param arrays  names of the arrays and fields that are wanted; others are left out
/// @throws MeshError
VtkGrid read_vtk_grid(const std::filesystem::path& path, const std::vector<std::string>& arrays);

struct VtkValues {
  Eigen::VectorXd values;  ///< (points asked for)
  double farthest = 0;     ///< largest distance from the grid of a point that was asked for, in the unit of points
};
/// Values at other points by the shape functions of the cells. A point outside of all cells gets the value at the
/// nearest point of the grid.
/// @param of_points  (points of the grid)  @param at  (3 x points asked for)  @throws InputError without cells
VtkValues interpolate(const VtkGrid& grid, const Eigen::VectorXd& of_points, const Eigen::Matrix3Xd& at);

}  // namespace thermotwin::mesh
