// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <sstream>
#include <variant>

#include "bank.h"

namespace thermotwin::hidden {

namespace {

struct Column {
  const char* name;
  std::variant<std::string Line::*, double Line::*, diagnosis::Verdict Line::*> member;
};

const std::vector<Column>& columns() {
  static const std::vector<Column> all = {
      {"id", &Line::id},
      {"group", &Line::group},
      {"kind", &Line::kind},
      {"where", &Line::where},
      {"kind2", &Line::kind2},
      {"where2", &Line::where2},
      {"value", &Line::value},
      {"nominal_std", &Line::nominal_std},
      {"against_none", &Line::against_none},
      {"against_rival", &Line::against_rival},
      {"rival", &Line::rival},
      {"verdict", &Line::verdict},
      {"named_kind", &Line::named_kind},
      {"named_where", &Line::named_where},
      {"set", &Line::set},
      {"probability", &Line::probability},
      {"rank", &Line::rank},
      {"estimate", &Line::estimate},
      {"std", &Line::std},
      {"named_probability", &Line::named_probability},
      {"gain", &Line::gain},
      {"heldout_before_um", &Line::heldout_before},
      {"heldout_after_um", &Line::heldout_after},
      {"heldout_truth_um", &Line::heldout_truth},
      {"program_before_um", &Line::program_before},
      {"program_after_um", &Line::program_after},
      {"program_truth_um", &Line::program_truth},
      {"poses_before_um", &Line::poses_before},
      {"poses_after_um", &Line::poses_after},
      {"poses_truth_um", &Line::poses_truth},
      {"refit_heldout_um", &Line::refit_heldout},
      {"refit_program_um", &Line::refit_program},
      {"refit_right", &Line::refit_right},
      {"process_heldout_um", &Line::process_heldout},
      {"process_program_um", &Line::process_program},
      {"sparse_heldout_um", &Line::sparse_heldout},
      {"sparse_program_um", &Line::sparse_program},
      {"place_error_mm", &Line::place_error},
      {"region_mm", &Line::region},
      {"follows_right", &Line::follows_right},
      {"seconds", &Line::seconds},
      {"second_named", &Line::second_named},
      {"place_allowed_mm", &Line::place_allowed},
      {"refit_over_winner", &Line::refit_over_winner},
  };
  return all;
}

constexpr std::size_t fewest_columns = 42;  // up to second_named

}  // namespace

std::string Line::header() {
  std::string text;
  for (const Column& column : columns()) text += (text.empty() ? "" : "\t") + std::string(column.name);
  return text;
}

std::string Line::text() const {
  std::string text;
  for (const Column& column : columns()) {
    if (&column != &columns().front()) text += '\t';
    if (const auto* words = std::get_if<std::string Line::*>(&column.member))
      text += this->**words;
    else if (const auto* of_kind = std::get_if<diagnosis::Verdict Line::*>(&column.member))
      text += diagnosis::name_of(this->**of_kind);
    else
      text += fmt::format("{:.6g}", this->*std::get<double Line::*>(column.member));
  }
  return text;
}

Line Line::parse(const std::string& text) {
  std::vector<std::string> cells;
  std::istringstream stream(text);
  for (std::string cell; std::getline(stream, cell, '\t');) cells.push_back(cell);
  Line line;
  if (cells.size() < fewest_columns || cells.size() > columns().size()) return line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (const auto* words = std::get_if<std::string Line::*>(&columns()[i].member))
      line.** words = cells[i];
    else if (const auto* verdict = std::get_if<diagnosis::Verdict Line::*>(&columns()[i].member)) {
      const auto named = diagnosis::verdict_named(cells[i]);
      if (!named) return {};
      line.** verdict = *named;
    } else
      line.*std::get<double Line::*>(columns()[i].member) = std::stod(cells[i]);
  }
  return line;
}

}  // namespace thermotwin::hidden
