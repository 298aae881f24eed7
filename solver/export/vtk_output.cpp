// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/vtk_output.h"

#include <fmt/format.h>

#include "core/file.h"
#include "core/units.h"
#include "mesh/body/shape.h"
#include "mesh/import/vtk_grid.h"
#include "mesh/machine/kinematics.h"
#include "solver/elastic/stress.h"

namespace thermotwin::solver {
namespace {

using mesh::VtkArray;
using mesh::VtkCell;
using mesh::VtkGrid;

/// Point arrays of the stress, turned from the bodies' frames into the machine's.
void add_stress(VtkGrid& grid, const mesh::MachineMesh& mesh, const mesh::Pose& pose, const Eigen::MatrixXd& stress) {
  constexpr double mega = 1e6;
  Eigen::MatrixXf tensor(6, mesh.nodes());
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const Eigen::Matrix3d turn = mesh::body_transform(mesh.machine, b, pose).linear();
    for (Eigen::Index node = mesh.first_node[b]; node < mesh.first_node[b + 1]; ++node)
      tensor.col(node) = (turned(stress.col(node), turn) / mega).cast<float>();
  }
  const Eigen::MatrixXf equivalent = (von_mises(stress).transpose() / mega).cast<float>();
  grid.point_arrays.push_back({"stress_MPa", tensor, {"xx", "yy", "zz", "xy", "yz", "zx"}});
  grid.point_arrays.push_back({"von_mises_MPa", equivalent, {}});
}

}  // namespace

void write_fields(const std::filesystem::path& path, const mesh::MachineMesh& mesh, const mesh::Pose& pose,
                  const Eigen::VectorXd& temperature_C, const Eigen::Matrix3Xd& displacement, double time_s,
                  const Eigen::MatrixXd& stress) {
  const mesh::Machine& machine = mesh.machine;
  VtkGrid grid;
  grid.points.resize(3, mesh.nodes());
  Eigen::MatrixXf moved(3, displacement.cols());
  std::vector<int> body_of_cell;
  std::vector<std::string> names;
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const mesh::TetMesh& body = mesh.bodies[b];
    const Eigen::Isometry3d frame = mesh::body_transform(machine, b, pose);
    names.push_back(machine.bodies[b].id);
    const Eigen::Index first = mesh.first_node[b], count = body.nodes();
    for (Eigen::Index i = 0; i < count; ++i) grid.points.col(first + i) = frame * body.points.col(i);
    if (displacement.cols() > 0) {
      moved.middleCols(first, count) =
          (frame.linear() * displacement.middleCols(first, count) / core::units::um).cast<float>();
    }
    for (Eigen::Index e = 0; e < body.elements(); ++e)
      grid.add_cell(body.order() == 2 ? VtkCell::tet_10 : VtkCell::tet, mesh::tet_nodes(body, e), first);
    body_of_cell.resize(grid.cells(), b);
  }
  grid.point_arrays.push_back(
      {"temperature_C", Eigen::MatrixXf(temperature_C.head(mesh.nodes()).transpose().cast<float>()), {}});
  if (displacement.cols() > 0) grid.point_arrays.push_back({"displacement_um", moved, {}});
  if (stress.cols() > 0) add_stress(grid, mesh, pose, stress);
  grid.shown = "temperature_C";
  const Eigen::MatrixXi bodies = Eigen::Map<const Eigen::RowVectorXi>(body_of_cell.data(), std::ssize(body_of_cell));
  grid.cell_arrays.push_back({"body", bodies, {}});
  grid.add_number("TimeValue", time_s);
  grid.add_texts("pose", {mesh::format_pose(machine, pose)});
  grid.add_texts("machine", {machine.name});
  grid.add_texts("body_names", names);
  const auto columns = mesh::pose_columns(machine);
  const Eigen::VectorXd values = mesh::pose_values(machine, pose);
  for (std::size_t i = 0; i < columns.size(); ++i) grid.add_number(columns[i], values[i]);
  mesh::write_vtk_file(path, grid, mesh::VtkFile::unstructured_grid);
}

void write_pvd(const std::filesystem::path& path, const std::vector<std::pair<double, std::string>>& files) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  "
      "<Collection>\n";
  for (const auto& [time, file] : files)
    text += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time, file);
  core::write_file(path, text + "  </Collection>\n</VTKFile>\n");
}

void write_poses(const std::filesystem::path& path, const mesh::Machine& machine, const std::vector<mesh::Pose>& poses,
                 const std::vector<TcpError>& errors) {
  const Eigen::Index count = std::ssize(poses);
  const auto columns = mesh::pose_columns(machine);
  VtkGrid grid;
  grid.points.resize(3, count);
  Eigen::MatrixXf of_pose(12, count);  // error, rotation, error of the tool side, of the table side
  Eigen::MatrixXd positions(std::ssize(columns), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    grid.points.col(i) = tcp_position(machine, poses[i]);
    const Eigen::VectorXd values = tcp_values(errors[i]);
    of_pose.col(i) << values.head(9).cast<float>(), values.segment(12, 3).cast<float>();
    positions.col(i) = mesh::pose_values(machine, poses[i]);
    grid.add_cell(VtkCell::vertex, Eigen::VectorXi::Zero(1), i);
  }
  const auto rows = [&](Eigen::Index first) { return Eigen::MatrixXf(of_pose.middleRows(first, 3)); };
  grid.point_arrays = {VtkArray{"error_um", rows(0), {}}, VtkArray{"rotation_um_per_m", rows(3), {}},
                       VtkArray{"error_tool_um", rows(6), {}}, VtkArray{"error_table_um", rows(9), {}}};
  for (std::size_t a = 0; a < columns.size(); ++a)
    grid.point_arrays.push_back({columns[a], Eigen::MatrixXd(positions.row(a)), {}});
  grid.shown = "error_um";
  mesh::write_vtk_file(path, grid, mesh::VtkFile::poly_data);
}

}  // namespace thermotwin::solver
