// SPDX-License-Identifier: GPL-3.0-or-later
// The module that draws, with VTK's renderer.

#include "solver/export/vtk_picture_module.h"

#include <Eigen/Geometry>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkFeatureEdges.h>
#include <vtkFloatArray.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <array>

namespace thermotwin::solver {
namespace {

constexpr int width = 1400, height = 1000;
constexpr double sharp_angle_deg = 35.0;

vtkNew<vtkPolyData> skin_of(const PictureScene& scene) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> temperature;
  temperature->SetName("temperature_C");
  for (Eigen::Index i = 0; i < scene.points.cols(); ++i) {
    points->InsertNextPoint(scene.points.col(i).data());
    temperature->InsertNextValue(scene.temperature_C[i]);
  }
  vtkNew<vtkCellArray> triangles;
  for (const auto& corners : scene.triangles.colwise()) {
    const vtkIdType ids[3] = {corners[0], corners[1], corners[2]};
    triangles->InsertNextCell(3, ids);
  }
  vtkNew<vtkPolyData> skin;
  skin->SetPoints(points);
  skin->SetPolys(triangles);
  skin->GetPointData()->SetScalars(temperature);
  return skin;
}

/// Blue is cold, red is hot, light grey between.
vtkNew<vtkColorTransferFunction> colours(double low, double high) {
  vtkNew<vtkColorTransferFunction> map;
  map->SetColorSpaceToDiverging();
  map->AddRGBPoint(low, 0.23, 0.30, 0.75);
  map->AddRGBPoint(high, 0.71, 0.02, 0.15);
  map->Build();
  return map;
}

void style(vtkTextProperty* text, int size) {
  text->SetFontFamilyToArial();
  text->SetFontSize(size);
  text->SetColor(0.1, 0.1, 0.12);
  text->SetBold(false);
  text->SetItalic(false);
  text->SetShadow(false);
}

/// Isometric view from the front right; the picture leaves room for caption, note and scalar bar.
void look_at(vtkPolyData* skin, vtkRenderer* renderer) {
  const Eigen::Vector3d towards = Eigen::Vector3d(1.0, -1.3, 0.85).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitZ().cross(towards).normalized();
  const Eigen::Vector3d up = towards.cross(right);
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (vtkIdType i = 0; i < skin->GetNumberOfPoints(); ++i) {
    const Eigen::Vector3d p(skin->GetPoint(i));
    const Eigen::Vector3d seen(p.dot(right), p.dot(up), p.dot(towards));
    low = low.cwiseMin(seen);
    high = high.cwiseMax(seen);
  }
  const Eigen::Vector3d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  const Eigen::Vector3d focus = middle[0] * right + middle[1] * up + middle[2] * towards;
  const Eigen::Vector3d position = focus + (2.0 * half.norm() + 1.0) * towards;
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(focus.data());
  camera->SetPosition(position.data());
  camera->SetViewUp(up.data());
  camera->SetParallelScale(std::max(half[1] / 0.86, half[0] / (0.80 * width / height)));
  camera->SetWindowCenter(0.12, 0.0);
  renderer->ResetCameraClippingRange();
}

vtkNew<vtkActor> coloured(vtkPolyData* skin, vtkColorTransferFunction* map, double low, double high) {
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(skin);
  normals->SetFeatureAngle(sharp_angle_deg);
  normals->SplittingOn();
  normals->ConsistencyOff();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(normals->GetOutputPort());
  mapper->SetLookupTable(map);
  mapper->SetScalarRange(low, high);
  mapper->InterpolateScalarsBeforeMappingOn();
  vtkNew<vtkActor> machine;
  machine->SetMapper(mapper);
  machine->GetProperty()->SetAmbient(0.42);
  machine->GetProperty()->SetDiffuse(0.62);
  machine->GetProperty()->SetSpecular(0.05);
  return machine;
}

vtkNew<vtkActor> sharp_edges(vtkPolyData* skin) {
  vtkNew<vtkFeatureEdges> sharp;
  sharp->SetInputData(skin);
  sharp->BoundaryEdgesOff();
  sharp->NonManifoldEdgesOff();
  sharp->ManifoldEdgesOff();
  sharp->FeatureEdgesOn();
  sharp->SetFeatureAngle(sharp_angle_deg);
  sharp->ColoringOff();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(sharp->GetOutputPort());
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> edges;
  edges->SetMapper(mapper);
  edges->GetProperty()->SetColor(0.15, 0.15, 0.18);
  edges->GetProperty()->SetLineWidth(1.4F);
  return edges;
}

vtkNew<vtkScalarBarActor> scalar_bar(vtkColorTransferFunction* map) {
  vtkNew<vtkScalarBarActor> bar;
  bar->SetLookupTable(map);
  bar->SetTitle("temperature in \xC2\xB0\x43\n");
  bar->SetNumberOfLabels(6);
  bar->SetLabelFormat("%.1f");
  bar->SetUnconstrainedFontSize(true);
  bar->SetPosition(0.88, 0.22);
  bar->SetWidth(0.07);
  bar->SetHeight(0.56);
  style(bar->GetTitleTextProperty(), 20);
  style(bar->GetLabelTextProperty(), 20);
  return bar;
}

/// A line of text at a place of the picture, pixels from the lower left.
vtkNew<vtkTextActor> text_at(const std::string& text, int y, int size) {
  vtkNew<vtkTextActor> actor;
  actor->SetInput(text.c_str());
  actor->SetPosition(30, y);
  style(actor->GetTextProperty(), size);
  return actor;
}

void add_lights(vtkRenderer* renderer) {
  renderer->AutomaticLightCreationOff();
  for (const auto& [x, y, z, intensity] : {std::array{1.0, 1.5, 2.0, 0.85}, std::array{-2.0, 0.5, 1.0, 0.45}}) {
    vtkNew<vtkLight> light;
    light->SetLightTypeToCameraLight();
    light->SetPosition(x, y, z);
    light->SetIntensity(intensity);
    renderer->AddLight(light);
  }
}

std::string png_of(vtkRenderer* renderer) {
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(8);
  window->SetSize(width, height);
  window->AddRenderer(renderer);
  window->Render();
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  image->SetInputBufferTypeToRGB();
  image->ReadFrontBufferOff();
  image->Update();
  vtkNew<vtkPNGWriter> writer;
  writer->WriteToMemoryOn();
  writer->SetInputConnection(image->GetOutputPort());
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  if (writer->GetErrorCode() != 0 || bytes == nullptr) return {};
  const std::size_t size = bytes->GetNumberOfValues();
  return {reinterpret_cast<const char*>(bytes->GetPointer(0)), size};
}

}  // namespace
}  // namespace thermotwin::solver

extern "C" void thermotwin_draw(const thermotwin::solver::PictureScene& scene, std::string& png) {
  using namespace thermotwin::solver;
  const auto skin = skin_of(scene);
  const auto map = colours(scene.low_C, scene.high_C);
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1.0, 1.0, 1.0);
  renderer->AddActor(coloured(skin, map, scene.low_C, scene.high_C));
  renderer->AddActor(sharp_edges(skin));
  renderer->AddActor2D(scalar_bar(map));
  renderer->AddActor2D(text_at(scene.title, height - 50, 28));
  renderer->AddActor2D(text_at(scene.note, 24, 20));
  add_lights(renderer);
  look_at(skin, renderer);
  png = png_of(renderer);
}
