// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Writes and reads numbers as the bytes they have in memory, for checkpoints that the same machine reads back.

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace thermotwin::core {

class BinaryWriter {
public:
  void number(double value) { raw(&value, sizeof value); }
  void count(std::int64_t value) { raw(&value, sizeof value); }
  void text(std::string_view value);
  void matrix(const Eigen::Ref<const Eigen::MatrixXd>& value);
  void numbers(const std::vector<double>& values);
  const std::string& bytes() const { return bytes_; }
  std::string take() { return std::move(bytes_); }

private:
  void raw(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  std::string bytes_;
};

/// Reads what a BinaryWriter wrote, in the same order. @throws InputError if bytes are missing
class BinaryReader {
public:
  /// @param source  name for messages; bytes must outlive the reader
  BinaryReader(std::string_view bytes, std::string source) : bytes_(bytes), source_(std::move(source)) {}

  double number();
  std::int64_t count();
  std::string text();
  Eigen::MatrixXd matrix();
  std::vector<double> numbers();
  bool at_end() const { return at_ == bytes_.size(); }

private:
  void raw(void* data, std::size_t size);
  std::string_view bytes_;
  std::string source_;
  std::size_t at_ = 0;
};

}  // namespace thermotwin::core
