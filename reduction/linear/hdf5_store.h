// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tables of numbers and texts in an HDF5 file: little-endian doubles and 32-bit integers, row-major,
// one chunk a matrix with a Fletcher-32 checksum, no times of writing, so that equal content makes
// equal files and a damaged one is noticed. The HDF5 library itself lies in a module (hdf5_module.h).

#include <Eigen/Core>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace thermotwin::reduction {

class Hdf5Input;
class Hdf5Output;

using IntRows = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class StoreWriter {
public:
  /// @param name  of the file for messages  @throws SolverError (every member: out of memory)
  explicit StoreWriter(const std::string& name);
  ~StoreWriter();

  void group(const std::string& path);
  /// Attributes of an object; "/" is the file.
  void text_attribute(const std::string& object, const std::string& key, const std::string& value);
  void integer_attribute(const std::string& object, const std::string& key, std::int64_t value);
  /// What the columns (or dimensions) are and the unit, beside every table of numbers.
  void describe(const std::string& object, const std::string& columns, const std::string& unit);

  void matrix(const std::string& path, const Eigen::MatrixXd& values);
  void vector(const std::string& path, const Eigen::VectorXd& values);
  /// Matrices of one shape as one block (count x rows x columns). @throws InputError for another shape
  void stack(const std::string& path, const std::vector<Eigen::MatrixXd>& matrices, Eigen::Index rows,
             Eigen::Index columns);
  void integers(const std::string& path, const IntRows& values);
  void text(const std::string& path, const std::string& value);
  /// The bytes of the file; nothing may be added afterwards.
  std::string finish();

private:
  std::string name_;
  std::unique_ptr<Hdf5Output> file_;
};

class StoreReader {
public:
  static constexpr Eigen::Index any = -1;  ///< an extent that the file decides

  /// @throws InputError (every member: no HDF5 file, missing or damaged object, other extents, NaN)
  explicit StoreReader(const std::filesystem::path& path);
  ~StoreReader();

  [[noreturn]] void fail(const std::string& value, const std::string& allowed) const;
  bool has(const std::string& path) const;  ///< an object; its group has to be there
  bool has_attribute(const std::string& key) const;
  std::string text_attribute(const std::string& key) const;
  std::int64_t integer_attribute(const std::string& key) const;
  Eigen::MatrixXd matrix(const std::string& path, Eigen::Index rows, Eigen::Index columns) const;
  Eigen::VectorXd vector(const std::string& path, Eigen::Index size) const;
  std::vector<Eigen::MatrixXd> stack(const std::string& path, Eigen::Index count, Eigen::Index rows,
                                     Eigen::Index columns) const;
  IntRows integers(const std::string& path, Eigen::Index columns) const;
  std::string text(const std::string& path) const;

private:
  void require_finite(const std::string& path, const std::vector<double>& numbers) const;

  std::string name_;
  std::unique_ptr<Hdf5Input> file_;
};

}  // namespace thermotwin::reduction
