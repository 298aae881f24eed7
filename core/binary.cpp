// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/binary.h"

#include <cstring>

#include "core/error.h"

namespace thermotwin::core {

void BinaryWriter::text(std::string_view value) {
  count(value.size());
  raw(value.data(), value.size());
}

void BinaryWriter::matrix(const Eigen::Ref<const Eigen::MatrixXd>& value) {
  count(value.rows());
  count(value.cols());
  for (Eigen::Index j = 0; j < value.cols(); ++j) raw(value.col(j).data(), value.rows() * sizeof(double));
}

void BinaryWriter::numbers(const std::vector<double>& values) {
  count(values.size());
  raw(values.data(), values.size() * sizeof(double));
}

void BinaryReader::raw(void* data, std::size_t size) {
  if (size > bytes_.size() - at_) throw InputError(source_, "it ends too early", "a whole file");
  if (size > 0) std::memcpy(data, bytes_.data() + at_, size);
  at_ += size;
}

double BinaryReader::number() {
  double value;
  raw(&value, sizeof value);
  return value;
}

std::int64_t BinaryReader::count() {
  std::int64_t value;
  raw(&value, sizeof value);
  // Nothing that follows can be longer than the file: a damaged size is found before memory is asked for.
  if (value < 0) throw InputError(source_, "a negative size", "a whole file");
  return value;
}

std::string BinaryReader::text() {
  const std::size_t size = count();
  if (size > bytes_.size() - at_) throw InputError(source_, "it ends too early", "a whole file");
  std::string value(size, '\0');
  raw(value.data(), size);
  return value;
}

Eigen::MatrixXd BinaryReader::matrix() {
  const std::int64_t rows = count(), columns = count();
  const std::int64_t left = (bytes_.size() - at_) / sizeof(double);
  if (columns > 0 && rows > left / columns) throw InputError(source_, "it ends too early", "a whole file");
  Eigen::MatrixXd value(rows, columns);
  raw(value.data(), value.size() * sizeof(double));
  return value;
}

std::vector<double> BinaryReader::numbers() {
  const std::size_t size = count();
  if (size > (bytes_.size() - at_) / sizeof(double)) throw InputError(source_, "it ends too early", "a whole file");
  std::vector<double> values(size);
  raw(values.data(), size * sizeof(double));
  return values;
}

}  // namespace thermotwin::core
