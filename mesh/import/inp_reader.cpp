// SPDX-License-Identifier: GPL-3.0-or-later
// Abaqus/CalculiX input: *NODE, *ELEMENT (C3D4, C3D10 and kin; plain triangles only name faces),
// *NSET, *ELSET, *SURFACE. Other keywords and their data are passed over.

#include "mesh/import/inp_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <string_view>
#include <unordered_map>

#include "core/error.h"
#include "core/text.h"
#include "mesh/import/raw_mesh.h"

namespace thermotwin::mesh {

namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t start = 0;;) {
    const std::size_t comma = line.find(',', start);
    cells.push_back(core::trimmed(line.substr(start, comma - start)));
    if (comma == std::string_view::npos) break;
    start = comma + 1;
  }
  if (!cells.empty() && cells.back().empty()) cells.pop_back();  // a comma at the end continues the line
  return cells;
}

struct Options : std::vector<std::pair<std::string, std::string>> {
  const std::string* find(const std::string& key) const {
    for (const auto& option : *this)
      if (option.first == key) return &option.second;
    return nullptr;
  }
};

class InpReader {
public:
  InpReader(const std::string& text, std::string source) : text_(text) { raw_.source = std::move(source); }

  RawMesh read() {
    for (std::size_t start = 0; start < text_.size();) {
      const std::size_t end = std::min(text_.find('\n', start), text_.size());
      ++line_;
      const std::string_view line = core::trimmed(std::string_view(text_).substr(start, end - start));
      start = end + 1;
      if (line.empty() || line.starts_with("**")) continue;
      if (line.front() == '*')
        keyword(line);
      else if (data_)
        data_(split(line));
    }
    end_block();
    resolve_sets();
    return std::move(raw_);
  }

private:
  struct Set {
    std::string name;  ///< as first written
    std::vector<long> labels;
    std::vector<std::string> of;  ///< upper case names of sets in it
    int line = 0;
  };
  struct SurfaceEntry {
    std::string set;  ///< upper case; or empty
    long label = 0;
    int face = 0, line = 0;
  };
  struct FaceSurface {
    std::string name;
    std::vector<SurfaceEntry> entries;
    bool nodes = false;
  };

  [[noreturn]] void fail(const std::string& found, const std::string& allowed, int line = 0) const {
    throw core::InputError(fmt::format("{}:{}", raw_.source, line > 0 ? line : line_), found, allowed);
  }

  long integer(std::string_view cell) const {
    long value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size() || value < 0 || value > 2000000000)
      fail(fmt::format("'{}'", cell.substr(0, 40)), "a whole number from 0 to 2000000000");
    return value;
  }

  double real(std::string_view cell) const {
    if (cell.starts_with('+')) cell.remove_prefix(1);
    std::string text(cell);
    for (char& c : text)
      if (c == 'd' || c == 'D') c = 'e';  // Fortran exponents
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
      fail("'" + text.substr(0, 40) + "'", "a number");
    return value;
  }

  void end_block() {
    if (!pending_.empty()) {
      fail(fmt::format("element {} has {} nodes", pending_[0], pending_.size() - 1), "as many nodes as its type has",
           pending_line_);
    }
    data_ = nullptr;
  }

  void keyword(std::string_view line) {
    end_block();
    std::string word;
    Options options;
    for (const std::string_view cell : split(line)) {
      if (word.empty()) {
        word = core::upper(cell);
        continue;
      }
      const std::size_t equals = cell.find('=');
      const std::string_view value =
          equals == std::string_view::npos ? std::string_view() : core::trimmed(cell.substr(equals + 1));
      options.emplace_back(core::upper(core::trimmed(cell.substr(0, equals))), std::string(value));
    }
    if (word == "*NODE") return begin_nodes(options);
    if (word == "*ELEMENT") return begin_elements(options);
    if (word == "*NSET") return begin_set(options, "NSET", node_sets_);
    if (word == "*ELSET") return begin_set(options, "ELSET", element_sets_);
    if (word == "*SURFACE") return begin_surface(options);
    if (word == "*INCLUDE") fail("*INCLUDE", "one file with everything in it");
    if (word == "*SYSTEM") fail("*SYSTEM", "nodes in global cartesian coordinates");
    if (word == "*INSTANCE")
      data_ = [this](const auto&) { fail("an *INSTANCE that is moved", "a mesh in its final place"); };
  }

  Set& set_named(std::map<std::string, Set>& sets, const std::string& name) {
    if (name.empty()) fail("a set without a name", "NSET=name or ELSET=name");
    Set& set = sets[core::upper(name)];
    if (set.name.empty()) set.name = name;
    set.line = line_;
    return set;
  }

  void begin_nodes(const Options& options) {
    Set* set = nullptr;
    if (const std::string* name = options.find("NSET")) set = &set_named(node_sets_, *name);
    data_ = [this, set](const std::vector<std::string_view>& cells) {
      if (cells.size() < 2 || cells.size() > 7) fail(fmt::format("{} values", cells.size()), "node number, x, y, z");
      const long label = integer(cells[0]);
      Eigen::Vector3d point = Eigen::Vector3d::Zero();
      for (std::ptrdiff_t i = 1; i < std::min<std::ptrdiff_t>(std::ssize(cells), 4); ++i)
        point[i - 1] = cells[i].empty() ? 0.0 : real(cells[i]);
      if (!node_index_.emplace(label, raw_.points.size()).second)
        fail(fmt::format("node {} again", label), "each node once");
      raw_.points.push_back(point);
      raw_.node_labels.push_back(label);
      if (set != nullptr) set->labels.push_back(label);
    };
  }

  void begin_elements(const Options& options) {
    const std::string* type = options.find("TYPE");
    if (type == nullptr) fail("*ELEMENT without TYPE", "TYPE=C3D4 or TYPE=C3D10");
    const std::string name = core::upper(*type);
    const auto is = [&](std::initializer_list<const char*> names) {
      return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
    };
    const bool linear = is({"C3D4", "C3D4T", "C3D4H", "DC3D4"});
    const bool quadratic = is({"C3D10", "C3D10M", "C3D10T", "C3D10H", "C3D10MT", "DC3D10"});
    const bool triangle = is({"CPS3", "CPE3", "S3", "S3R", "M3D3", "STRI3", "SFM3D3"});
    const bool triangle6 = is({"CPS6", "CPE6", "S6", "M3D6", "STRI65", "SFM3D6"});
    if (!linear && !quadratic && !triangle && !triangle6) {
      // Lines, springs and masses carry no volume; any other solid would be lost unseen.
      if (name.starts_with("T3D") || name.starts_with("B3") || name.starts_with("SPRING") || name.starts_with("MASS") ||
          name.starts_with("DASHPOT"))
        return;
      fail("element type " + *type, "C3D4, C3D10 (and CPS3, CPS6, S3, S6 to name faces)");
    }
    nodes_per_element_ = quadratic ? 10 : triangle6 ? 6 : linear ? 4 : 3;
    const bool solid = linear || quadratic;
    Set* set = nullptr;
    if (const std::string* elset = options.find("ELSET")) set = &set_named(element_sets_, *elset);
    data_ = [this, set, solid](const std::vector<std::string_view>& cells) {
      if (pending_.empty()) pending_line_ = line_;
      for (const std::string_view cell : cells) pending_.push_back(integer(cell));
      const std::size_t needed = nodes_per_element_ + 1;
      if (pending_.size() < needed) return;
      if (pending_.size() > needed) {
        fail(fmt::format("element {} has {} nodes", pending_[0], pending_.size() - 1),
             fmt::format("{} nodes", needed - 1), pending_line_);
      }
      add_element(solid);
      if (set != nullptr) set->labels.push_back(pending_[0]);
      pending_.clear();
    };
  }

  void add_element(bool solid) {
    std::array<int, 10> nodes{};
    for (std::size_t i = 0; i + 1 < pending_.size(); ++i) {
      const auto node = node_index_.find(pending_[i + 1]);
      if (node == node_index_.end()) {
        fail(fmt::format("element {} refers to node {}", pending_[0], pending_[i + 1]), "nodes given before by *NODE",
             pending_line_);
      }
      nodes[i] = node->second;
    }
    auto& index = solid ? tet_index_ : triangle_index_;
    if (tet_index_.count(pending_[0]) + triangle_index_.count(pending_[0]) > 0)
      fail(fmt::format("element {} again", pending_[0]), "each element once", pending_line_);
    index.emplace(pending_[0], solid ? raw_.tets.size() : triangles_.size());
    if (solid) {
      raw_.tets.push_back({nodes[0], nodes[1], nodes[2], nodes[3]});
      if (nodes_per_element_ == 10) raw_.edges.push_back({nodes[4], nodes[5], nodes[6], nodes[7], nodes[8], nodes[9]});
      raw_.tet_labels.push_back(pending_[0]);
      raw_.tet_lines.push_back(pending_line_);
    } else {
      triangles_.push_back({nodes[0], nodes[1], nodes[2]});
    }
  }

  void begin_set(const Options& options, const char* key, std::map<std::string, Set>& sets) {
    const std::string* name = options.find(key);
    if (name == nullptr) fail(std::string("*") + key + " without a name", std::string(key) + "=name");
    Set* set = &set_named(sets, *name);
    const bool generate = options.find("GENERATE") != nullptr;
    const bool nodes = &sets == &node_sets_;
    data_ = [this, set, generate, nodes](const std::vector<std::string_view>& cells) {
      if (generate) return generate_labels(*set, cells, nodes);
      for (const std::string_view cell : cells) {
        if (cell.empty()) continue;
        if (cell.front() >= '0' && cell.front() <= '9')
          set->labels.push_back(integer(cell));
        else
          set->of.push_back(core::upper(cell));
      }
    };
  }

  void generate_labels(Set& set, const std::vector<std::string_view>& cells, bool nodes) {
    if (cells.size() < 2 || cells.size() > 3)
      fail(fmt::format("{} values", cells.size()), "GENERATE: first, last, step");
    const long first = integer(cells[0]), last = integer(cells[1]), step = cells.size() == 3 ? integer(cells[2]) : 1;
    if (step < 1 || last < first) fail("first, last, step that do not rise", "first <= last, step >= 1");
    // No set is longer than the mesh: a slip of a digit must not fill the memory.
    const long known = nodes ? node_index_.size() : tet_index_.size() + triangle_index_.size();
    if ((last - first) / step >= known)
      fail(fmt::format("{} entries", (last - first) / step + 1), fmt::format("at most the {} of the mesh", known));
    for (long label = first; label <= last; label += step) set.labels.push_back(label);
  }

  void begin_surface(const Options& options) {
    const std::string* name = options.find("NAME");
    if (name == nullptr || name->empty()) fail("*SURFACE without NAME", "NAME=name");
    const std::string* type = options.find("TYPE");
    const std::string kind = type == nullptr ? "ELEMENT" : core::upper(*type);
    if (kind != "ELEMENT" && kind != "NODE") return;  // analytic surfaces bound no body
    FaceSurface* surface = &surfaces_[core::upper(*name)];
    surface->name = *name;
    surface->nodes = kind == "NODE";
    data_ = [this, surface](const std::vector<std::string_view>& cells) {
      SurfaceEntry entry;
      entry.line = line_;
      if (cells.empty() || cells[0].empty()) fail("an empty entry", "element or set, side");
      if (cells[0].front() >= '0' && cells[0].front() <= '9')
        entry.label = integer(cells[0]);
      else
        entry.set = core::upper(cells[0]);
      if (!surface->nodes && cells.size() > 1) {
        const std::string side = core::upper(cells[1]);
        if (side == "SPOS" || side == "SNEG")
          entry.face = 0;
        else if (side.size() == 2 && side[0] == 'S' && side[1] >= '1' && side[1] <= '4')
          entry.face = side[1] - '0';
        else
          fail("side '" + std::string(cells[1].substr(0, 40)) + "'", "S1, S2, S3 or S4");
      }
      surface->entries.push_back(std::move(entry));
    };
  }

  /// All labels of a set and of the sets in it.
  std::vector<long> labels_of(const std::map<std::string, Set>& sets, const std::string& key, int line) const {
    std::vector<long> labels;
    std::vector<std::string> open = {key}, seen;
    while (!open.empty()) {
      const std::string name = open.back();
      open.pop_back();
      if (std::find(seen.begin(), seen.end(), name) != seen.end()) continue;
      seen.push_back(name);
      const auto found = sets.find(name);
      if (found == sets.end()) fail("unknown set '" + name.substr(0, 80) + "'", "a set of this file", line);
      labels.insert(labels.end(), found->second.labels.begin(), found->second.labels.end());
      open.insert(open.end(), found->second.of.begin(), found->second.of.end());
    }
    return labels;
  }

  int node(long label, int line) const {
    const auto found = node_index_.find(label);
    if (found == node_index_.end()) fail(fmt::format("node {}", label), "a node of this file", line);
    return found->second;
  }

  void resolve_sets() {
    for (const auto& [key, set] : node_sets_) {
      for (const long label : labels_of(node_sets_, key, set.line))
        raw_.node_sets[set.name].push_back(node(label, set.line));
    }
    for (const auto& [key, set] : element_sets_) {
      for (const long label : labels_of(element_sets_, key, set.line)) {
        if (const auto tet = tet_index_.find(label); tet != tet_index_.end())
          raw_.element_sets[set.name].push_back(tet->second);
        else if (const auto triangle = triangle_index_.find(label); triangle != triangle_index_.end())
          raw_.face_sets[set.name].push_back(triangles_[triangle->second]);
        // else an element of a kind that carries no volume
      }
    }
    for (const auto& [key, surface] : surfaces_)
      for (const SurfaceEntry& entry : surface.entries) add_entry(surface, entry);
  }

  void add_entry(const FaceSurface& surface, const SurfaceEntry& entry) {
    if (surface.nodes) {
      const std::vector<long> labels =
          entry.set.empty() ? std::vector<long>{entry.label} : labels_of(node_sets_, entry.set, entry.line);
      for (const long label : labels) raw_.node_sets[surface.name].push_back(node(label, entry.line));
      return;
    }
    // Sides of the tetrahedron in the manual's numbering: S1 = 1-2-3, S2 = 1-4-2, S3 = 2-4-3, S4 = 3-4-1.
    static constexpr std::size_t side[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    const std::vector<long> labels =
        entry.set.empty() ? std::vector<long>{entry.label} : labels_of(element_sets_, entry.set, entry.line);
    for (const long label : labels) {
      if (const auto triangle = triangle_index_.find(label); triangle != triangle_index_.end()) {
        raw_.face_sets[surface.name].push_back(triangles_[triangle->second]);
        continue;
      }
      const auto tet = tet_index_.find(label);
      if (tet == tet_index_.end()) fail(fmt::format("element {}", label), "an element of this file", entry.line);
      const auto& corner = raw_.tets[tet->second];
      for (int f = 0; f < 4; ++f) {  // no side given: the free sides, which finish() keeps
        if (entry.face == 0 || entry.face == f + 1)
          raw_.face_sets[surface.name].push_back({corner[side[f][0]], corner[side[f][1]], corner[side[f][2]]});
      }
    }
  }

  const std::string& text_;
  RawMesh raw_;
  int line_ = 0, pending_line_ = 0, nodes_per_element_ = 4;
  std::function<void(const std::vector<std::string_view>&)> data_;
  std::vector<long> pending_;
  std::unordered_map<long, int> node_index_, tet_index_, triangle_index_;
  std::vector<std::array<int, 3>> triangles_;
  std::map<std::string, Set> node_sets_, element_sets_;
  std::map<std::string, FaceSurface> surfaces_;
};

}  // namespace

RawMesh parse_inp(const std::string& text, const std::string& source) { return InpReader(text, source).read(); }

}  // namespace thermotwin::mesh
