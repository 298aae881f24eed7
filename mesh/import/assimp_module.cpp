// SPDX-License-Identifier: GPL-3.0-or-later
// The only file that includes assimp: the module of assimp_module.h.

#include "mesh/import/assimp_module.h"

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <iterator>
#include <string>

#include "core/error.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

namespace {

struct Collector {
  const aiScene& scene;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3i> triangles;
  Surface surface;

  int part_of(const std::string& name) {
    const auto at = std::find(surface.part_names.begin(), surface.part_names.end(), name);
    const int part = at - surface.part_names.begin();
    if (at == surface.part_names.end()) surface.part_names.push_back(name);
    return part;
  }

  void add(const aiMesh& mesh, const aiMatrix4x4& placed, const std::string& node_name) {
    const std::string own = mesh.mName.C_Str();
    const int part = part_of(own.empty() ? node_name : own);
    const int first = points.size();
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D point = placed * mesh.mVertices[i];
      points.emplace_back(point.x, point.y, point.z);
    }
    const bool mirrored = placed.Determinant() < 0.0f;  // turns the triangles over
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;  // lines and points
      Eigen::Vector3i corner(face.mIndices[0], face.mIndices[1], face.mIndices[2]);
      corner.array() += first;
      if (mirrored) std::swap(corner[1], corner[2]);
      triangles.push_back(corner);
      surface.part.push_back(part);
    }
  }

  void walk(const aiNode& node, const aiMatrix4x4& above) {
    const aiMatrix4x4 placed = above * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) add(*scene.mMeshes[node.mMeshes[i]], placed, node.mName.C_Str());
    for (unsigned i = 0; i < node.mNumChildren; ++i) walk(*node.mChildren[i], placed);
  }
};

Surface triangles_of_file(const std::filesystem::path& path, const std::string& body) {
  Assimp::Importer importer;
  // Normals and colours would keep corners apart that are one place.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                                          aiComponent_COLORS | aiComponent_TEXCOORDS |
                                                          aiComponent_MATERIALS | aiComponent_TEXTURES);
  const aiScene* scene = importer.ReadFile(
      path.string(), aiProcess_RemoveComponent | aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw core::MeshError("body '" + body + "': '" + path.string() + "'",
                          std::string("unreadable (") + importer.GetErrorString() + ")", "a surface file of its type");
  }
  Collector collector{*scene, {}, {}, {}};
  collector.walk(*scene->mRootNode, aiMatrix4x4());
  if (collector.triangles.empty())
    throw core::MeshError("body '" + body + "': '" + path.string() + "'", "no triangles", "a closed surface");
  Surface surface = std::move(collector.surface);
  surface.points.resize(3, std::ssize(collector.points));
  surface.triangles.resize(3, std::ssize(collector.triangles));
  for (std::size_t i = 0; i < collector.points.size(); ++i) surface.points.col(i) = collector.points[i];
  for (std::size_t i = 0; i < collector.triangles.size(); ++i) surface.triangles.col(i) = collector.triangles[i];
  return surface;
}

}  // namespace
}  // namespace thermotwin::mesh

extern "C" thermotwin::mesh::ReadTriangles thermotwin_assimp() { return thermotwin::mesh::triangles_of_file; }
