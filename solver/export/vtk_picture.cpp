// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/vtk_picture.h"

#include <fmt/format.h>
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
#include <cstdlib>

#include "core/error.h"
#include "core/file.h"
#include "mesh/body/shape.h"
#include "mesh/machine/kinematics.h"
#include "solver/export/vtk_output.h"

namespace thermotwin::solver {
namespace {

constexpr int width = 1400, height = 1000;
constexpr double sharp_angle_deg = 35.0;
constexpr double smallest_span_K = 1.0;  // of the colour map: an even temperature shows one colour

/// Skin of all bodies at the pose, moved by the exaggerated displacement.
vtkNew<vtkPolyData> deformed_skin(const mesh::MachineMesh& mesh, const mesh::Pose& pose,
                                  const Eigen::VectorXd& temperature_C, const Eigen::Matrix3Xd& displacement,
                                  double exaggeration) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> temperature;
  temperature->SetName("temperature_C");
  vtkNew<vtkCellArray> triangles;
  std::vector<vtkIdType> place(mesh.nodes(), -1);
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const mesh::TetMesh& body = mesh.bodies[b];
    const Eigen::Isometry3d frame = mesh::body_transform(mesh.machine, b, pose);
    for (Eigen::Index face = 0; face < body.face_count(); ++face) {
      const mesh::FaceNodes nodes = mesh::face_nodes(body, face);
      vtkIdType at_node[6] = {};
      for (Eigen::Index i = 0; i < nodes.size(); ++i) {
        const Eigen::Index node = mesh.first_node[b] + nodes[i];
        vtkIdType& at = place[node];
        if (at < 0) {
          const Eigen::Vector3d moved =
              frame * Eigen::Vector3d(body.points.col(nodes[i]) + exaggeration * displacement.col(node));
          at = points->InsertNextPoint(moved.data());
          temperature->InsertNextValue(static_cast<float>(temperature_C[node]));
        }
        at_node[i] = at;
      }
      // A quadratic triangle is drawn as four.
      static constexpr int whole[3] = {0, 1, 2}, quarters[4][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};
      const bool quadratic = nodes.size() == 6;
      for (int part = 0; part < (quadratic ? 4 : 1); ++part) {
        vtkIdType corners[3];
        for (int i = 0; i < 3; ++i) corners[i] = at_node[quadratic ? quarters[part][i] : whole[i]];
        triangles->InsertNextCell(3, corners);
      }
    }
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

/// The colour map's ends for these temperatures.
std::pair<double, double> colour_range(const Eigen::Ref<const Eigen::VectorXd>& temperature_C) {
  double low = temperature_C.minCoeff();
  double high = temperature_C.maxCoeff();
  if (const double missing = smallest_span_K - (high - low); missing > 0.0) low -= 0.5 * missing, high += 0.5 * missing;
  return {low, high};
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

void write_png(const std::filesystem::path& png, vtkRenderer* renderer) {
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
  if (writer->GetErrorCode() != 0 || bytes == nullptr)
    throw core::SolverError(png.string() + ": VTK could not make the picture (out of memory)");
  const std::size_t size = bytes->GetNumberOfValues();
  core::write_file(png, {reinterpret_cast<const char*>(bytes->GetPointer(0)), size});
}

}  // namespace

bool has_display() {
  const char* display = std::getenv("DISPLAY");
  return display != nullptr && *display != '\0';
}

void write_picture(const std::filesystem::path& png, const mesh::MachineMesh& mesh, const mesh::Pose& pose,
                   const Eigen::VectorXd& temperature_C, const Eigen::Matrix3Xd& displacement, double exaggeration,
                   const std::string& title) {
  // VTK ends the program where it cannot open a display.
  if (!has_display()) throw core::SolverError("no display to draw pictures on; run under: xvfb-run -a");
  const auto skin = deformed_skin(mesh, pose, temperature_C, displacement, exaggeration);
  const auto [low, high] = colour_range(temperature_C.head(mesh.nodes()));
  const auto map = colours(low, high);
  const std::string note = fmt::format("{}   displacement x {:g}", mesh::format_pose(mesh.machine, pose), exaggeration);

  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1.0, 1.0, 1.0);
  renderer->AddActor(coloured(skin, map, low, high));
  renderer->AddActor(sharp_edges(skin));
  renderer->AddActor2D(scalar_bar(map));
  renderer->AddActor2D(text_at(title, height - 50, 28));
  renderer->AddActor2D(text_at(note, 24, 20));
  add_lights(renderer);
  look_at(skin, renderer);
  write_png(png, renderer);
}

}  // namespace thermotwin::solver
