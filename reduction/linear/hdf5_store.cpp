// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/linear/hdf5_store.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "core/error.h"
#include "core/file.h"
#include "reduction/linear/store_trailer.h"

namespace thermotwin::reduction {
namespace {

using core::InputError;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Extents = std::vector<hsize_t>;

constexpr hsize_t largest_extent = 1u << 24;

/// An HDF5 id that closes itself.
class Handle {
public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close closer) : id_(id), close_(closer) {}
  Handle(Handle&& other) noexcept : id_(other.id_), close_(other.close_) { other.id_ = -1; }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }
  bool good() const { return id_ >= 0; }
  /// @return whether the library could close it, i.e. everything is written
  bool close() {
    const hid_t id = id_;
    id_ = -1;
    return close_(id) >= 0;
  }

private:
  hid_t id_;
  Close close_;
};

/// Our own messages stand in for the stack that the library prints.
class QuietLibrary {
public:
  QuietLibrary() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietLibrary() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  QuietLibrary(const QuietLibrary&) = delete;
  QuietLibrary& operator=(const QuietLibrary&) = delete;

private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// The library asks for the name of a file in memory, and refuses one that exists: none does below a device.
constexpr const char* no_file = "/dev/null/store";

constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";

/// Lends the library the bytes of a file, which it would copy twice. They have to outlive the file.
struct LentImage {
  static void* lend(std::size_t, H5FD_file_image_op_t, void* bytes) { return bytes; }
  static void* nothing_to_copy(void* to, const void*, std::size_t, H5FD_file_image_op_t, void*) { return to; }
  static void* no_growth(void*, std::size_t, H5FD_file_image_op_t, void*) { return nullptr; }
  static herr_t stays(void*, H5FD_file_image_op_t, void*) { return 0; }
  static void* same(void* bytes) { return bytes; }
  static herr_t stays_too(void*) { return 0; }
  static bool set(hid_t access, std::string& bytes) {
    H5FD_file_image_callbacks_t callbacks = {lend, nothing_to_copy, no_growth, stays, same, stays_too, bytes.data()};
    return H5Pset_file_image_callbacks(access, &callbacks) >= 0 &&
           H5Pset_file_image(access, bytes.data(), bytes.size()) >= 0;
  }
};

hsize_t extent(Eigen::Index n) { return n; }

/// An empty text is stored as a blank, since HDF5 knows no strings of length 0.
std::string stored_text(const std::string& value) { return value.empty() ? " " : value; }
std::string loaded_text(std::string value) {
  while (!value.empty() && value.back() == '\0') value.pop_back();
  return value == " " ? std::string() : value;
}

}  // namespace

// ---------------------------------------------------------------- writing

struct StoreWriter::File {
  QuietLibrary quiet;
  std::string name;
  Handle id;

  explicit File(const std::string& name_in_messages) : name(name_in_messages), id(in_memory(), H5Fclose) {
    check(id.good());
  }

  /// The library does not survive a disk that fills up: it ends in a crash. So it never sees one.
  static hid_t in_memory() {
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    constexpr std::size_t growth = 1u << 20;
    H5Pset_fapl_core(access, growth, 0);
    return H5Fcreate(no_file, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  }
  void check(bool good) const {
    if (!good) throw core::SolverError(name + ": HDF5 could not make the file (out of memory)");
  }
  Handle text_type(const std::string& stored) const {
    Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    check(H5Tset_size(type, stored.size()) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0 &&
          H5Tset_strpad(type, H5T_STR_NULLPAD) >= 0);
    return type;
  }
  /// Creation properties without times of writing.
  Handle timeless(hid_t kind) const {
    Handle properties(H5Pcreate(kind), H5Pclose);
    check(H5Pset_obj_track_times(properties, 0) >= 0);
    return properties;
  }
  void attribute(const std::string& object, const std::string& key, hid_t stored, hid_t native,
                 const void* value) const {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle made(
        H5Acreate_by_name(id, object.c_str(), key.c_str(), stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    check(made.good() && H5Awrite(made, native, value) >= 0);
  }
  void dataset(const std::string& path, const Extents& extents, hid_t stored, hid_t native, const void* values) const {
    const Handle space(H5Screate_simple(extents.size(), extents.data(), nullptr), H5Sclose);
    const Handle properties = timeless(H5P_DATASET_CREATE);
    hsize_t count = 1;
    for (const hsize_t n : extents) count *= n;
    if (count > 0) {
      Extents chunk = extents;
      if (chunk.size() == 3) chunk[0] = 1;
      check(H5Pset_chunk(properties, chunk.size(), chunk.data()) >= 0 && H5Pset_fletcher32(properties) >= 0);
    }
    const Handle set(H5Dcreate2(id, path.c_str(), stored, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
    check(space.good() && set.good());
    if (count > 0) check(H5Dwrite(set, native, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
  }
};

StoreWriter::StoreWriter(const std::string& name) : file_(std::make_unique<File>(name)) {}
StoreWriter::~StoreWriter() = default;

void StoreWriter::group(const std::string& path) {
  const Handle properties = file_->timeless(H5P_GROUP_CREATE);
  const Handle made(H5Gcreate2(file_->id, path.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT), H5Gclose);
  file_->check(made.good());
}

void StoreWriter::text_attribute(const std::string& object, const std::string& key, const std::string& value) {
  const std::string stored = stored_text(value);
  const Handle type = file_->text_type(stored);
  file_->attribute(object, key, type, type, stored.data());
}

void StoreWriter::integer_attribute(const std::string& object, const std::string& key, std::int64_t value) {
  file_->attribute(object, key, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

void StoreWriter::describe(const std::string& object, const std::string& columns, const std::string& unit) {
  text_attribute(object, "columns", columns);
  text_attribute(object, "unit", unit);
}

void StoreWriter::matrix(const std::string& path, const Eigen::MatrixXd& values) {
  const RowMajor rows = values;
  file_->dataset(path, {extent(rows.rows()), extent(rows.cols())}, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, rows.data());
}

void StoreWriter::vector(const std::string& path, const Eigen::VectorXd& values) {
  file_->dataset(path, {extent(values.size())}, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data());
}

void StoreWriter::stack(const std::string& path, const std::vector<Eigen::MatrixXd>& matrices, Eigen::Index rows,
                        Eigen::Index columns) {
  std::vector<double> values;
  values.reserve(matrices.size() * rows * columns);
  for (const Eigen::MatrixXd& matrix : matrices) {
    if (matrix.rows() != rows || matrix.cols() != columns) {
      throw InputError(file_->name + " " + path, fmt::format("a matrix of {} x {}", matrix.rows(), matrix.cols()),
                       fmt::format("{} x {}", rows, columns));
    }
    const RowMajor ordered = matrix;
    values.insert(values.end(), ordered.data(), ordered.data() + ordered.size());
  }
  file_->dataset(path, {matrices.size(), extent(rows), extent(columns)}, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                 values.data());
}

void StoreWriter::integers(const std::string& path, const IntRows& values) {
  file_->dataset(path, {extent(values.rows()), extent(values.cols())}, H5T_STD_I32LE, H5T_NATIVE_INT, values.data());
}

void StoreWriter::text(const std::string& path, const std::string& value) {
  const std::string stored = stored_text(value);
  const Handle type = file_->text_type(stored);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle properties = file_->timeless(H5P_DATASET_CREATE);
  const Handle set(H5Dcreate2(file_->id, path.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
  file_->check(set.good() && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, stored.data()) >= 0);
}

std::string StoreWriter::finish() {
  file_->check(H5Fflush(file_->id, H5F_SCOPE_GLOBAL) >= 0);
  const ssize_t size = H5Fget_file_image(file_->id, nullptr, 0);
  file_->check(size > 0);
  std::string bytes(size, '\0');
  file_->check(H5Fget_file_image(file_->id, bytes.data(), bytes.size()) == size);
  file_->check(file_->id.close());
  return bytes + store_trailer(bytes);  // HDF5 knows nothing of the line
}

// ---------------------------------------------------------------- reading

struct StoreReader::File {
  QuietLibrary quiet;
  std::string name;
  std::string bytes;
  Handle id;

  explicit File(const std::filesystem::path& path)
      : name(path.string()),
        bytes(checked_bytes(path)),
        id(opened(bytes), H5Fclose) {
    if (!id.good()) throw InputError(name, "no HDF5 file, or one that was cut off", "a whole HDF5 file");
  }

  /// What was checked is what HDF5 reads, which does not survive every damaged file.
  static std::string checked_bytes(const std::filesystem::path& path) {
    std::string bytes = core::read_file(path);
    if (!bytes.starts_with(signature))
      throw InputError(path.string(), "no HDF5 file, or one that was cut off", "a whole HDF5 file");
    const std::size_t size = bytes.size() - std::min(bytes.size(), store_trailer_size);
    const std::string found = bytes.substr(size);
    bytes.resize(size);
    if (!is_store_trailer(found)) {
      throw InputError(path.string(),
                       "no checksum at the end: the file was cut off or damaged, or written by an earlier version",
                       "a whole file of this version (write it anew: thermotwin reduce)");
    }
    if (!store_trailer_holds(bytes, found)) {
      throw InputError(path.string(), "wrong checksum at the end: the file was damaged or changed after it was written",
                       "the file as it was written (write it anew: thermotwin reduce)");
    }
    return bytes;
  }
  static hid_t opened(std::string& bytes) {
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    constexpr std::size_t growth = 1u << 20;
    if (H5Pset_fapl_core(access, growth, 0) < 0 || !LentImage::set(access, bytes)) return -1;
    return H5Fopen(no_file, H5F_ACC_RDONLY, access);
  }

  [[noreturn]] void damaged(const std::string& object) const {
    throw InputError(name, "'" + object + "' is missing or damaged", "a whole file of this version");
  }
  Handle dataset(const std::string& path) const {
    Handle set(H5Dopen2(id, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.good()) damaged(path);
    return set;
  }
  Handle attribute(const std::string& key) const {
    Handle found(H5Aopen(id, key.c_str(), H5P_DEFAULT), H5Aclose);
    if (!found.good()) damaged(key);
    const Handle space(H5Aget_space(found), H5Sclose);
    if (H5Sget_simple_extent_npoints(space) != 1) damaged(key);
    return found;
  }
  std::string text_buffer(hid_t type, const std::string& object) const {
    const std::size_t size = H5Tget_size(type);
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 || size > largest_extent) damaged(object);
    return std::string(size, '\0');
  }

  /// @param extents  expected ones; `any` is filled in
  /// The extents of a table of numbers, and how many it has.
  hsize_t checked(const Handle& set, const std::string& path, std::vector<Eigen::Index>& extents,
                  H5T_class_t kind) const {
    const Handle type(H5Dget_type(set), H5Tclose);
    const Handle space(H5Dget_space(set), H5Sclose);
    if (H5Sget_simple_extent_ndims(space) != std::ssize(extents) || H5Tget_class(type) != kind) damaged(path);
    Extents found(extents.size());
    H5Sget_simple_extent_dims(space, found.data(), nullptr);
    hsize_t count = 1;
    for (std::size_t i = 0; i < extents.size(); ++i) {
      if (extents[i] == any) extents[i] = std::min(found[i], largest_extent);
      if (found[i] != extent(extents[i])) {
        throw InputError(name, fmt::format("'{}' with {} entries along dimension {}", path, found[i], i + 1),
                         fmt::format("{} entries", extents[i]));
      }
      count *= found[i];
    }
    // What is stored bounds what is allocated, whatever the header claims.
    if (count > H5Dget_storage_size(set)) damaged(path);
    return count;
  }

  template <class Number>
  std::vector<Number> values(const std::string& path, std::vector<Eigen::Index>& extents, H5T_class_t kind,
                             hid_t native) const {
    const Handle set = dataset(path);
    const hsize_t count = checked(set, path, extents, kind);
    std::vector<Number> result(count);
    if (count > 0 && H5Dread(set, native, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.data()) < 0) damaged(path);
    return result;
  }

  std::vector<double> numbers(const std::string& path, std::vector<Eigen::Index>& extents) const {
    std::vector<double> result = values<double>(path, extents, H5T_FLOAT, H5T_NATIVE_DOUBLE);
    require_finite(path, result);
    return result;
  }
  void require_finite(const std::string& path, const std::vector<double>& numbers) const {
    const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    if (!finite) throw InputError(name, "'" + path + "' holds a number that is not finite", "finite numbers");
  }
};

StoreReader::StoreReader(const std::filesystem::path& path) : file_(std::make_unique<File>(path)) {}
StoreReader::~StoreReader() = default;

void StoreReader::fail(const std::string& value, const std::string& allowed) const {
  throw InputError(file_->name, value, allowed);
}

bool StoreReader::has(const std::string& path) const { return H5Lexists(file_->id, path.c_str(), H5P_DEFAULT) > 0; }

bool StoreReader::has_attribute(const std::string& key) const { return H5Aexists(file_->id, key.c_str()) > 0; }

std::string StoreReader::text_attribute(const std::string& key) const {
  const Handle attribute = file_->attribute(key);
  const Handle type(H5Aget_type(attribute), H5Tclose);
  std::string value = file_->text_buffer(type, key);
  if (H5Aread(attribute, type, value.data()) < 0) file_->damaged(key);
  return loaded_text(std::move(value));
}

std::int64_t StoreReader::integer_attribute(const std::string& key) const {
  const Handle attribute = file_->attribute(key);
  const Handle type(H5Aget_type(attribute), H5Tclose);
  std::int64_t value = 0;
  if (H5Tget_class(type) != H5T_INTEGER || H5Aread(attribute, H5T_NATIVE_INT64, &value) < 0) file_->damaged(key);
  return value;
}

Eigen::MatrixXd StoreReader::matrix(const std::string& path, Eigen::Index rows, Eigen::Index columns) const {
  std::vector<Eigen::Index> extents{rows, columns};
  const std::vector<double> values = file_->numbers(path, extents);
  return Eigen::Map<const RowMajor>(values.data(), extents[0], extents[1]);
}

Eigen::VectorXd StoreReader::vector(const std::string& path, Eigen::Index size) const {
  std::vector<Eigen::Index> extents{size};
  const std::vector<double> values = file_->numbers(path, extents);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), extents[0]);
}

std::vector<Eigen::MatrixXd> StoreReader::stack(const std::string& path, Eigen::Index count, Eigen::Index rows,
                                                Eigen::Index columns) const {
  std::vector<Eigen::Index> extents{count, rows, columns};
  const Handle set = file_->dataset(path);
  file_->checked(set, path, extents, H5T_FLOAT);
  // One at a time: the block as a whole may have 100 MB.
  const Handle in_file(H5Dget_space(set), H5Sclose);
  const Extents one{1, extent(extents[1]), extent(extents[2])};
  const Handle in_memory(H5Screate_simple(one.size(), one.data(), nullptr), H5Sclose);
  std::vector<double> values(extents[1] * extents[2]);
  std::vector<Eigen::MatrixXd> matrices;
  matrices.reserve(extents[0]);
  for (Eigen::Index i = 0; i < extents[0]; ++i) {
    const Extents first{extent(i), 0, 0};
    if (!values.empty() &&
        (H5Sselect_hyperslab(in_file, H5S_SELECT_SET, first.data(), nullptr, one.data(), nullptr) < 0 ||
         H5Dread(set, H5T_NATIVE_DOUBLE, in_memory, in_file, H5P_DEFAULT, values.data()) < 0))
      file_->damaged(path);
    file_->require_finite(path, values);
    matrices.emplace_back(Eigen::Map<const RowMajor>(values.data(), extents[1], extents[2]));
  }
  return matrices;
}

IntRows StoreReader::integers(const std::string& path, Eigen::Index columns) const {
  std::vector<Eigen::Index> extents{any, columns};
  const std::vector<int> values = file_->values<int>(path, extents, H5T_INTEGER, H5T_NATIVE_INT);
  return Eigen::Map<const IntRows>(values.data(), extents[0], extents[1]);
}

std::string StoreReader::text(const std::string& path) const {
  const Handle set = file_->dataset(path);
  const Handle space(H5Dget_space(set), H5Sclose);
  const Handle type(H5Dget_type(set), H5Tclose);
  if (H5Sget_simple_extent_npoints(space) != 1) file_->damaged(path);
  std::string value = file_->text_buffer(type, path);
  if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, value.data()) < 0) file_->damaged(path);
  return loaded_text(std::move(value));
}

}  // namespace thermotwin::reduction
