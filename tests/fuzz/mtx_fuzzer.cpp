// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a Matrix Market file: either a finite matrix within its shape or an InputError.
#include <cmath>
#include <cstdint>

#include "core/error.h"
#include "core/matrix_market.h"
#include "tests/fuzz/require.h"

using namespace thermotwin::core;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  try {
    const SparseMatrix matrix = parse_matrix_market(text, "fuzz.mtx");
    require(matrix.rows() > 0 && matrix.cols() > 0, "a matrix has rows and columns");
    require(matrix.nonZeros() <= static_cast<Eigen::Index>(size), "an entry takes a byte or more");
    for (Eigen::Index j = 0; j < matrix.outerSize(); ++j) {
      Eigen::Index last = -1;
      for (SparseMatrix::InnerIterator it(matrix, j); it; ++it) {
        require(it.row() > last && it.row() < matrix.rows(), "rows rise within a column");
        require(std::isfinite(it.value()), "entries are finite");
        last = it.row();
      }
    }
  } catch (const InputError&) {}
  return 0;
}
