// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/start_field_vtu.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkGenericCell.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStaticCellLocator.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <cmath>

#include "core/error.h"
#include "core/text.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/start_field.h"

namespace thermotwin::solver {
namespace {

std::vector<std::string> texts(vtkUnstructuredGrid* grid, const char* name) {
  std::vector<std::string> lines;
  if (auto* array = vtkStringArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray(name)))
    for (vtkIdType i = 0; i < array->GetNumberOfValues(); ++i) lines.push_back(array->GetValue(i));
  return lines;
}

/// The cells of one body with their points in its home frame.
vtkNew<vtkUnstructuredGrid> body_grid(vtkUnstructuredGrid* grid, vtkDataArray* body_of_cell, int body,
                                      const Eigen::Isometry3d& to_home) {
  vtkNew<vtkUnstructuredGrid> part;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(grid->GetNumberOfPoints());
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    const Eigen::Vector3d at = to_home * Eigen::Map<const Eigen::Vector3d>(grid->GetPoint(i));
    points->SetPoint(i, at.data());
  }
  part->SetPoints(points);
  part->Allocate(grid->GetNumberOfCells());
  vtkNew<vtkIdList> nodes;
  for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); ++cell) {
    if (static_cast<int>(body_of_cell->GetTuple1(cell)) != body) continue;
    grid->GetCellPoints(cell, nodes);
    part->InsertNextCell(grid->GetCellType(cell), nodes);
  }
  return part;
}

}  // namespace

StartField field_from_vtu(const std::filesystem::path& path, const mesh::MachineMesh& mesh,
                          const ThermalSystem& thermal) {
  const mesh::Machine& machine = mesh.machine;
  if (!std::filesystem::exists(path)) throw core::InputError(path.string(), "no such file", "a .vtu of fields.pvd");
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkUnstructuredGrid* grid = reader->GetOutput();
  vtkDataArray* temperature = grid && grid->GetPointData() ? grid->GetPointData()->GetArray("temperature_C") : nullptr;
  vtkDataArray* body_of_cell = grid && grid->GetCellData() ? grid->GetCellData()->GetArray("body") : nullptr;
  if (!temperature || !body_of_cell || grid->GetNumberOfCells() == 0)
    throw core::InputError(path.string(), "no cells with temperature_C and body", "a .vtu as simulate writes it");
  const std::vector<std::string> names = texts(grid, "body_names"), pose_text = texts(grid, "pose");
  const mesh::Pose pose = pose_text.empty() || pose_text.front().empty()
                              ? mesh::home_pose(machine)
                              : mesh::parse_pose(machine, pose_text.front(), path.string() + " pose");
  StartField start;
  start.temperature = Eigen::VectorXd::Zero(thermal.size);
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const auto at = std::find(names.begin(), names.end(), machine.bodies[b].id);
    if (at == names.end()) {
      throw core::InputError(path.string(), "no body '" + machine.bodies[b].id + "'",
                             "a field of this machine; it has: " + core::join(names));
    }
    const vtkNew<vtkUnstructuredGrid> part =
        body_grid(grid, body_of_cell, at - names.begin(), mesh::body_transform(machine, b, pose).inverse());
    vtkNew<vtkStaticCellLocator> locator;
    locator->SetDataSet(part);
    locator->BuildLocator();
    vtkNew<vtkGenericCell> cell;
    std::vector<double> weights(64);
    for (Eigen::Index i = 0; i < mesh.bodies[b].points.cols(); ++i) {
      Eigen::Vector3d p = mesh.bodies[b].points.col(i), nearest = p;
      double parametric[3], distance2 = 0.0;
      int sub = 0;
      vtkIdType found = locator->FindCell(p.data(), 0.0, cell, parametric, weights.data());
      if (found < 0) {
        locator->FindClosestPoint(p.data(), nearest.data(), cell, found, sub, distance2);
        if (found < 0) {
          throw core::InputError(path.string(), "body '" + machine.bodies[b].id + "' has no cells",
                                 "a field of this machine");
        }
        part->GetCell(found, cell);
        double unused;
        cell->EvaluatePosition(nearest.data(), nullptr, sub, parametric, unused, weights.data());
        start.farthest = std::max(start.farthest, std::sqrt(distance2));
      }
      double value = 0.0;
      for (vtkIdType k = 0; k < cell->GetNumberOfPoints(); ++k)
        value += weights[k] * temperature->GetTuple1(cell->GetPointId(k));
      start.temperature[mesh.first_node[b] + i] = value - machine.reference_C;
    }
  }
  set_fluids_to_walls(thermal, start.temperature);
  return start;
}

}  // namespace thermotwin::solver
