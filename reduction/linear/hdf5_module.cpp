// SPDX-License-Identifier: GPL-3.0-or-later
// The only file that includes HDF5: the module of hdf5_module.h.

#include "reduction/linear/hdf5_module.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/error.h"

namespace thermotwin::reduction {
namespace {

using core::InputError;
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

Extents extents_of(const StoreExtents& extents) { return {extents.begin(), extents.end()}; }

/// An empty text is stored as a blank, since HDF5 knows no strings of length 0.
std::string stored_text(const std::string& value) { return value.empty() ? " " : value; }
std::string loaded_text(std::string value) {
  while (!value.empty() && value.back() == '\0') value.pop_back();
  return value == " " ? std::string() : value;
}

/// The library does not survive a disk that fills up: it ends in a crash. So it never sees one.
hid_t file_in_memory() {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  constexpr std::size_t growth = 1u << 20;
  H5Pset_fapl_core(access, growth, 0);
  return H5Fcreate(no_file, H5F_ACC_TRUNC, H5P_DEFAULT, access);
}

class Output final : public Hdf5Output {
public:
  explicit Output(const std::string& name) : name_(name), id_(file_in_memory(), H5Fclose) { check(id_.good()); }

  void group(const std::string& path) override {
    const Handle properties = timeless(H5P_GROUP_CREATE);
    const Handle made(H5Gcreate2(id_, path.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT), H5Gclose);
    check(made.good());
  }
  void text_attribute(const std::string& object, const std::string& key, const std::string& value) override {
    const std::string stored = stored_text(value);
    const Handle type = text_type(stored);
    attribute(object, key, type, type, stored.data());
  }
  void integer_attribute(const std::string& object, const std::string& key, std::int64_t value) override {
    attribute(object, key, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
  }
  void numbers(const std::string& path, const StoreExtents& extents, const double* values) override {
    dataset(path, extents_of(extents), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values);
  }
  void integers(const std::string& path, const StoreExtents& extents, const int* values) override {
    dataset(path, extents_of(extents), H5T_STD_I32LE, H5T_NATIVE_INT, values);
  }
  void text(const std::string& path, const std::string& value) override {
    const std::string stored = stored_text(value);
    const Handle type = text_type(stored);
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle properties = timeless(H5P_DATASET_CREATE);
    const Handle set(H5Dcreate2(id_, path.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
    check(set.good() && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, stored.data()) >= 0);
  }
  std::string finish() override {
    check(H5Fflush(id_, H5F_SCOPE_GLOBAL) >= 0);
    const ssize_t size = H5Fget_file_image(id_, nullptr, 0);
    check(size > 0);
    std::string bytes(size, '\0');
    check(H5Fget_file_image(id_, bytes.data(), bytes.size()) == size);
    check(id_.close());
    return bytes;
  }

private:
  void check(bool good) const {
    if (!good) throw core::SolverError(name_ + ": HDF5 could not make the file (out of memory)");
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
        H5Acreate_by_name(id_, object.c_str(), key.c_str(), stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
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
    const Handle set(H5Dcreate2(id_, path.c_str(), stored, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose);
    check(space.good() && set.good());
    if (count > 0) check(H5Dwrite(set, native, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
  }

  QuietLibrary quiet_;
  std::string name_;
  Handle id_;
};

hid_t opened(std::string& bytes) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  constexpr std::size_t growth = 1u << 20;
  if (H5Pset_fapl_core(access, growth, 0) < 0 || !LentImage::set(access, bytes)) return -1;
  return H5Fopen(no_file, H5F_ACC_RDONLY, access);
}

class Input final : public Hdf5Input {
public:
  Input(const std::string& name, std::string bytes)
      : name_(name),
        bytes_(std::move(bytes)),
        id_(opened(bytes_), H5Fclose) {
    if (!id_.good())
      throw InputError(name_, "no HDF5 file, or one that was cut off",
                       "a whole HDF5 file, such as a model.rom.h5 that `thermotwin reduce` wrote");
  }

  bool has(const std::string& path) const override { return H5Lexists(id_, path.c_str(), H5P_DEFAULT) > 0; }
  bool has_attribute(const std::string& key) const override { return H5Aexists(id_, key.c_str()) > 0; }
  std::string text_attribute(const std::string& key) const override {
    const Handle found = attribute(key);
    const Handle type(H5Aget_type(found), H5Tclose);
    std::string value = text_buffer(type, key);
    if (H5Aread(found, type, value.data()) < 0) damaged(key);
    return loaded_text(std::move(value));
  }
  std::int64_t integer_attribute(const std::string& key) const override {
    const Handle found = attribute(key);
    const Handle type(H5Aget_type(found), H5Tclose);
    std::int64_t value = 0;
    if (H5Tget_class(type) != H5T_INTEGER || H5Aread(found, H5T_NATIVE_INT64, &value) < 0) damaged(key);
    return value;
  }
  std::vector<double> numbers(const std::string& path, StoreExtents& extents) const override {
    return values<double>(path, extents, H5T_FLOAT, H5T_NATIVE_DOUBLE);
  }
  std::vector<int> integers(const std::string& path, StoreExtents& extents) const override {
    return values<int>(path, extents, H5T_INTEGER, H5T_NATIVE_INT);
  }
  void measure_block(const std::string& path, StoreExtents& extents) const override {
    checked(dataset(path), path, extents, H5T_FLOAT);
  }
  std::vector<double> slice(const std::string& path, const StoreExtents& extents, Eigen::Index i) const override {
    const Handle set = dataset(path);
    const Handle in_file(H5Dget_space(set), H5Sclose);
    Extents one = extents_of(extents), first(extents.size(), 0);
    one[0] = 1;
    first[0] = i;
    const Handle in_memory(H5Screate_simple(one.size(), one.data(), nullptr), H5Sclose);
    std::vector<double> values(extents[1] * extents[2]);
    if (!values.empty() &&
        (H5Sselect_hyperslab(in_file, H5S_SELECT_SET, first.data(), nullptr, one.data(), nullptr) < 0 ||
         H5Dread(set, H5T_NATIVE_DOUBLE, in_memory, in_file, H5P_DEFAULT, values.data()) < 0))
      damaged(path);
    return values;
  }
  std::string text(const std::string& path) const override {
    const Handle set = dataset(path);
    const Handle space(H5Dget_space(set), H5Sclose);
    const Handle type(H5Dget_type(set), H5Tclose);
    if (H5Sget_simple_extent_npoints(space) != 1) damaged(path);
    std::string value = text_buffer(type, path);
    if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, value.data()) < 0) damaged(path);
    return loaded_text(std::move(value));
  }

private:
  [[noreturn]] void damaged(const std::string& object) const {
    throw InputError(name_, "'" + object + "' is missing or damaged", "a whole file of this version");
  }
  Handle dataset(const std::string& path) const {
    Handle set(H5Dopen2(id_, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.good()) damaged(path);
    return set;
  }
  Handle attribute(const std::string& key) const {
    Handle found(H5Aopen(id_, key.c_str(), H5P_DEFAULT), H5Aclose);
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
  hsize_t checked(const Handle& set, const std::string& path, StoreExtents& extents, H5T_class_t kind) const {
    const Handle type(H5Dget_type(set), H5Tclose);
    const Handle space(H5Dget_space(set), H5Sclose);
    if (H5Sget_simple_extent_ndims(space) != std::ssize(extents) || H5Tget_class(type) != kind) damaged(path);
    Extents found(extents.size());
    H5Sget_simple_extent_dims(space, found.data(), nullptr);
    hsize_t count = 1;
    for (std::size_t i = 0; i < extents.size(); ++i) {
      if (extents[i] < 0) extents[i] = std::min(found[i], largest_extent);
      if (found[i] != hsize_t(extents[i])) {
        throw InputError(name_, fmt::format("'{}' with {} entries along dimension {}", path, found[i], i + 1),
                         fmt::format("{} entries", extents[i]));
      }
      count *= found[i];
    }
    // What is stored bounds what is allocated, whatever the header claims.
    if (count > H5Dget_storage_size(set)) damaged(path);
    return count;
  }

  template <class Number>
  std::vector<Number> values(const std::string& path, StoreExtents& extents, H5T_class_t kind, hid_t native) const {
    const Handle set = dataset(path);
    const hsize_t count = checked(set, path, extents, kind);
    std::vector<Number> result(count);
    if (count > 0 && H5Dread(set, native, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.data()) < 0) damaged(path);
    return result;
  }

  QuietLibrary quiet_;
  std::string name_, bytes_;
  Handle id_;
};

std::unique_ptr<Hdf5Output> create(const std::string& name) { return std::make_unique<Output>(name); }
std::unique_ptr<Hdf5Input> open(const std::string& name, std::string bytes) {
  return std::make_unique<Input>(name, std::move(bytes));
}

}  // namespace
}  // namespace thermotwin::reduction

extern "C" const thermotwin::reduction::Hdf5Module* thermotwin_hdf5() {
  using namespace thermotwin::reduction;
  static const Hdf5Module functions{create, open};
  return &functions;
}
