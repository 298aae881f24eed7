// SPDX-License-Identifier: GPL-3.0-or-later
// `reduce --matrices`: systems of other programs.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.h"
#include "core/text.h"
#include "reduction/systems/system_file.h"
#include "reduction/systems/system_reduction.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {

namespace {

using reduction::PointResult;
using reduction::SystemReduction;

double number_of(const std::string& text, const std::string& place) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw core::InputError(place, "'" + text + "'", "a finite number");
  return value;
}

std::string films_allowed(const std::string& name, const std::vector<std::string>& names) {
  constexpr std::size_t most_listed = 12;
  const std::string nearest = "nearest: " + core::nearest(name, names);
  if (names.size() <= most_listed) return "one of: " + core::join(names) + " (" + nearest + ")";
  return fmt::format("one of the {} NAMEs of A_film_NAME.mtx ({})", names.size(), nearest);
}

/// Every combination of the films' values, those not named where they stand.
std::vector<std::vector<double>> points_of(const std::vector<std::string>& arguments,
                                           const reduction::LinearSystem& system) {
  std::vector<std::vector<double>> values(system.films.size());
  std::vector<std::string> names;
  for (const auto& film : system.films) names.push_back(film.name);
  for (const std::string& argument : arguments) {
    const std::string place = "--film " + argument;
    const std::size_t equals = argument.find('=');
    if (equals == std::string::npos) throw core::InputError(place, "no value", "NAME=VALUE[,VALUE...]");
    const std::string name = argument.substr(0, equals);
    const auto known = std::find(names.begin(), names.end(), name);
    if (known == names.end()) {
      throw core::InputError(
          place, "'" + name + "'",
          names.empty() ? "the NAME of an A_film_NAME.mtx in the folder, which has none" : films_allowed(name, names));
    }
    std::vector<double>& list = values[known - names.begin()];
    if (!list.empty())
      throw core::InputError(place, "'" + name + "' named twice", "each film once, with all its values");
    for (std::size_t from = equals + 1; from <= argument.size();) {
      const std::size_t comma = std::min(argument.find(',', from), argument.size());
      list.push_back(number_of(argument.substr(from, comma - from), place));
      from = comma + 1;
    }
  }
  std::vector<std::vector<double>> points{{}};
  constexpr std::size_t most = 64;
  for (std::size_t j = 0; j < values.size(); ++j) {
    std::vector<double>& list = values[j];
    if (list.empty()) list.push_back(system.films[j].value);
    std::vector<std::vector<double>> more;
    for (const auto& point : points) {
      for (const double value : list) {
        more.push_back(point);
        more.back().push_back(value);
      }
    }
    points = std::move(more);
    if (points.size() > most) {
      throw core::InputError("--film", fmt::format("{} combinations of values or more", points.size()),
                             fmt::format("at most {}", most));
    }
  }
  return points;
}

/// Films that are elsewhere than in the files' own point, and how many are not.
std::string films_text(const reduction::LinearSystem& system, const PointResult& point) {
  std::vector<std::string> moved;
  for (std::size_t j = 0; j < point.films.size(); ++j) {
    if (point.films[j] != system.films[j].value)
      moved.push_back(fmt::format("{} {:.6g}", system.films[j].name, point.films[j]));
  }
  const std::size_t rest = point.films.size() - moved.size();
  if (moved.empty()) return "every film at its value in names.toml, or 1 without one";
  return core::join(moved) + (rest > 0 ? fmt::format("; the {} other films unchanged", rest) : "");
}

std::string hankel_text(const PointResult& point) {
  constexpr Eigen::Index shown = 12;
  std::string text;
  for (Eigen::Index k = 0; k < std::min(shown, point.hankel.size()); ++k)
    text += fmt::format("{}{:.6e}", k == 0 ? "" : k % 6 == 0 ? "\n            " : "  ", point.hankel(k));
  return fmt::format(
      "Hankel      {}\n            {}\n", text,
      point.complete
          ? fmt::format("the leading {} of {}, all computed", std::min(shown, point.hankel.size()), point.hankel.size())
          : fmt::format("the leading {} of {} computed from low-rank Gramians ({} steps, relative residual {:.1e})",
                        std::min(shown, point.hankel.size()), point.hankel.size(), point.gramian_steps,
                        point.gramian_residual));
}

/// What rounding may make of the bound: each Hankel singular value is off by up to n eps of the largest.
double bound_rounding(const PointResult& point) {
  const double n = point.hankel.size();
  return 2.0 * (n - point.order) * n * std::numeric_limits<double>::epsilon() * point.hankel(0);
}

std::string bound_text(const SystemReduction& reduction, const PointResult& point) {
  const double norm = point.norm.value;
  std::string text =
      fmt::format("H-infinity  norm {:.6e} at {:.4g} rad/s (sampled, without D)\n", norm, point.norm.frequency);
  const bool balanced = reduction.method == reduction::Method::balanced;
  text += fmt::format(
      "bound       {:.3e}, {:.2e} of the norm: twice the sum of the Hankel singular values beyond {}{}\n", point.bound,
      point.bound / norm, point.order,
      reduction.joined ? ";\n            valid for the balanced model of this point alone, not for the joined model"
      : balanced       ? ""
                 : fmt::format(";\n            valid for balanced truncation, not for {}", word(reduction.method)));
  if (!point.complete) {
    text +=
        point.unknown_sum
            ? fmt::format(
                  "            uncomputed values, and errors of the computed ones, change the sum by {:.1e} at most\n",
                  *point.unknown_sum)
            : std::string(
                  "            uncomputed values are not included: no bound of their sum is known for this system\n");
  }
  text += fmt::format(
      "true error  {:.3e}, {:.2e} of the norm, at {:.4g} rad/s (largest of {} frequencies of the full system{})\n",
      point.error.value, point.error.value / norm, point.error.frequency, point.samples,
      point.dense ? " and searches between them" : "");
  const double excess = point.error.value - point.bound, rounding = bound_rounding(point);
  if (balanced && !reduction.joined && excess > 0.0 && point.bound <= rounding) {
    text += fmt::format("            nothing is cut off; the error is {} the rounding error of {:.1e}\n",
                        excess <= rounding ? "within" : "beyond", rounding);
  } else if (balanced && !reduction.joined && excess > 0.0) {
    text += fmt::format(
        "            the error exceeds the bound by {:.1e} of it, {} the rounding error of {:.1e} of the Hankel "
        "singular values\n",
        excess / point.bound, excess <= rounding ? "within" : "beyond", rounding / point.bound);
  }
  return text;
}

nlohmann::json point_json(const reduction::LinearSystem& system, const SystemReduction& reduction,
                          const PointResult& point) {
  nlohmann::json json = {{"order", point.order},
                         {"hankel_singular_values", std::vector<double>(point.hankel.begin(), point.hankel.end())},
                         {"hankel_complete", point.complete},
                         {"bound", point.bound},
                         {"bound_relative", point.bound / point.norm.value},
                         {"bound_holds", reduction.method == reduction::Method::balanced && !reduction.joined &&
                                             point.error.value <= point.bound + bound_rounding(point)},
                         {"bound_rounding", bound_rounding(point)},
                         {"hinf_norm_sampled", point.norm.value},
                         {"hinf_norm_frequency_rad_s", point.norm.frequency},
                         {"hinf_error_sampled", point.error.value},
                         {"hinf_error_relative", point.error.value / point.norm.value},
                         {"hinf_error_frequency_rad_s", point.error.frequency},
                         {"frequencies", point.samples},
                         {"stable", point.stable},
                         {"full_system_proved_stable", point.proved_stable}};
  json["hankel_unknown_sum"] = point.unknown_sum ? nlohmann::json(*point.unknown_sum) : nlohmann::json();
  if (point.complete) json["hankel_unknown_sum"] = 0.0;
  if (!point.complete) json["gramians"] = {{"steps", point.gramian_steps}, {"residual", point.gramian_residual}};
  json["films"] = nlohmann::json::object();
  for (std::size_t j = 0; j < point.films.size(); ++j) json["films"][system.films[j].name] = point.films[j];
  return json;
}

std::string comparison_text(const SystemReduction& reduction, nlohmann::json& json) {
  if (reduction.comparison.empty()) return "";
  const PointResult& point = reduction.points.front();
  std::vector<std::vector<std::string>> table{{"method", "order", "true error", "of the norm", "bound", "stable"}};
  for (const auto& row : reduction.comparison) {
    const double bound = reduction::bound_of(point.hankel, row.order);
    const bool balanced = row.method == reduction::Method::balanced;
    table.push_back({word(row.method), std::to_string(row.order), fmt::format("{:.3e}", row.error),
                     fmt::format("{:.2e}", row.error / point.norm.value), balanced ? fmt::format("{:.3e}", bound) : "-",
                     row.stable ? "yes" : "no"});
    json["compare"].push_back({{"method", word(row.method)},
                               {"order", row.order},
                               {"hinf_error_sampled", row.error},
                               {"stable", row.stable}});
    json["compare"].back()["bound"] = balanced ? nlohmann::json(bound) : nlohmann::json();
  }
  return core::format_table(table) + "\n";
}

}  // namespace

void reduce_matrices(const ReduceOptions& options) {
  const Stopwatch time;
  const reduction::LinearSystem system = reduction::read_linear_system(options.matrices);
  reduction::check_system_folder(options.out, system);
  reduction::SystemReductionOptions how;
  if (!options.method.empty()) how.method = reduction::method_of(options.method);
  how.order = options.order;
  how.tolerance = options.tolerance;
  how.absolute = options.absolute;
  how.compare = options.compare;
  how.points = points_of(options.films, system);
  const double read_seconds = time.seconds();
  const SystemReduction reduced = reduction::reduce_system(system, how);
  const reduction::SystemNames names{system.input_names, system.output_names, word(reduced.method)};
  reduction::write_system(options.out, system, reduced,
                          names.inputs.empty() && names.outputs.empty() ? nullptr : &names);

  const reduction::StateSpace& base = system.base;
  const PointResult& first = reduced.points.front();
  nlohmann::json json = point_json(system, reduced, first);
  json["n"] = base.size();
  json["inputs"] = base.inputs();
  json["outputs"] = base.outputs();
  json["method"] = word(reduced.method);
  json["route"] = first.dense ? "dense" : "low_rank";
  json["order"] = reduced.model.order();
  json["stable"] = reduced.stable();
  json["converged"] = reduced.converged;
  for (const PointResult& point : reduced.points) json["points"].push_back(point_json(system, reduced, point));
  json["folder"] = options.out.string();

  std::string text =
      fmt::format("system      {} states, {} inputs, {} outputs{}{}{}\n", base.size(), base.inputs(), base.outputs(),
                  base.symmetric ? ", symmetric" : "", base.identity ? ", E = 1" : "",
                  first.proved_stable ? "" : "; no unstable eigenvalue was found, which does not prove stability");
  for (const PointResult& point : reduced.points) {
    if (!point.films.empty()) text += fmt::format("at          {}\n", films_text(system, point));
    text += hankel_text(point) + bound_text(reduced, point);
  }
  if (!reduced.converged) text += "krylov      the shifts had not converged at the last iteration\n";
  text += comparison_text(reduced, json);
  json["read_seconds"] = read_seconds;
  json["seconds"] = time.seconds();
  json["peak_memory_GiB"] = peak_memory_GiB();
  text += fmt::format("reduced     order {} by {}, stable; matrices and {} in {}; {:.1f} s, {:.2f} GiB\n",
                      reduced.model.order(), word(reduced.method), reduction::system_file_name, options.out.string(),
                      time.seconds(), peak_memory_GiB());
  print_summary(options, text, json.dump());
}

}  // namespace thermotwin::tools
