// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/exchange_ids.h"

#include <algorithm>
#include <map>

namespace thermotwin::diagnosis {

std::vector<std::string> exchange_ids(const mesh::VolumeSpec& volume) {
  std::vector<std::string> ids;
  std::map<std::string, int> seen;
  for (const mesh::VolumeExchange& exchange : volume.exchanges) {
    std::string id = volume.id + "." + exchange.with;
    const auto alike = std::count_if(volume.exchanges.begin(), volume.exchanges.end(),
                                     [&](const mesh::VolumeExchange& other) { return other.with == exchange.with; });
    if (alike > 1 && !exchange.state.empty()) id += "." + exchange.state;
    const int number = ++seen[id];
    ids.push_back(number == 1 ? id : id + " " + std::to_string(number));
  }
  return ids;
}

}  // namespace thermotwin::diagnosis
