// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One pool of std::threads for the whole program, in the manner of TBB. The caller works too, so
// nested calls do not deadlock. Results never depend on the number of threads: parallel_for writes
// to places of its own index, and parallel_reduce folds fixed blocks in their order.

#include <cstddef>
#include <functional>
#include <vector>

namespace thermotwin::core {

/// Sets the number of threads of the pool (the caller included).
/// @param count  1 or more; 0 means all cores
/// Not to be called while parallel work runs.
void set_thread_count(int count);

/// @return number of threads that parallel work may use, the caller included
int thread_count();

/// Calls body(i) for each i in [begin, end), in no fixed order.
/// @param grain  indices handed out together, >= 1
/// @throws the first exception of a body (smallest block), after all others have ended
void parallel_for(std::size_t begin, std::size_t end, const std::function<void(std::size_t)>& body,
                  std::size_t grain = 1);

/// Folds block results in the order of the blocks: the same bits for any number of threads.
/// @param map   (first, last) -> value of that block
/// @param fold  (left, right) -> combined
template <class Value, class Map, class Fold>
Value parallel_reduce(std::size_t begin, std::size_t end, std::size_t block, Value identity, const Map& map,
                      const Fold& fold) {
  const std::size_t count = end > begin ? (end - begin + block - 1) / block : 0;
  std::vector<Value> results(count, identity);
  parallel_for(0, count, [&](std::size_t i) {
    const std::size_t first = begin + i * block;
    const std::size_t last = first + block < end ? first + block : end;
    results[i] = map(first, last);
  });
  Value total = std::move(identity);
  for (Value& result : results) total = fold(std::move(total), std::move(result));
  return total;
}

}  // namespace thermotwin::core
