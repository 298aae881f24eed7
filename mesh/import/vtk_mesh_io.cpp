// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes in VTK XML files. The only file of this folder that includes VTK.
// Groups in a file: the boundary triangles follow the tetrahedra as cells of their own, once for
// each group, with cell data "group" (0: none) that counts in the field data "group_names".

#include "mesh/import/vtk_mesh_io.h"

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCell.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <cmath>

#include "core/error.h"
#include "core/file.h"
#include "mesh/body/shape.h"
#include "mesh/import/raw_mesh.h"

namespace thermotwin::mesh {

namespace {

void note_error(vtkObject*, unsigned long, void* client, void* text) {
  auto* message = static_cast<std::string*>(client);
  if (message->empty()) *message = text != nullptr ? static_cast<const char*>(text) : "error";
}

/// Keeps VTK from printing; the first message is ours.
struct ErrorCatcher {
  explicit ErrorCatcher(vtkObject* object) {
    command->SetCallback(note_error);
    command->SetClientData(&message);
    object->AddObserver("ErrorEvent", command);
  }
  vtkNew<vtkCallbackCommand> command;
  std::string message;
};

/// Names of the groups by cell or by point; empty name: no group.
class GroupNames {
public:
  GroupNames(vtkDataSetAttributes* attributes, vtkFieldData* fields) {
    vtkAbstractArray* array = attributes->GetAbstractArray("group");
    texts_ = vtkStringArray::SafeDownCast(array);
    numbers_ = vtkDataArray::SafeDownCast(array);
    names_ = vtkStringArray::SafeDownCast(fields->GetAbstractArray("group_names"));
  }
  std::string operator()(vtkIdType i) const {
    if (texts_ != nullptr) return texts_->GetValue(i);
    if (numbers_ == nullptr) return {};
    const double value = numbers_->GetComponent(i, 0);
    if (!std::isfinite(value) || value == 0.0 || std::abs(value) > 1e9) return {};
    const long number = std::lround(value);
    if (names_ != nullptr && number >= 1 && number <= names_->GetNumberOfValues()) return names_->GetValue(number - 1);
    return std::to_string(number);
  }

private:
  vtkStringArray* texts_ = nullptr;
  vtkDataArray* numbers_ = nullptr;
  vtkStringArray* names_ = nullptr;
};

}  // namespace

RawMesh read_vtu(const std::filesystem::path& path) {
  // VTK would try a missing or foreign file too and print: look first.
  const std::string text = core::read_file(path);
  if (text.find("<VTKFile") == std::string::npos || text.find("UnstructuredGrid") == std::string::npos)
    throw core::MeshError(path.string(), "not a VTK XML unstructured grid", "a .vtu file");
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  ErrorCatcher errors(reader);
  reader->SetFileName(path.c_str());
  reader->GetExecutive()->AddObserver("ErrorEvent", errors.command);
  reader->SetReaderErrorObserver(errors.command);
  reader->SetParserErrorObserver(errors.command);
  reader->Update();
  vtkUnstructuredGrid* grid = reader->GetOutput();
  if (!errors.message.empty() || grid == nullptr)
    throw core::MeshError(path.string(), "unreadable (" + errors.message.substr(0, 200) + ")", "a complete .vtu file");

  RawMesh raw;
  raw.source = path.string();
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    double x[3];
    grid->GetPoint(i, x);
    raw.points.emplace_back(x[0], x[1], x[2]);
    raw.node_labels.push_back(i);
  }
  const GroupNames by_cell(grid->GetCellData(), grid->GetFieldData()),
      by_point(grid->GetPointData(), grid->GetFieldData());
  vtkNew<vtkIdList> nodes;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    const int type = grid->GetCellType(c);
    grid->GetCellPoints(c, nodes);
    const auto node = [&](vtkIdType i) {
      const vtkIdType id = i < nodes->GetNumberOfIds() ? nodes->GetId(i) : -1;
      if (id < 0 || id >= grid->GetNumberOfPoints()) {
        throw core::MeshError(path.string(), fmt::format("cell {} refers to a point that does not exist", c),
                              "points of the file");
      }
      return static_cast<int>(id);
    };
    const std::string group = by_cell(c);
    if (type == VTK_TETRA || type == VTK_QUADRATIC_TETRA) {
      if (!group.empty()) raw.element_sets[group].push_back(raw.tets.size());
      raw.tets.push_back({node(0), node(1), node(2), node(3)});
      raw.tet_labels.push_back(c);
      if (type == VTK_QUADRATIC_TETRA) raw.edges.push_back({node(4), node(5), node(6), node(7), node(8), node(9)});
    } else if (type == VTK_TRIANGLE || type == VTK_QUADRATIC_TRIANGLE) {
      if (!group.empty()) raw.face_sets[group].push_back({node(0), node(1), node(2)});
    } else if (grid->GetCell(c)->GetCellDimension() == 3) {
      throw core::MeshError(path.string(), fmt::format("cell {} is of VTK type {}", c, type), "tetrahedra (10, 24)");
    }
  }
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
    if (const std::string group = by_point(i); !group.empty()) raw.node_sets[group].push_back(i);
  return raw;
}

void write_vtu(const std::filesystem::path& path, const TetMesh& mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(mesh.nodes());
  for (Eigen::Index i = 0; i < mesh.nodes(); ++i)
    points->SetPoint(i, mesh.points(0, i), mesh.points(1, i), mesh.points(2, i));
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(points);
  vtkNew<vtkIntArray> group;
  group->SetName("group");
  vtkNew<vtkStringArray> names;
  names->SetName("group_names");
  grid->Allocate(mesh.elements());
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    const TetNodes nodes = tet_nodes(mesh, e);
    const Eigen::Matrix<vtkIdType, Eigen::Dynamic, 1> ids = nodes.cast<vtkIdType>();
    grid->InsertNextCell(mesh.order() == 2 ? VTK_QUADRATIC_TETRA : VTK_TETRA, ids.size(), ids.data());
    group->InsertNextValue(0);
  }
  for (const auto& [name, faces] : mesh.groups) {
    names->InsertNextValue(name);
    for (const int face : faces) {
      const FaceNodes nodes = face_nodes(mesh, face);
      const Eigen::Matrix<vtkIdType, Eigen::Dynamic, 1> ids = nodes.cast<vtkIdType>();
      grid->InsertNextCell(ids.size() == 6 ? VTK_QUADRATIC_TRIANGLE : VTK_TRIANGLE, ids.size(), ids.data());
      group->InsertNextValue(names->GetNumberOfValues());
    }
  }
  grid->GetCellData()->AddArray(group);
  if (names->GetNumberOfValues() > 0) grid->GetFieldData()->AddArray(names);
  // Into memory: on a full disk VTK leaves a cut-off file and reports success.
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  ErrorCatcher errors(writer);
  writer->WriteToOutputStringOn();
  writer->SetInputData(grid);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToLZ4();
  if (writer->Write() != 1 || !errors.message.empty())
    throw core::SolverError(path.string() + ": VTK could not make the file (" + errors.message.substr(0, 200) + ")");
  core::write_file(path, writer->GetOutputString());
}

}  // namespace thermotwin::mesh
