// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads and writes Matrix Market files (Boisvert, Pozo, Remington, NISTIR 5935): coordinate and array format; real,
// integer and pattern (ones); general, symmetric and skew-symmetric. Fortran exponents (1.5D-3) are accepted, and
// entries that occur twice are summed, as finite-element codes write them. Errors name file and line.

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <filesystem>
#include <string>
#include <string_view>

namespace thermotwin::core {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Largest number of rows or columns that a file may announce.
inline constexpr long long largest_market_extent = 10'000'000;

/// @return both triangles of a symmetric file, compressed; zeros of an array file are left out
/// @throws InputError: bad banner, size line or entry, an index outside, NaN, too few or many entries
SparseMatrix read_matrix_market(const std::filesystem::path& path);

/// Reads a matrix from text, for tests and fuzzers. @param source  name for messages
SparseMatrix parse_matrix_market(std::string_view text, const std::string& source);

/// Writes array format with 17 significant digits, which reads back as the same matrix.
/// @param comment  one line
std::string format_matrix_market(const Eigen::MatrixXd& matrix, const std::string& comment);
/// Writes coordinate format; of a matrix that is symmetric to the last bit, the lower triangle with a symmetric banner.
std::string format_matrix_market(const SparseMatrix& matrix, const std::string& comment);

}  // namespace thermotwin::core
