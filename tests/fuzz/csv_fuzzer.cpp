// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are a table or an InputError; a table is consistent with itself.
#include <cmath>
#include <cstdint>
#include <set>

#include "core/error.h"
#include "core/table.h"
#include "tests/fuzz/require.h"

using namespace thermotwin::core;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  try {
    const Table table = parse_csv(text, "fuzz.csv");
    require(!table.columns.empty(), "a table has columns");
    require(static_cast<std::size_t>(table.values.cols()) == table.columns.size(), "a name for each column");
    require(std::set<std::string>(table.columns.begin(), table.columns.end()).size() == table.columns.size(),
            "names are unique");
    for (const std::string& name : table.columns) {
      require(!name.empty(), "names are not empty");
      require(table.column(name).size() == table.rows(), "a column has all rows");
    }
    for (Eigen::Index i = 0; i < table.values.size(); ++i)
      require(!std::isinf(table.values.data()[i]), "no value is infinite");
    require_time_column(table);
  } catch (const InputError&) {}
  return 0;
}
