// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/kinematic_chain.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "core/error.h"

namespace thermotwin::mesh {
namespace {

using core::InputError;
constexpr const char* example = "a chain of ISO 10791-1 such as V [w C' B' b Y X Z (C1) t]";

Eigen::Vector3d axis_of(char letter) {
  switch (letter) {
    case 'X':
    case 'A': return Eigen::Vector3d::UnitX();
    case 'Y':
    case 'B': return Eigen::Vector3d::UnitY();
    default: return Eigen::Vector3d::UnitZ();
  }
}

ChainAxis axis_named(const std::string& word, bool table_side, const std::string& place) {
  std::string id = word;
  const bool primed = !id.empty() && id.back() == '\'';
  if (primed) id.pop_back();
  const bool letter = !id.empty() && std::string("XYZABCUVW").find(id[0]) != std::string::npos;
  const bool numbered =
      std::all_of(id.begin() + (id.empty() ? 0 : 1), id.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!letter || !numbered || id.size() > 3) {
    throw InputError(place, "'" + word + "'",
                     "axes X Y Z A B C U V W with an optional number, in " + std::string(example));
  }
  if (primed && !table_side) {
    throw InputError(place, "'" + word + "' on the tool's side",
                     "primes where an axis carries the workpiece, between w and b");
  }
  ChainAxis axis;
  axis.id = id;
  axis.rotary = id[0] >= 'A' && id[0] <= 'C';
  axis.table_side = table_side;
  const char main_letter = id[0] >= 'U' && id[0] <= 'W' ? static_cast<char>(id[0] - 'U' + 'X') : id[0];
  axis.direction = (table_side ? -1.0 : 1.0) * axis_of(main_letter);
  return axis;
}

}  // namespace

KinematicChain KinematicChain::parse(const std::string& text, const std::string& place) {
  const auto refuse = [&](const std::string& found) { throw InputError(place, found, example); };
  const std::size_t open = text.find('['), close = text.find(']');
  if (open == std::string::npos || close == std::string::npos || close < open) refuse("'" + text + "' without [ ]");
  std::string before = text.substr(0, open), after = text.substr(close + 1);
  for (std::string* rest : {&before, &after}) rest->erase(std::remove(rest->begin(), rest->end(), ' '), rest->end());
  if ((!before.empty() && before != "V" && before != "H") || !after.empty())
    refuse("'" + before + after + "' beside the brackets");

  KinematicChain chain;
  std::istringstream words(text.substr(open + 1, close - open - 1));
  std::string word;
  enum { at_start, table_side, tool_side, done } where = at_start;
  while (words >> word) {
    if (where == done) refuse("'" + word + "' after t");
    if (word == "w") {
      if (where != at_start) refuse("w in the middle");
      where = table_side;
    } else if (where == at_start) {
      refuse("'" + word + "' before w");
    } else if (word == "b") {
      if (where != table_side) refuse("b a second time");
      where = tool_side;
    } else if (word == "t") {
      if (where != tool_side) refuse("t before b");
      where = done;
    } else if (word.front() == '(') {
      if (word.back() != ')' || word.size() < 3) refuse("'" + word + "'");
    } else {
      const ChainAxis axis = axis_named(word, where == table_side, place);
      if (chain.find(axis.id) != nullptr) refuse("'" + axis.id + "' a second time");
      if (where == table_side)
        chain.table.insert(chain.table.begin(), axis);  // written from the workpiece
      else
        chain.tool.push_back(axis);
    }
  }
  if (where != done) refuse("'" + text + "' without " + (where == at_start ? "w" : where == table_side ? "b" : "t"));
  return chain;
}

const ChainAxis* KinematicChain::find(const std::string& id) const {
  for (const auto* branch : {&table, &tool}) {
    for (const ChainAxis& axis : *branch) {
      if (axis.id == id) return &axis;
    }
  }
  return nullptr;
}
ChainAxis* KinematicChain::find(const std::string& id) { return const_cast<ChainAxis*>(std::as_const(*this).find(id)); }

std::vector<std::string> KinematicChain::ids() const {
  std::vector<std::string> names;
  for (const bool rotary : {false, true}) {
    for (auto axis = table.rbegin(); axis != table.rend(); ++axis) {
      if (axis->rotary == rotary) names.push_back(axis->id);
    }
    for (const ChainAxis& axis : tool) {
      if (axis.rotary == rotary) names.push_back(axis.id);
    }
  }
  return names;
}

Eigen::Isometry3d KinematicChain::frame(const std::vector<ChainAxis>& branch, Eigen::Index moved,
                                        const std::map<std::string, double>& positions) {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  for (Eigen::Index i = 0; i <= moved; ++i) {
    const ChainAxis& axis = branch[i];
    const auto found = positions.find(axis.id);
    const double position = found == positions.end() ? 0.0 : found->second;
    if (axis.rotary) {
      transform.translate(axis.origin);
      transform.rotate(Eigen::AngleAxisd(position, axis.direction));
      transform.translate(-axis.origin);
    } else {
      transform.translate(position * axis.direction);
    }
  }
  return transform;
}

}  // namespace thermotwin::mesh
