// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are a case file or an InputError, and so is each value read as each kind.
#include <cstdint>

#include "core/config.h"
#include "core/error.h"

using namespace thermotwin::core;

namespace {

template <class Read>
void attempt(const Read& read) {
  try {
    read();
  } catch (const InputError&) {}
}

void read_all(const Node& node, int depth) {
  if (depth > 8) return;
  for (const std::string& key : node.keys()) {
    attempt([&] { node.number(key, positive); });
    attempt([&] { node.uncertain(key); });
    attempt([&] { node.integer(key, -5, 5); });
    attempt([&] { node.boolean_or(key, true); });
    attempt([&] { node.choice(key, {"a", "b"}); });
    attempt([&] { node.vector3(key); });
    attempt([&] { node.numbers(key); });
    attempt([&] { node.texts(key); });
    attempt([&] { node.points3(key); });
    attempt([&] { node.number(key + "x"); });
    attempt([&] { read_all(node.table(key), depth + 1); });
    attempt([&] {
      for (const Node& inner : node.tables(key)) read_all(inner, depth + 1);
    });
  }
  attempt([&] { node.finish(); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  attempt([&] {
    const Config config = Config::parse(std::string(reinterpret_cast<const char*>(bytes), size), "fuzz.toml");
    attempt([&] { config.root().finish(); });
    read_all(config.root(), 0);
  });
  return 0;
}
