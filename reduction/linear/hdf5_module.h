// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Interface of the module that links HDF5 and the libraries of its network access. It is loaded at run time.

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace thermotwin::reduction {

using StoreExtents = std::vector<Eigen::Index>;  ///< entries along each dimension

/// A file in memory that is being written, see StoreWriter. @throws SolverError (every member: out of memory)
class Hdf5Output {
public:
  virtual ~Hdf5Output() = default;
  virtual void group(const std::string& path) = 0;
  virtual void text_attribute(const std::string& object, const std::string& key, const std::string& value) = 0;
  virtual void integer_attribute(const std::string& object, const std::string& key, std::int64_t value) = 0;
  /// @param values  the last dimension runs fastest
  virtual void numbers(const std::string& path, const StoreExtents& extents, const double* values) = 0;
  virtual void integers(const std::string& path, const StoreExtents& extents, const int* values) = 0;
  virtual void text(const std::string& path, const std::string& value) = 0;
  /// The bytes of the file; nothing may be added afterwards.
  virtual std::string finish() = 0;
};

/// A file in memory that is read, see StoreReader. Extents of -1 are those of the file and are filled in.
/// @throws InputError (every member: missing or damaged object, other extents)
class Hdf5Input {
public:
  virtual ~Hdf5Input() = default;
  virtual bool has(const std::string& path) const = 0;
  virtual bool has_attribute(const std::string& key) const = 0;
  virtual std::string text_attribute(const std::string& key) const = 0;
  virtual std::int64_t integer_attribute(const std::string& key) const = 0;
  virtual std::vector<double> numbers(const std::string& path, StoreExtents& extents) const = 0;
  virtual std::vector<int> integers(const std::string& path, StoreExtents& extents) const = 0;
  /// Sets the extents of a block (count x rows x columns), of which slices are read.
  virtual void measure_block(const std::string& path, StoreExtents& extents) const = 0;
  /// @return (rows x columns) numbers, the last dimension runs fastest
  virtual std::vector<double> slice(const std::string& path, const StoreExtents& extents, Eigen::Index i) const = 0;
  virtual std::string text(const std::string& path) const = 0;
};

struct Hdf5Module {
  /// @param name  of the file, for messages
  std::unique_ptr<Hdf5Output> (*create)(const std::string& name);
  std::unique_ptr<Hdf5Input> (*open)(const std::string& name, std::string bytes);
};

}  // namespace thermotwin::reduction
