// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "core/error.h"

namespace thermotwin::tools {
namespace {

constexpr std::size_t name_width = 30, text_width = 70;  ///< columns of --help

std::string wrapped(const std::string& text, std::size_t width) {
  std::istringstream words(text);
  std::string lines;
  std::size_t column = 0;
  for (std::string word; words >> word; column += word.size()) {
    if (column > 0) {
      const bool fits = column + 1 + word.size() <= width;
      lines += fits ? ' ' : '\n';
      column = fits ? column + 1 : 0;
    }
    lines += word;
  }
  return lines;
}

class HelpFormatter final : public CLI::Formatter {
public:
  HelpFormatter() {
    column_width(name_width);
    label("SUBCOMMAND", "VERB");
  }
  std::string make_description(const CLI::App* app) const override {
    return wrapped(app->get_description(), name_width + text_width) + "\n";
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(option->get_description(), text_width);
  }
  std::string make_subcommand(const CLI::App* verb) const override {
    std::ostringstream out;
    CLI::detail::format_help(out, verb->get_display_name(true), wrapped(verb->get_description(), text_width),
                             column_width_);
    return out.str();
  }
};

}  // namespace

std::shared_ptr<CLI::Formatter> help_formatter() { return std::make_shared<HelpFormatter>(); }

void add_common_options(CLI::App& verb, CommonOptions& options) {
  const std::string common = "Common options";
  verb.add_option("--out", options.out, "Folder for results.")->capture_default_str()->group(common);
  verb.add_option("--threads", options.threads, "Number of threads, 0 for all cores; results do not depend on it.")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->group(common);
  verb.add_flag("--quiet", options.quiet, "Print no progress to stderr.")->group(common);
  verb.add_flag("--json", options.json, "Print the summary as one JSON object to stdout.")->group(common);
}

namespace {

void take_over(const CLI::App& group, const CommonOptions& common, CommonOptions& options) {
  const CLI::App& verb = *group.get_subcommands().front();
  const auto only_before = [&](const char* name) { return group.count(name) > 0 && verb.count(name) == 0; };
  if (only_before("--out")) options.out = common.out;
  if (only_before("--threads")) options.threads = common.threads;
  if (only_before("--quiet")) options.quiet = true;
  if (only_before("--json")) options.json = true;
}

}  // namespace

void share_common_options(CLI::App& group, const std::vector<std::shared_ptr<CommonOptions>>& verbs) {
  const auto common = std::make_shared<CommonOptions>();
  add_common_options(group, *common);
  group.parse_complete_callback([&group, common, verbs] {
    for (const auto& options : verbs) take_over(group, *common, *options);
  });
}

CLI::Range seeds() { return {0.0, 9e15}; }

namespace {

// nan is left to require_numbers.
CLI::Validator finite_number(const std::string& name, const std::string& allowed, bool (*is_allowed)(double)) {
  const auto check = [allowed, is_allowed](const std::string& word) {
    double value = 0.0;
    const bool is_good = CLI::detail::lexical_cast(word, value) && !std::isinf(value) && is_allowed(value);
    return is_good ? std::string{} : fmt::format("{} is not a finite number {}", word, allowed);
  };
  return {check, name};
}

}  // namespace

CLI::Validator positive_number() {
  return finite_number("POSITIVE", "above 0", [](double value) { return std::isnan(value) || value > 0.0; });
}

CLI::Validator start_temperature() { return CLI::Range(-50.0, 100.0); }

CLI::Validator non_negative_number() {
  return finite_number("NONNEGATIVE", "of at least 0", [](double value) { return std::isnan(value) || value >= 0.0; });
}

void require_numbers(const CLI::App& verb) {
  for (const CLI::Option* option : verb.get_options()) {
    if (!option->get_type_name().starts_with("FLOAT")) continue;
    for (const std::string& word : option->results()) {
      double value = 0.0;
      if (CLI::detail::lexical_cast(word, value) && std::isnan(value))
        throw core::InputError(option->get_name(), word, "a number");
    }
  }
}

void add_mesh_options(CLI::App& verb, std::string& size, int& order, const std::string& order_name) {
  verb.add_option(
      "--size", size,
      "Mesh size: coarse, standard, fine, or a factor on the element sizes (default: size of case.toml, else coarse).");
  verb.add_option(order_name, order, "Order of the tetrahedra: 1 linear, 2 quadratic (default: order of machine.toml).")
      ->check(CLI::Range(1, 2));
}

void add_checkpoint_option(CLI::App& verb, double& every_s) {
  verb.add_option("--checkpoint-every", every_s, "Wall-clock time between checkpoints, s.")
      ->check(non_negative_number())
      ->capture_default_str();
}

void add_solver_option(CLI::App& verb, std::string& solver) {
  verb.add_option("--solver", solver,
                  "Linear solver: direct, iterative, or auto: direct while its factors fit into memory.")
      ->check(CLI::IsMember({"auto", "direct", "iterative"}))
      ->capture_default_str();
}

}  // namespace thermotwin::tools
