// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/vtk_files.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <cmath>
#include <stdexcept>

namespace thermotwin::cases {
namespace {

std::vector<std::string> names(vtkFieldData* data) {
  std::vector<std::string> found;
  for (int i = 0; i < data->GetNumberOfArrays(); ++i) found.emplace_back(data->GetArrayName(i));
  return found;
}

template <class Reader>
VtkFile read_by(const std::filesystem::path& file) {
  vtkNew<Reader> reader;
  if (!reader->CanReadFile(file.c_str())) throw std::runtime_error(file.string() + " is no file of this kind");
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkDataSet* data = reader->GetOutput();
  if (reader->GetErrorCode() != 0 || data == nullptr) throw std::runtime_error(file.string() + " cannot be read");
  VtkFile found;
  found.points = static_cast<long>(data->GetNumberOfPoints());
  found.cells = static_cast<long>(data->GetNumberOfCells());
  found.point_arrays = names(data->GetPointData());
  found.cell_arrays = names(data->GetCellData());
  found.field_arrays = names(data->GetFieldData());
  if (vtkDataArray* time = data->GetFieldData()->GetArray("TimeValue")) found.time = time->GetComponent(0, 0);
  if (vtkDataArray* temperature = data->GetPointData()->GetArray("temperature_C")) {
    found.lowest_C = temperature->GetRange()[0];
    found.highest_C = temperature->GetRange()[1];
  }
  for (int i = 0; i < data->GetPointData()->GetNumberOfArrays(); ++i) {
    vtkDataArray* array = data->GetPointData()->GetArray(i);
    for (vtkIdType t = 0; array != nullptr && t < array->GetNumberOfTuples(); ++t) {
      for (int c = 0; c < array->GetNumberOfComponents(); ++c)
        found.finite = found.finite && std::isfinite(array->GetComponent(t, c));
    }
  }
  return found;
}

}  // namespace

VtkFile read_vtk(const std::filesystem::path& file) {
  return file.extension() == ".vtp" ? read_by<vtkXMLPolyDataReader>(file) : read_by<vtkXMLUnstructuredGridReader>(file);
}

}  // namespace thermotwin::cases
