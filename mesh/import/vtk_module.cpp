// SPDX-License-Identifier: GPL-3.0-or-later
// The only file that includes VTK, but for the one that draws pictures: the module of vtk_module.h.

#include "mesh/import/vtk_module.h"

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkGenericCell.h>
#include <vtkIdList.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

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

// ---------------------------------------------------------------- from plain data

template <class Array, class Matrix>
vtkSmartPointer<vtkAbstractArray> numbers(const Matrix& values) {
  vtkNew<Array> array;
  array->SetNumberOfComponents(values.rows());
  array->SetNumberOfTuples(values.cols());
  std::copy(values.data(), values.data() + values.size(), array->GetPointer(0));
  return array.Get();
}

struct MadeArray {
  vtkSmartPointer<vtkAbstractArray> operator()(const Eigen::MatrixXf& values) const {
    return numbers<vtkFloatArray>(values);
  }
  vtkSmartPointer<vtkAbstractArray> operator()(const Eigen::MatrixXd& values) const {
    return numbers<vtkDoubleArray>(values);
  }
  vtkSmartPointer<vtkAbstractArray> operator()(const Eigen::MatrixXi& values) const {
    return numbers<vtkIntArray>(values);
  }
  vtkSmartPointer<vtkAbstractArray> operator()(const std::vector<std::string>& values) const {
    vtkNew<vtkStringArray> array;
    for (const std::string& line : values) array->InsertNextValue(line);
    return array.Get();
  }
};

void add_arrays(const std::vector<VtkArray>& arrays, vtkFieldData* to) {
  for (const VtkArray& array : arrays) {
    const vtkSmartPointer<vtkAbstractArray> made = std::visit(MadeArray(), array.values);
    made->SetName(array.name.c_str());
    for (std::size_t i = 0; i < array.components.size(); ++i)
      made->SetComponentName(vtkIdType(i), array.components[i].c_str());
    to->AddArray(made);
  }
}

/// @param data  vtkUnstructuredGrid or vtkPolyData
template <class Data>
void fill(const VtkGrid& grid, Data* data) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(grid.points.cols());
  for (Eigen::Index i = 0; i < grid.points.cols(); ++i) points->SetPoint(i, grid.points.col(i).data());
  data->SetPoints(points);
  data->AllocateEstimate(vtkIdType(grid.cells()), 4);
  for (std::size_t c = 0; c < grid.cells(); ++c) {
    const std::vector<vtkIdType> ids(grid.nodes.begin() + grid.first_node[c],
                                     grid.nodes.begin() + grid.first_node[c + 1]);
    data->InsertNextCell(grid.types[c], vtkIdType(ids.size()), ids.data());
  }
  add_arrays(grid.point_arrays, data->GetPointData());
  add_arrays(grid.cell_arrays, data->GetCellData());
  add_arrays(grid.fields, data->GetFieldData());
  if (grid.shown.empty()) return;
  const vtkDataArray* shown = data->GetPointData()->GetArray(grid.shown.c_str());
  if (shown != nullptr && shown->GetNumberOfComponents() == 3)
    data->GetPointData()->SetActiveVectors(grid.shown.c_str());
  else
    data->GetPointData()->SetActiveScalars(grid.shown.c_str());
}

template <class Writer, class Data>
std::string bytes_by(const VtkGrid& grid, const std::string& place) {
  vtkNew<Data> data;
  fill(grid, data.Get());
  vtkNew<Writer> writer;
  ErrorCatcher errors(writer);
  writer->WriteToOutputStringOn();
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToLZ4();
  if (writer->Write() != 1 || !errors.message.empty())
    throw core::SolverError(place + ": VTK could not make the file (" + errors.message.substr(0, 200) + ")");
  return writer->GetOutputString();
}

std::string file_bytes(const VtkGrid& grid, VtkFile kind, const std::string& place) {
  return kind == VtkFile::poly_data ? bytes_by<vtkXMLPolyDataWriter, vtkPolyData>(grid, place)
                                    : bytes_by<vtkXMLUnstructuredGridWriter, vtkUnstructuredGrid>(grid, place);
}

// ---------------------------------------------------------------- to plain data

std::vector<VtkArray> wanted_arrays(vtkFieldData* from, const std::vector<std::string>& names) {
  std::vector<VtkArray> arrays;
  for (const std::string& name : names) {
    vtkAbstractArray* found = from->GetAbstractArray(name.c_str());
    if (auto* texts = vtkStringArray::SafeDownCast(found)) {
      std::vector<std::string> lines;
      for (vtkIdType i = 0; i < texts->GetNumberOfValues(); ++i) lines.push_back(texts->GetValue(i));
      arrays.push_back({name, std::move(lines), {}});
    } else if (auto* held = vtkDataArray::SafeDownCast(found)) {
      Eigen::MatrixXd values(held->GetNumberOfComponents(), held->GetNumberOfTuples());
      for (Eigen::Index i = 0; i < values.cols(); ++i)
        for (int k = 0; k < values.rows(); ++k) values(k, i) = held->GetComponent(i, k);
      arrays.push_back({name, std::move(values), {}});
    }
  }
  return arrays;
}

VtkGrid read(const std::filesystem::path& path, const std::vector<std::string>& arrays) {
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
  VtkGrid read;
  read.points.resize(3, grid->GetNumberOfPoints());
  for (Eigen::Index i = 0; i < read.points.cols(); ++i) grid->GetPoint(i, read.points.col(i).data());
  vtkNew<vtkIdList> nodes;
  vtkNew<vtkGenericCell> cell;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    const int type = grid->GetCellType(c);
    grid->GetCellPoints(c, nodes);
    for (vtkIdType i = 0; i < nodes->GetNumberOfIds(); ++i) {
      const vtkIdType node = nodes->GetId(i);
      if (node < 0 || node >= grid->GetNumberOfPoints()) {
        throw core::MeshError(path.string(), fmt::format("cell {} refers to a point that does not exist", c),
                              "points of the file");
      }
      read.nodes.push_back(node);
    }
    read.first_node.push_back(std::ssize(read.nodes));
    read.types.push_back(std::uint8_t(type));
    if (cell->GetCellType() != type) cell->SetCellType(type);
    read.dimensions.push_back(std::uint8_t(cell->GetCellDimension()));
  }
  read.point_arrays = wanted_arrays(grid->GetPointData(), arrays);
  read.cell_arrays = wanted_arrays(grid->GetCellData(), arrays);
  read.fields = wanted_arrays(grid->GetFieldData(), arrays);
  return read;
}

VtkValues interpolated(const VtkGrid& grid, const Eigen::VectorXd& of_points, const Eigen::Matrix3Xd& at) {
  vtkNew<vtkUnstructuredGrid> made;
  fill(grid, made.Get());
  vtkNew<vtkStaticCellLocator> locator;
  locator->SetDataSet(made);
  locator->BuildLocator();
  vtkNew<vtkGenericCell> cell;
  std::vector<double> weights(64);
  VtkValues result;
  result.values.setZero(at.cols());
  for (Eigen::Index i = 0; i < at.cols(); ++i) {
    Eigen::Vector3d p = at.col(i), nearest = p;
    double parametric[3], distance2 = 0.0;
    int sub = 0;
    vtkIdType found = locator->FindCell(p.data(), 0.0, cell, parametric, weights.data());
    if (found < 0) {
      locator->FindClosestPoint(p.data(), nearest.data(), cell, found, sub, distance2);
      if (found < 0) throw core::InputError("interpolation", "no cells", "a grid with cells");
      made->GetCell(found, cell);
      double unused;
      cell->EvaluatePosition(nearest.data(), nullptr, sub, parametric, unused, weights.data());
      result.farthest = std::max(result.farthest, std::sqrt(distance2));
    }
    for (vtkIdType k = 0; k < cell->GetNumberOfPoints(); ++k)
      result.values[i] += weights[k] * of_points[cell->GetPointId(k)];
  }
  return result;
}

}  // namespace
}  // namespace thermotwin::mesh

extern "C" const thermotwin::mesh::VtkModule* thermotwin_vtk() {
  using namespace thermotwin::mesh;
  static const VtkModule functions{file_bytes, read, interpolated};
  return &functions;
}
