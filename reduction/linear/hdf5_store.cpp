// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/linear/hdf5_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/file.h"
#include "core/module.h"
#include "reduction/linear/hdf5_module.h"
#include "reduction/linear/store_trailer.h"

namespace thermotwin::reduction {
namespace {

using core::InputError;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr const char* what_is_read = "a whole HDF5 file, such as a model.rom.h5 that `thermotwin reduce` wrote";
constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";

const Hdf5Module& hdf5_module() {
  static const Hdf5Module& module =
      core::module_table<Hdf5Module>("libthermotwin_hdf5.so", "thermotwin_hdf5", "model files");
  return module;
}

/// What was checked is what HDF5 reads, which does not survive every damaged file.
std::string checked_bytes(const std::filesystem::path& path) {
  std::string bytes = core::read_file(path);
  if (!bytes.starts_with(signature))
    throw InputError(path.string(), "no HDF5 file, or one that was cut off", what_is_read);
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

}  // namespace

StoreWriter::StoreWriter(const std::string& name) : name_(name), file_(hdf5_module().create(name)) {}
StoreWriter::~StoreWriter() = default;

void StoreWriter::group(const std::string& path) { file_->group(path); }

void StoreWriter::text_attribute(const std::string& object, const std::string& key, const std::string& value) {
  file_->text_attribute(object, key, value);
}

void StoreWriter::integer_attribute(const std::string& object, const std::string& key, std::int64_t value) {
  file_->integer_attribute(object, key, value);
}

void StoreWriter::describe(const std::string& object, const std::string& columns, const std::string& unit) {
  text_attribute(object, "columns", columns);
  text_attribute(object, "unit", unit);
}

void StoreWriter::matrix(const std::string& path, const Eigen::MatrixXd& values) {
  const RowMajor rows = values;
  file_->numbers(path, {rows.rows(), rows.cols()}, rows.data());
}

void StoreWriter::vector(const std::string& path, const Eigen::VectorXd& values) {
  file_->numbers(path, {values.size()}, values.data());
}

void StoreWriter::stack(const std::string& path, const std::vector<Eigen::MatrixXd>& matrices, Eigen::Index rows,
                        Eigen::Index columns) {
  std::vector<double> values;
  values.reserve(matrices.size() * rows * columns);
  for (const Eigen::MatrixXd& matrix : matrices) {
    if (matrix.rows() != rows || matrix.cols() != columns) {
      throw InputError(name_ + " " + path, fmt::format("a matrix of {} x {}", matrix.rows(), matrix.cols()),
                       fmt::format("{} x {}", rows, columns));
    }
    const RowMajor ordered = matrix;
    values.insert(values.end(), ordered.data(), ordered.data() + ordered.size());
  }
  file_->numbers(path, {std::ssize(matrices), rows, columns}, values.data());
}

void StoreWriter::integers(const std::string& path, const IntRows& values) {
  file_->integers(path, {values.rows(), values.cols()}, values.data());
}

void StoreWriter::text(const std::string& path, const std::string& value) { file_->text(path, value); }

std::string StoreWriter::finish() {
  const std::string bytes = file_->finish();
  return bytes + store_trailer(bytes);  // HDF5 knows nothing of the line
}

StoreReader::StoreReader(const std::filesystem::path& path)
    : name_(path.string()),
      file_(hdf5_module().open(name_, checked_bytes(path))) {}
StoreReader::~StoreReader() = default;

void StoreReader::fail(const std::string& value, const std::string& allowed) const {
  throw InputError(name_, value, allowed);
}

void StoreReader::require_finite(const std::string& path, const std::vector<double>& numbers) const {
  const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
  if (!finite) fail("'" + path + "' holds a number that is not finite", "finite numbers");
}

bool StoreReader::has(const std::string& path) const { return file_->has(path); }
bool StoreReader::has_attribute(const std::string& key) const { return file_->has_attribute(key); }
std::string StoreReader::text_attribute(const std::string& key) const { return file_->text_attribute(key); }
std::int64_t StoreReader::integer_attribute(const std::string& key) const { return file_->integer_attribute(key); }

Eigen::MatrixXd StoreReader::matrix(const std::string& path, Eigen::Index rows, Eigen::Index columns) const {
  StoreExtents extents{rows, columns};
  const std::vector<double> values = file_->numbers(path, extents);
  require_finite(path, values);
  return Eigen::Map<const RowMajor>(values.data(), extents[0], extents[1]);
}

Eigen::VectorXd StoreReader::vector(const std::string& path, Eigen::Index size) const {
  StoreExtents extents{size};
  const std::vector<double> values = file_->numbers(path, extents);
  require_finite(path, values);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), extents[0]);
}

std::vector<Eigen::MatrixXd> StoreReader::stack(const std::string& path, Eigen::Index count, Eigen::Index rows,
                                                Eigen::Index columns) const {
  StoreExtents extents{count, rows, columns};
  file_->measure_block(path, extents);
  // One at a time: the block as a whole may have 100 MB.
  std::vector<Eigen::MatrixXd> matrices;
  matrices.reserve(extents[0]);
  for (Eigen::Index i = 0; i < extents[0]; ++i) {
    const std::vector<double> values = file_->slice(path, extents, i);
    require_finite(path, values);
    matrices.emplace_back(Eigen::Map<const RowMajor>(values.data(), extents[1], extents[2]));
  }
  return matrices;
}

IntRows StoreReader::integers(const std::string& path, Eigen::Index columns) const {
  StoreExtents extents{any, columns};
  const std::vector<int> values = file_->integers(path, extents);
  return Eigen::Map<const IntRows>(values.data(), extents[0], extents[1]);
}

std::string StoreReader::text(const std::string& path) const { return file_->text(path); }

}  // namespace thermotwin::reduction
