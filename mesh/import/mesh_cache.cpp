// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/mesh_cache.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"

namespace thermotwin::mesh {

namespace {

// To be raised whenever the same input would give another mesh or another file.
constexpr const char* mesher_version = "4";
constexpr std::string_view magic = "thermotwin mesh 3\n";
constexpr std::uint32_t byte_order = 0x01020304;
constexpr std::size_t hash_length = 16;

class Writer {
public:
  void bytes(const void* data, std::size_t size) { text_.append(static_cast<const char*>(data), size); }
  template <class Number>
  void number(Number value) {
    bytes(&value, sizeof value);
  }
  template <class Matrix>
  void matrix(const Matrix& m) {
    number<std::int64_t>(m.cols() * m.rows());
    bytes(m.data(), m.size() * sizeof(typename Matrix::Scalar));
  }
  std::string text_;
};

/// Never reads beyond the end; a short file ends in ok() == false.
class Reader {
public:
  explicit Reader(std::string_view text) : text_(text) {}
  bool bytes(void* data, std::size_t size) {
    if (!ok_ || size > text_.size()) return ok_ = false;
    if (size > 0) std::memcpy(data, text_.data(), size);
    text_.remove_prefix(size);
    return true;
  }
  template <class Number>
  Number number() {
    Number value{};
    bytes(&value, sizeof value);
    return value;
  }
  template <class Scalar>
  std::size_t count() {
    const auto n = number<std::int64_t>();
    if (n < 0 || n > std::ssize(text_) / std::int64_t{sizeof(Scalar)}) ok_ = false;
    return ok_ ? n : 0;
  }
  template <class Matrix>
  void matrix(Matrix& m, std::size_t rows) {
    const std::size_t n = count<typename Matrix::Scalar>();
    if (n % rows != 0) ok_ = false;
    if (!ok_) return;
    if constexpr (Matrix::ColsAtCompileTime == 1)
      m.resize(n);
    else
      m.resize(rows, n / rows);
    bytes(m.data(), n * sizeof(typename Matrix::Scalar));
  }
  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && text_.empty(); }

private:
  std::string_view text_;
  bool ok_ = true;
};

}  // namespace

std::string cache_name(const std::filesystem::path& cad, const ImportOptions& options) {
  if (cad.extension() == ".gltf" || cad.extension() == ".GLTF") return {};
  const std::string bytes = core::read_file(cad);
  const std::string key = fmt::format(
      "{}|{}|{}|{:a}|{:a}|{:a}|{}{}", core::content_hash(bytes), cad.extension().string(), bytes.size(), options.unit_m,
      options.element_size_m, options.min_element_size_m, options.elements_per_turn, options.lattice ? "|lattice" : "");
  return options.body + "-" + core::content_hash(key + "|" + mesher_version) + ".mesh";
}

std::string pack_mesh(const TetMesh& mesh) {
  Writer writer;
  writer.number(byte_order);
  writer.matrix(mesh.points);
  writer.matrix(mesh.tets);
  writer.matrix(mesh.tet_edges);
  writer.matrix(mesh.faces);
  writer.matrix(mesh.face_edges);
  writer.matrix(mesh.face_tet);
  writer.number<std::int32_t>(mesh.solids);
  writer.number<std::int64_t>(mesh.groups.size());
  for (const auto& [name, faces] : mesh.groups) {
    writer.number<std::int64_t>(name.size());
    writer.bytes(name.data(), name.size());
    writer.number<std::int64_t>(faces.size());
    writer.bytes(faces.data(), faces.size() * sizeof(int));
  }
  return std::string(magic) + core::content_hash(writer.text_) + writer.text_;
}

std::optional<TetMesh> unpack_mesh(std::string_view all) {
  if (all.size() < magic.size() + hash_length || !all.starts_with(magic)) return std::nullopt;
  const std::string_view payload = all.substr(magic.size() + hash_length);
  if (core::content_hash(payload) != all.substr(magic.size(), hash_length)) return std::nullopt;
  Reader reader(payload);
  if (reader.number<std::uint32_t>() != byte_order) return std::nullopt;
  TetMesh mesh;
  reader.matrix(mesh.points, 3);
  reader.matrix(mesh.tets, 4);
  reader.matrix(mesh.tet_edges, 6);
  reader.matrix(mesh.faces, 3);
  reader.matrix(mesh.face_edges, 3);
  reader.matrix(mesh.face_tet, 1);
  mesh.solids = reader.number<std::int32_t>();
  const auto groups = reader.number<std::int64_t>();
  for (std::int64_t g = 0; g < groups && reader.ok(); ++g) {
    std::string name(reader.count<char>(), ' ');
    reader.bytes(name.data(), name.size());
    std::vector<int> faces(reader.count<int>());
    reader.bytes(faces.data(), faces.size() * sizeof(int));
    mesh.groups[name] = std::move(faces);
  }
  if (!reader.at_end()) return std::nullopt;
  return mesh;
}

std::optional<TetMesh> read_cached(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return std::nullopt;
  std::string text;
  try {
    text = core::read_file(file);
  } catch (const core::Error&) {
    return std::nullopt;
  }
  return unpack_mesh(text);
}

void write_cached(const std::filesystem::path& file, const TetMesh& mesh) {
  try {
    core::write_file(file, pack_mesh(mesh));
  } catch (const core::Error& error) {
    core::warn(std::string("the mesh is not cached: ") + error.what());
  }
}

}  // namespace thermotwin::mesh
