// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/vtk_output.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "mesh/body/shape.h"
#include "mesh/machine/kinematics.h"
#include "solver/elastic/stress.h"

namespace thermotwin::solver {
namespace {

void add_number(vtkFieldData* fields, const std::string& name, double value) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name.c_str());
  array->InsertNextValue(value);
  fields->AddArray(array);
}

void add_text(vtkFieldData* fields, const std::string& name, const std::vector<std::string>& lines) {
  vtkNew<vtkStringArray> array;
  array->SetName(name.c_str());
  for (const std::string& line : lines) array->InsertNextValue(line);
  fields->AddArray(array);
}

vtkNew<vtkFloatArray> vector_array(const char* name, vtkIdType tuples, int components = 3) {
  vtkNew<vtkFloatArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(tuples);
  return array;
}

/// Point arrays of the stress, turned from the bodies' frames into the machine's.
void add_stress(vtkUnstructuredGrid* grid, const mesh::MachineMesh& mesh, const mesh::Pose& pose,
                const Eigen::MatrixXd& stress) {
  constexpr double mega = 1e6;
  auto tensor = vector_array("stress_MPa", mesh.nodes(), 6), mises = vector_array("von_mises_MPa", mesh.nodes(), 1);
  const char* components[] = {"xx", "yy", "zz", "xy", "yz", "zx"};
  for (int i = 0; i < 6; ++i) tensor->SetComponentName(i, components[i]);
  const Eigen::VectorXd equivalent = von_mises(stress);
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const Eigen::Matrix3d turn = mesh::body_transform(mesh.machine, b, pose).linear();
    for (Eigen::Index node = mesh.first_node[b]; node < mesh.first_node[b + 1]; ++node) {
      const Vector6 in_machine = turned(stress.col(node), turn) / mega;
      tensor->SetTuple(node, in_machine.data());
      mises->SetValue(node, static_cast<float>(equivalent[node] / mega));
    }
  }
  grid->GetPointData()->AddArray(tensor);
  grid->GetPointData()->AddArray(mises);
}

template <class Writer, class Data>
void write_by(const std::filesystem::path& path, Data* data) {
  // Into memory: on a full disk VTK leaves a cut-off file and reports success.
  vtkNew<Writer> writer;
  writer->WriteToOutputStringOn();
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToLZ4();
  if (writer->Write() != 1) throw core::SolverError(path.string() + ": VTK could not make the file (out of memory)");
  core::write_file(path, writer->GetOutputString());
}

}  // namespace

void write_fields(const std::filesystem::path& path, const mesh::MachineMesh& mesh, const mesh::Pose& pose,
                  const Eigen::VectorXd& temperature_C, const Eigen::Matrix3Xd& displacement, double time_s,
                  const Eigen::MatrixXd& stress) {
  const mesh::Machine& machine = mesh.machine;
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(mesh.nodes());
  vtkNew<vtkFloatArray> temperature;
  temperature->SetName("temperature_C");
  temperature->SetNumberOfTuples(mesh.nodes());
  auto moved = vector_array("displacement_um", mesh.nodes());
  vtkNew<vtkIntArray> body_of_cell;
  body_of_cell->SetName("body");
  Eigen::Index cells = 0;
  for (const mesh::TetMesh& body : mesh.bodies) cells += body.elements();
  grid->Allocate(cells);
  std::vector<std::string> names;
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const mesh::TetMesh& body = mesh.bodies[b];
    const Eigen::Isometry3d frame = mesh::body_transform(machine, b, pose);
    names.push_back(machine.bodies[b].id);
    for (Eigen::Index i = 0; i < body.nodes(); ++i) {
      const Eigen::Index node = mesh.first_node[b] + i;
      const Eigen::Vector3d at = frame * body.points.col(i);
      points->SetPoint(node, at.data());
      temperature->SetValue(node, static_cast<float>(temperature_C[node]));
      if (displacement.cols() == 0) continue;
      const Eigen::Vector3d u = frame.linear() * displacement.col(node) / core::units::um;
      moved->SetTuple(node, u.data());
    }
    for (Eigen::Index e = 0; e < body.elements(); ++e) {
      const mesh::TetNodes nodes = mesh::tet_nodes(body, e);
      const Eigen::Matrix<vtkIdType, Eigen::Dynamic, 1> tet = nodes.cast<vtkIdType>().array() + mesh.first_node[b];
      grid->InsertNextCell(body.order() == 2 ? VTK_QUADRATIC_TETRA : VTK_TETRA, tet.size(), tet.data());
      body_of_cell->InsertNextValue(b);
    }
  }
  grid->SetPoints(points);
  grid->GetPointData()->AddArray(temperature);
  if (displacement.cols() > 0) grid->GetPointData()->AddArray(moved);
  if (stress.cols() > 0) add_stress(grid, mesh, pose, stress);
  grid->GetPointData()->SetActiveScalars("temperature_C");
  grid->GetCellData()->AddArray(body_of_cell);
  add_number(grid->GetFieldData(), "TimeValue", time_s);
  add_text(grid->GetFieldData(), "pose", {mesh::format_pose(machine, pose)});
  add_text(grid->GetFieldData(), "machine", {machine.name});
  add_text(grid->GetFieldData(), "body_names", names);
  const auto columns = mesh::pose_columns(machine);
  const Eigen::VectorXd values = mesh::pose_values(machine, pose);
  for (std::size_t i = 0; i < columns.size(); ++i) add_number(grid->GetFieldData(), columns[i], values[i]);
  write_by<vtkXMLUnstructuredGridWriter>(path, grid.Get());
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
  const vtkIdType count = std::ssize(poses);
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  auto error = vector_array("error_um", count), tool = vector_array("error_tool_um", count);
  auto table = vector_array("error_table_um", count), rotation = vector_array("rotation_um_per_m", count);
  data->AllocateExact(count, count);
  data->SetPoints(points);
  std::vector<vtkNew<vtkDoubleArray>> axes(mesh::pose_columns(machine).size());
  for (std::size_t a = 0; a < axes.size(); ++a) axes[a]->SetName(mesh::pose_columns(machine)[a].c_str());
  for (vtkIdType i = 0; i < count; ++i) {
    const mesh::Pose& pose = poses[i];
    const Eigen::VectorXd values = tcp_values(errors[i]);
    points->SetPoint(i, tcp_position(machine, pose).data());
    error->SetTuple(i, values.data());
    rotation->SetTuple(i, values.data() + 3);
    tool->SetTuple(i, values.data() + 6);
    table->SetTuple(i, values.data() + 12);
    const Eigen::VectorXd positions = mesh::pose_values(machine, pose);
    for (std::size_t a = 0; a < axes.size(); ++a) axes[a]->InsertNextValue(positions[a]);
    data->InsertNextCell(VTK_VERTEX, 1, &i);
  }
  for (vtkFloatArray* array : {error.Get(), rotation.Get(), tool.Get(), table.Get()})
    data->GetPointData()->AddArray(array);
  for (auto& axis : axes) data->GetPointData()->AddArray(axis);
  data->GetPointData()->SetActiveVectors("error_um");
  write_by<vtkXMLPolyDataWriter>(path, data.Get());
}

}  // namespace thermotwin::solver
