// SPDX-License-Identifier: GPL-3.0-or-later
// The only file that includes Gmsh: the module of gmsh_module.h.

#include "mesh/import/gmsh_module.h"

#include <Eigen/Dense>
#include <fmt/format.h>
#include <gmsh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fcntl.h>
#include <functional>
#include <mutex>
#include <new>
#include <numbers>
#include <unistd.h>
#include <unordered_map>

#include "core/error.h"
#include "core/units.h"
#include "mesh/import/import_process.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

namespace {

using DimTags = gmsh::vectorpair;
using Tags = std::vector<std::size_t>;

/// OpenCASCADE prints to stdout, where our results go: stdout leads nowhere meanwhile.
class Silence {
public:
  Silence() {
    std::fflush(stdout);
    saved_ = ::dup(1);
    const int nowhere = ::open("/dev/null", O_WRONLY);
    if (nowhere >= 0) {
      ::dup2(nowhere, 1);
      ::close(nowhere);
    }
  }
  ~Silence() {
    std::fflush(stdout);
    if (saved_ >= 0) {
      ::dup2(saved_, 1);
      ::close(saved_);
    }
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

private:
  int saved_ = -1;
};

class Session {
public:
  Session() : lock_(mutex()) {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.NumThreads", 1);
    gmsh::option::setString("Geometry.OCCTargetUnit", "MM");
    gmsh::option::setNumber("Geometry.OCCImportLabels", 1);
    gmsh::option::setNumber("Mesh.Algorithm3D", 1);  // Delaunay
    gmsh::option::setNumber("Mesh.Optimize", 1);
    gmsh::model::add("body");
  }
  ~Session() {
    try {
      gmsh::finalize();
    } catch (...) {  // nothing is left to be done about it
    }
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  std::lock_guard<std::mutex> lock_;
  Silence silence_;
};

std::string last_error() {
  std::string text;
  try {
    gmsh::logger::getLastError(text);
  } catch (...) {}
  return text.empty() ? "no details" : text;
}

/// The mesher's words for exhausted memory; the surface or the file is not to blame then.
void heed_exhausted_memory(const std::string& text) {
  if (text.find("ut of memory") != std::string::npos) throw std::bad_alloc();
}

/// Runs work in a session; whatever Gmsh throws becomes an Error that begins with `doing`.
template <class Error, class Result>
Result in_session(const std::string& place, const std::string& doing, const std::string& allowed,
                  const std::function<Result()>& work) {
  const Session session;
  try {
    return work();
  } catch (const core::Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::string& text) {
    heed_exhausted_memory(text);
    throw Error(place, doing + ": " + text, allowed);
  } catch (const std::exception& error) {
    heed_exhausted_memory(error.what());
    throw Error(place, doing + ": " + error.what(), allowed);
  } catch (...) {
    heed_exhausted_memory(last_error());
    throw Error(place, doing + ": " + last_error(), allowed);
  }
}

void set_sizes(const ImportOptions& options, double unit, int elements_per_turn) {
  const double size = options.element_size_m / unit;
  const double least = options.min_element_size_m > 0.0 ? options.min_element_size_m / unit : 0.25 * size;
  gmsh::option::setNumber("Mesh.MeshSizeMax", size);
  gmsh::option::setNumber("Mesh.MeshSizeMin", std::min(least, size));
  gmsh::option::setNumber("Mesh.MeshSizeFromCurvature", elements_per_turn);
}

/// Nodes of the current model by number, and the tetrahedra.
struct NodeTable {
  std::vector<Eigen::Vector3d> points;
  std::vector<long> labels;
  std::unordered_map<std::size_t, int> index;

  NodeTable() {
    Tags tags;
    std::vector<double> coordinates, parameters;
    gmsh::model::mesh::getNodes(tags, coordinates, parameters, -1, -1, false, false);
    std::vector<std::size_t> order(tags.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return tags[a] < tags[b]; });
    for (const std::size_t i : order) {
      if (!index.emplace(tags[i], points.size()).second) continue;
      points.emplace_back(coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]);
      labels.push_back(tags[i]);
    }
  }
  int operator()(std::size_t tag) const {
    const auto found = index.find(tag);
    if (found == index.end()) throw std::string(fmt::format("node {} does not exist", tag));
    return found->second;
  }
};

constexpr int tri3 = 2, tet4 = 4, tri6 = 9, tet10 = 11;  // Gmsh's element types

/// Triangles on one surface entity (or on all: -1).
std::vector<std::array<int, 3>> triangles_on(int entity, const NodeTable& nodes) {
  std::vector<std::array<int, 3>> result;
  for (const auto& [type, stride] : {std::pair{tri3, 3}, std::pair{tri6, 6}}) {
    Tags tags, corner;
    gmsh::model::mesh::getElementsByType(type, tags, corner, entity);
    for (std::ptrdiff_t i = 0; i + stride <= std::ssize(corner); i += stride)
      result.push_back({nodes(corner[i]), nodes(corner[i + 1]), nodes(corner[i + 2])});
  }
  return result;
}

RawMesh take_mesh(const std::string& source, std::map<int, std::vector<int>>& tets_of_volume, const NodeTable& nodes) {
  RawMesh raw;
  raw.source = source;
  raw.points = nodes.points;
  raw.node_labels = nodes.labels;
  DimTags volumes;
  gmsh::model::getEntities(volumes, 3);
  for (const auto& [dim, volume] : volumes) {
    for (const auto& [type, stride] : {std::pair{tet4, 4}, std::pair{tet10, 10}}) {
      Tags tags, corner;
      gmsh::model::mesh::getElementsByType(type, tags, corner, volume);
      // Gmsh's last two edges are the other way round.
      constexpr std::size_t gmsh_edge[6] = {4, 5, 6, 7, 9, 8};
      for (std::size_t e = 0; e < tags.size(); ++e) {
        const std::size_t first = e * stride;
        tets_of_volume[volume].push_back(raw.tets.size());
        raw.tets.push_back(
            {nodes(corner[first]), nodes(corner[first + 1]), nodes(corner[first + 2]), nodes(corner[first + 3])});
        raw.tet_labels.push_back(tags[e]);
        if (type != tet10) continue;
        raw.edges.emplace_back();
        for (std::size_t i = 0; i < 6; ++i) raw.edges.back()[i] = nodes(corner[first + gmsh_edge[i]]);
      }
    }
  }
  return raw;
}

/// Own name of a CAD entity: the last part of its path in the assembly; "" if the writer made it up.
std::string label(int dim, int tag) {
  std::string name;
  gmsh::model::getEntityName(dim, tag, name);
  if (const std::size_t slash = name.rfind('/'); slash != std::string::npos) name.erase(0, slash + 1);
  return name.find("Open CASCADE") != std::string::npos ? std::string() : name;
}

std::map<int, std::string> names_of(const DimTags& solids) {
  std::map<int, std::string> names;
  for (const auto& [dim, tag] : solids)
    if (std::string name = label(dim, tag); !name.empty()) names[tag] = std::move(name);
  return names;
}

double volume_of(const DimTags& solids) {
  double volume = 0.0;
  for (const auto& [dim, tag] : solids) {
    double mass = 0.0;
    gmsh::model::occ::getMass(dim, tag, mass);
    volume += mass;
  }
  return volume;
}

/// Solids that are not joined must not fill one place twice.
void require_apart(const DimTags& solids, const std::string& place) {
  for (std::size_t i = 0; i < solids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      std::array<double, 6> a{}, b{};
      gmsh::model::occ::getBoundingBox(3, solids[i].second, a[0], a[1], a[2], a[3], a[4], a[5]);
      gmsh::model::occ::getBoundingBox(3, solids[j].second, b[0], b[1], b[2], b[3], b[4], b[5]);
      if (a[0] >= b[3] || b[0] >= a[3] || a[1] >= b[4] || b[1] >= a[4] || a[2] >= b[5] || b[2] >= a[5]) continue;
      DimTags first, second, both;
      std::vector<DimTags> from;
      gmsh::model::occ::copy({solids[i]}, first);
      gmsh::model::occ::copy({solids[j]}, second);
      gmsh::model::occ::intersect(first, second, both, from);
      const double shared = volume_of(both);
      if (!both.empty()) gmsh::model::occ::remove(both, true);
      if (shared > 1e-3 * std::min(volume_of({solids[i]}), volume_of({solids[j]}))) {
        throw core::MeshError(
            place,
            fmt::format("solids {} and {} of the file overlap ({:.3g} of its cubic units)", j + 1, i + 1, shared),
            "solids that do not overlap");
      }
    }
  }
}

/// Makes the solids share their faces. @return name of each volume that has one
std::map<int, std::string> join_solids(const DimTags& solids) {
  std::map<int, std::string> names;
  std::vector<std::string> before;
  for (const auto& [dim, tag] : solids) before.push_back(label(dim, tag));
  if (solids.size() == 1) {
    if (!before[0].empty()) names[solids[0].second] = before[0];
    return names;
  }
  DimTags joined;
  std::vector<DimTags> from;
  gmsh::model::occ::fragment({solids.front()}, DimTags(solids.begin() + 1, solids.end()), joined, from);
  gmsh::model::occ::synchronize();
  for (std::size_t i = 0; i < solids.size() && i < from.size(); ++i) {
    if (!before[i].empty()) {
      for (const auto& [dim, tag] : from[i])
        if (dim == 3) names[tag] = before[i];
    }
  }
  return names;
}

/// Smallest mean ratio quality of the tetrahedra (see mesh::quality).
double worst_quality() {
  const NodeTable nodes;
  Tags tags, corner;
  gmsh::model::mesh::getElementsByType(tet4, tags, corner);
  double worst = 1.0;
  for (std::size_t e = 0; e < tags.size(); ++e) {
    std::array<Eigen::Vector3d, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = nodes.points[nodes(corner[4 * e + i])];
    double squares = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) squares += (p[i] - p[j]).squaredNorm();
    const double volume = std::max(0.0, (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) / 6.0);
    worst = std::min(worst, squares > 0.0 ? 12.0 * std::pow(3.0 * volume, 2.0 / 3.0) / squares : 0.0);
  }
  return worst;
}

/// Fills the volumes. Slivers that the first optimisation leaves get a round with a higher threshold
/// (this Gmsh comes without Netgen's optimiser); what then remains shows in the quality table.
void generate() {
  gmsh::model::mesh::generate(3);
  if (worst_quality() >= 0.1) return;
  gmsh::option::setNumber("Mesh.OptimizeThreshold", 0.6);
  gmsh::model::mesh::optimize("", true);
}

/// Gaps up to this, over the extent, are closed where faces enclose no solid, each tried in turn.
constexpr double sewing_gaps[] = {1e-7, 1e-6, 1e-5, 1e-4};

double extent_of_model() {
  double box[6];
  gmsh::model::getBoundingBox(-1, -1, box[0], box[1], box[2], box[3], box[4], box[5]);
  return std::max({box[3] - box[0], box[4] - box[1], box[5] - box[2]});
}

int solids_of_model() {
  DimTags solids;
  gmsh::model::getEntities(solids, 3);
  return std::ssize(solids);
}

/// Whether the solids hold more than rounding.
bool bounds_a_volume(double extent) {
  DimTags solids;
  gmsh::model::getEntities(solids, 3);
  return volume_of(solids) > 1e-9 * extent * extent * extent;
}

/// Volumes that no face bounds: an assembly's empty bodies.
int drop_empty_solids(const DimTags& shapes) {
  int dropped = 0;
  for (const auto& shape : shapes) {
    double mass = 0.0;
    if (shape.first == 3) gmsh::model::occ::getMass(shape.first, shape.second, mass);
    if (shape.first != 3 || mass != 0.0) continue;
    gmsh::model::occ::remove({shape});
    ++dropped;
  }
  return dropped;
}

/// The file's solids in the current model. @throws MeshError
void read_shapes(const GmshJob& job) {
  const std::filesystem::path& path = job.file;
  const std::string& place = job.place;
  const ImportOptions& options = job.options;
  const Attempt& attempt = job.attempt;
  // IGES is brought to mm by its reader, which cannot be told a unit.
  if (job.iges) gmsh::option::setString("Geometry.OCCTargetUnit", "");
  const auto read = [&] {
    try {
      DimTags shapes;
      gmsh::model::occ::importShapes(path.string(), shapes, true);
      const int dropped = drop_empty_solids(shapes);
      gmsh::model::occ::synchronize();
      return dropped;
    } catch (...) {
      heed_exhausted_memory(last_error());
      throw core::MeshError(place, "unreadable (" + last_error() + ")", "a STEP, IGES or BREP file");
    }
  };
  const int dropped = read();
  if (dropped > 0 && attempt.first)
    job.warn(fmt::format("body '{}': {} solids without volume were dropped", options.body, dropped));
  const double extent = extent_of_model();
  const bool has_solid = solids_of_model() > 0;
  const auto heal_faces = [&](double gap, bool sew) {
    DimTags healed;
    try {
      gmsh::model::occ::healShapes(healed, {}, gap, true, true, true, sew, sew);
      gmsh::model::occ::synchronize();
    } catch (...) {  // shapes that cannot be healed stay as they are
      heed_exhausted_memory(last_error());
    }
  };
  if (has_solid) {
    if (attempt.heal > 0.0) heal_faces(attempt.heal * extent, false);
    return;
  }
  DimTags faces;
  gmsh::model::getEntities(faces, 2);
  for (const double gap : sewing_gaps) {
    if (faces.empty()) break;
    gmsh::model::remove();
    gmsh::model::add("body");
    read();
    heal_faces(gap * extent, true);
    if (solids_of_model() == 0 || !bounds_a_volume(extent)) continue;
    if (attempt.first) {
      job.warn(fmt::format("body '{}': {} faces were sewn into {} solids (gaps up to {:.2g} of the extent)",
                           options.body, faces.size(), solids_of_model(), gap));
    }
    return;
  }
  throw core::MeshError(
      place, faces.empty() ? "no solid" : fmt::format("no solid: its {} faces enclose no volume", faces.size()),
      "one or more closed solids (open surfaces or wires are not enough)");
}

/// The surface as discrete faces that bound a volume.
void add_surface(const Surface& surface, double unit, Attempt::Patches patches, const std::vector<int>& patch) {
  Tags node_tags;
  std::vector<double> coordinates;
  for (Eigen::Index i = 0; i < surface.points.cols(); ++i) {
    node_tags.push_back(i + 1);
    for (int k = 0; k < 3; ++k) coordinates.push_back(surface.points(k, i) / unit);
  }
  std::map<int, Tags> corners;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t)
    for (int k = 0; k < 3; ++k) corners[patch[t]].push_back(surface.triangles(k, t) + 1);
  for (const auto& [number, corner] : corners) {
    const int entity = gmsh::model::addDiscreteEntity(2);
    if (number == 0) gmsh::model::mesh::addNodes(2, entity, node_tags, coordinates);
    gmsh::model::mesh::addElementsByType(entity, tri3, {}, corner);
  }
  constexpr double sharp = 40.0 * core::units::deg;
  if (patches == Attempt::Patches::as_in_file) return;
  if (patches == Attempt::Patches::by_angle)
    gmsh::model::mesh::classifySurfaces(sharp, true, true, std::numbers::pi);
  else
    gmsh::model::mesh::createTopology();
  gmsh::model::mesh::createGeometry();
}

RawMesh tets_of_solids(const GmshJob& job, double& volume) {
  const Attempt& attempt = job.attempt;
  const double unit = job.unit_m;
  return in_session<MesherError, RawMesh>(
      job.place, "meshing failed", "a valid solid (try another element_size_mm, or repair the CAD file)", [&] {
        read_shapes(job);
        DimTags solids;
        gmsh::model::getEntities(solids, 3);
        std::map<int, std::string> face_names;
        if (solids.size() == 1) {
          DimTags faces;
          gmsh::model::getEntities(faces, 2);
          for (const auto& [dim, tag] : faces)
            if (std::string name = label(dim, tag); !name.empty()) face_names[tag] = std::move(name);
        }
        const int count = solids.size();
        if (!attempt.join && count == 1) throw MesherError(job.place, "a single solid", "solids that touch");
        const std::map<int, std::string> solid_names = attempt.join ? join_solids(solids) : names_of(solids);
        if (!attempt.join) require_apart(solids, job.place);
        double box[6];
        gmsh::model::getBoundingBox(-1, -1, box[0], box[1], box[2], box[3], box[4], box[5]);
        Eigen::Matrix3Xd ends(3, 2);
        ends << box[0], box[3], box[1], box[4], box[2], box[5];
        job.check_extent(unit * ends);  // before a mesh of a billion elements
        gmsh::model::getEntities(solids, 3);
        volume = volume_of(solids) * unit * unit * unit;
        job.require_affordable(volume);
        gmsh::option::setNumber("Mesh.Algorithm", attempt.algorithm);
        set_sizes(job.options, unit, attempt.curvature ? job.options.elements_per_turn : 0);
        generate();
        const NodeTable nodes;
        std::map<int, std::vector<int>> tets_of;
        RawMesh mesh = take_mesh(job.file.string(), tets_of, nodes);
        mesh.solids = count;
        for (const auto& [tag, name] : solid_names) {
          auto& set = mesh.element_sets[name];
          set.insert(set.end(), tets_of[tag].begin(), tets_of[tag].end());
        }
        for (const auto& [tag, name] : face_names) {
          const auto triangles = triangles_on(tag, nodes);
          auto& set = mesh.face_sets[name];
          set.insert(set.end(), triangles.begin(), triangles.end());
        }
        return mesh;
      });
}

Surface faces_of_solids(const GmshJob& job) {
  const double unit = job.unit_m;
  return in_session<MesherError, Surface>(
      job.place, "its faces could not be meshed", "valid faces (repair the CAD file)", [&] {
        read_shapes(job);
        DimTags solids;
        gmsh::model::getEntities(solids, 3);
        job.require_affordable(volume_of(solids) * unit * unit * unit);
        set_sizes(job.options, unit, job.attempt.curvature ? job.options.elements_per_turn : 0);
        gmsh::option::setNumber("Mesh.Algorithm", job.attempt.algorithm);
        gmsh::model::mesh::generate(2);
        const NodeTable nodes;
        std::vector<std::array<int, 3>> triangles;
        for (const auto& solid : solids) {
          DimTags faces;
          gmsh::model::getBoundary({solid}, faces, false, true, false);
          for (const auto& [dim, tag] : faces) {
            for (std::array<int, 3> triangle : triangles_on(std::abs(tag), nodes)) {
              if (tag < 0) std::swap(triangle[0], triangle[1]);
              triangles.push_back(triangle);
            }
          }
        }
        Surface surface;
        surface.points.resize(3, std::ssize(nodes.points));
        for (std::size_t n = 0; n < nodes.points.size(); ++n) surface.points.col(n) = unit * nodes.points[n];
        surface.triangles.resize(3, std::ssize(triangles));
        for (std::size_t t = 0; t < triangles.size(); ++t)
          surface.triangles.col(t) = Eigen::Map<const Eigen::Vector3i>(triangles[t].data());
        surface.part.assign(triangles.size(), 0);
        surface.part_names = {""};
        return surface;
      });
}

RawMesh tets_within(const GmshJob& job, const Surface& surface, const std::vector<int>& patch) {
  const std::string allowed = "a surface of well-shaped patches (try STEP, or another element_size_mm)";
  return in_session<MesherError, RawMesh>(job.place, "the surface could not be meshed", allowed, [&] {
    add_surface(surface, job.unit_m, job.attempt.patches, patch);
    DimTags faces;
    gmsh::model::getEntities(faces, 2);
    std::vector<int> tags;
    for (const auto& face : faces) tags.push_back(face.second);
    gmsh::model::geo::addVolume({gmsh::model::geo::addSurfaceLoop(tags)});
    gmsh::model::geo::synchronize();
    gmsh::option::setNumber("Mesh.Algorithm", job.attempt.algorithm);
    // The curvature of a faceted surface is noise: the size alone counts.
    set_sizes(job.options, job.unit_m, 0);
    generate();
    const NodeTable nodes;
    std::map<int, std::vector<int>> tets_of;
    return take_mesh("surface mesh", tets_of, nodes);
  });
}

RawMesh tets_of_msh(const std::filesystem::path& path) {
  return in_session<core::MeshError, RawMesh>(
      path.string(), "unreadable", "a complete Gmsh mesh file, version 4.1 or 2.2", [&] {
        gmsh::open(path.string());
        const NodeTable nodes;
        std::map<int, std::vector<int>> tets_of;
        RawMesh raw = take_mesh(path.string(), tets_of, nodes);
        DimTags groups;
        gmsh::model::getPhysicalGroups(groups);
        for (const auto& [dim, tag] : groups) {
          if (dim < 2) continue;
          std::string name;
          gmsh::model::getPhysicalName(dim, tag, name);
          if (name.empty()) name = std::to_string(tag);
          std::vector<int> entities;
          gmsh::model::getEntitiesForPhysicalGroup(dim, tag, entities);
          for (const int entity : entities) {
            if (dim == 2) {
              const auto triangles = triangles_on(entity, nodes);
              auto& set = raw.face_sets[name];
              set.insert(set.end(), triangles.begin(), triangles.end());
            } else {
              auto& set = raw.element_sets[name];
              set.insert(set.end(), tets_of[entity].begin(), tets_of[entity].end());
            }
          }
        }
        return raw;
      });
}

}  // namespace
}  // namespace thermotwin::mesh

extern "C" const thermotwin::mesh::GmshModule* thermotwin_gmsh() {
  using namespace thermotwin::mesh;
  static const GmshModule functions{tets_of_solids, faces_of_solids, tets_within, tets_of_msh};
  return &functions;
}
