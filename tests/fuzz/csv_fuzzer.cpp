// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are a table or an InputError; a table is consistent with itself.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <set>

#include "core/error.h"
#include "core/table.h"

using namespace thermotwin::core;

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  try {
    const Table table = parse_csv(text, "fuzz.csv");
    require(!table.columns.empty());
    require(static_cast<std::size_t>(table.values.cols()) == table.columns.size());
    require(std::set<std::string>(table.columns.begin(), table.columns.end()).size() == table.columns.size());
    for (const std::string& name : table.columns) {
      require(!name.empty());
      require(table.column(name).size() == table.rows());
    }
    for (Eigen::Index i = 0; i < table.values.size(); ++i) require(!std::isinf(table.values.data()[i]));
    require_time_column(table);
  } catch (const InputError&) {
  }
  return 0;
}
