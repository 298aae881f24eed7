// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/variants/variant_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/quoted.h"
#include "core/statistics.h"
#include "core/text.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "study/units/unit_files.h"

namespace thermotwin::study {

namespace fs = std::filesystem;
using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index error_values = 6;
constexpr const char* value_names[] = {"error_um",    "dx_um",       "dy_um",      "dz_um",
                                       "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"};
constexpr double levels[] = {0.05, 0.5, 0.95};
constexpr const char* level_names[] = {"_q05", "_q50", "_q95"};

/// Results of one load of one group: all variants that have some.
struct Block {
  core::Table frame;                  // of the first: times and poses
  std::vector<std::size_t> variants;  // indices into the design
  std::vector<MatrixXd> errors;       // (rows of the table x 6) each
};

Block read_block(const fs::path& study, const std::vector<std::size_t>& members,
                 const std::map<std::size_t, const VariantUnit*>& units) {
  Block block;
  for (const std::size_t v : members) {
    const auto unit = units.find(v);
    if (unit == units.end()) continue;
    const fs::path file = unit_folder(study, *unit->second) / tcp_file(v);
    core::Table table = core::read_csv(file);
    if (table.values.cols() < error_values || (!block.errors.empty() && table.rows() != block.frame.rows()))
      throw core::InputError(file.string(), fmt::format("{} rows", table.rows()),
                             fmt::format("{} rows, as the other variants have", block.frame.rows()));
    block.errors.emplace_back(table.values.rightCols(error_values));
    block.variants.push_back(v);
    if (block.variants.size() == 1) block.frame = std::move(table);
  }
  return block;
}

/// Quantiles over these variants of the block.
core::Table quantiles_of(const Block& block, const std::vector<std::size_t>& of) {
  const Index before = block.frame.values.cols() - error_values, rows = block.frame.rows();
  core::Table table;
  table.columns.assign(block.frame.columns.begin(), block.frame.columns.begin() + before);
  for (const char* name : value_names)
    for (const char* level : level_names) table.columns.push_back(std::string(name) + level);
  table.values.resize(rows, std::ssize(table.columns));
  table.values.leftCols(before) = block.frame.values.leftCols(before);
  core::parallel_for(
      0, rows,
      [&](std::size_t row) {
        const Index r = row;
        std::vector<double> values(of.size());
        for (Index k = 0; k <= error_values; ++k) {
          for (std::size_t i = 0; i < of.size(); ++i) {
            const MatrixXd& errors = block.errors[of[i]];
            values[i] = k == 0 ? errors.row(r).head<3>().norm() : errors(r, k - 1);
          }
          for (Index level = 0; level < 3; ++level)
            table.values(r, before + 3 * k + level) = core::quantile(values, levels[level]);
        }
      },
      64);
  return table;
}

/// Translations of every variant, (variants x outputs). @param pose  -1: at all poses
MatrixXd translations(const Block& block, Index poses, Index pose) {
  const Index rows = block.frame.rows(), each = pose < 0 ? 1 : poses, first = std::max<Index>(pose, 0);
  const Index count = (rows - first + each - 1) / each;
  MatrixXd outputs(std::ssize(block.errors), 3 * count);
  for (Index v = 0; v < outputs.rows(); ++v)
    for (Index i = 0; i < count; ++i)
      outputs.row(v).segment<3>(3 * i) = block.errors[v].row(first + i * each).head<3>();
  return outputs;
}

class Sensitivities {
public:
  Sensitivities(const StudyPlan& plan, const Design& design, const Block& block)
      : pick_(plan.sampling == Sampling::pick_freeze) {
    const auto samples = std::ssize(block.variants), drawn = std::ssize(design.drawn);
    values_.resize(samples, drawn);
    for (Index k = 0; k < drawn; ++k) {
      distributions_.push_back(plan.parameters[design.drawn[k]].distribution);
      for (Index i = 0; i < samples; ++i) values_(i, k) = design.variants[block.variants[i]].values[design.drawn[k]];
    }
  }
  Sensitivity of(const MatrixXd& outputs) const {
    return pick_ ? pick_freeze(outputs, values_.cols()) : by_regression(values_, distributions_, outputs);
  }

private:
  bool pick_;
  MatrixXd values_;
  std::vector<Distribution> distributions_;
};

/// The reason why a group of drawn variants has no sensitivities; empty: it has some.
std::string obstacle(const StudyPlan& plan, const Design& design, std::size_t present) {
  const int drawn = design.drawn.size();
  const std::size_t rows = design.rows;
  if (plan.sampling == Sampling::pick_freeze) {
    if (present < rows) return fmt::format("{} of {} variants have results, and pick_freeze needs all", present, rows);
    return plan.samples < 4 ? "pick_freeze needs 4 samples or more" : "";
  }
  const std::size_t least = least_samples(drawn);
  if (present >= least) return "";
  return fmt::format("{} samples of {} parameters; sensitivities need {} or more", present, drawn, least);
}

/// Of all variants of a block. The rows of a table run over the poses of each time.
std::vector<VariantError> errors_of(const Block& block, Index poses) {
  std::vector<VariantError> errors;
  const Eigen::VectorXd time = block.frame.values.col(0);
  for (std::size_t i = 0; i < block.errors.size(); ++i) {
    const Eigen::VectorXd length = block.errors[i].leftCols<3>().rowwise().norm();
    Index at = 0;
    VariantError error{block.variants[i]};
    error.largest_um = length.maxCoeff(&at);
    error.largest_at_s = time[at];
    error.end_um = length.tail(std::min(poses, length.size())).maxCoeff();
    errors.push_back(error);
  }
  return errors;
}

LoadStudy study_load(const StudyPlan& plan, const Design& design, const Block& block, const std::string& load,
                     bool sensitive, Index poses) {
  LoadStudy found;
  found.load = load;
  found.errors = errors_of(block, poses);
  std::vector<std::size_t> of;  // draws from the distributions themselves
  const std::size_t each = design.drawn.size() + 2;
  const bool pick = plan.sampling == Sampling::pick_freeze && !design.drawn.empty();
  for (std::size_t i = 0; i < block.errors.size(); ++i) {
    const std::size_t row = block.variants[i] % design.rows;
    if (!pick || row % each < 2) of.push_back(i);
  }
  found.quantiles = quantiles_of(block, of);
  found.largest_q50_um = found.quantiles.column("error_um_q50").maxCoeff();
  found.largest_q95_um = found.quantiles.column("error_um_q95").maxCoeff();
  if (!sensitive) return found;
  const Sensitivities sensitivities(plan, design, block);
  found.sensitivity = sensitivities.of(translations(block, poses, -1));
  found.at_poses.resize(poses);
  core::parallel_for(0, found.at_poses.size(),
                     [&](std::size_t p) { found.at_poses[p] = sensitivities.of(translations(block, poses, p)); });
  return found;
}

std::string share_words(const Sensitivity& of, std::size_t parameter) {
  const Share &first = of.first[parameter], &total = of.total[parameter];
  return fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}", first.value, first.low, first.high, total.value,
                     total.low, total.high);
}

constexpr const char* share_columns = "first,first_low,first_high,total,total_low,total_high";

std::string by_parameter(const std::vector<std::string>& names, const Sensitivity& of) {
  std::string text = std::string("parameter,") + share_columns + "\n";
  for (std::size_t p = 0; p < names.size(); ++p) text += names[p] + "," + share_words(of, p) + "\n";
  return text;
}

std::string by_pose(const mesh::Machine& machine, const VariantStudy& results, const LoadStudy& load) {
  std::string text = "parameter";
  for (const std::string& name : mesh::pose_columns(machine)) text += "," + name;
  text += std::string(",std_um,") + share_columns + "\n";
  for (std::size_t p = 0; p < results.drawn.size(); ++p) {
    for (std::size_t i = 0; i < load.at_poses.size(); ++i) {
      text += results.drawn[p];
      for (const double value : mesh::pose_values(machine, results.poses[i])) text += fmt::format(",{:.9g}", value);
      // Of the length at one time, on average over the times.
      const double rows = load.quantiles.rows(), times = rows / load.at_poses.size();
      text += fmt::format(",{:.6g},", std::sqrt(load.at_poses[i].variance / times));
      text += share_words(load.at_poses[i], p) + "\n";
    }
  }
  return text;
}

core::Table variants_table(const StudyPlan& plan, const Design& design, const std::vector<int>& results) {
  core::Table table;
  table.columns = {"variant", "group"};
  for (const StudyParameter& parameter : plan.parameters) table.columns.push_back(parameter.name);
  table.columns.emplace_back("results");
  table.values.resize(std::ssize(design.variants), std::ssize(table.columns));
  for (Index v = 0; v < table.rows(); ++v) {
    const Variant& variant = design.variants[v];
    table.values(v, 0) = v + 1;
    table.values(v, 1) = variant.group + 1;
    table.values.row(v).segment(2, std::ssize(plan.parameters)) = variant.values.transpose();
    table.values(v, table.values.cols() - 1) = results[v];
  }
  return table;
}

std::string failures(const Design& design, const VariantStudy& results) {
  std::string text = "variant,group,load,reason\n";
  for (const FailedVariant& one : results.failed) {
    text += fmt::format("{},{},{},{}\n", one.variant + 1, design.variants[one.variant].group + 1, one.load,
                        core::csv_cell(one.reason));
  }
  return text;
}

}  // namespace

std::size_t VariantStudy::computed() const {
  return std::count_if(results.begin(), results.end(), [&](int count) { return count > 0 && count >= loads; });
}

std::size_t VariantStudy::failed_variants() const {
  std::set<std::size_t> variants;
  for (const FailedVariant& one : failed) variants.insert(one.variant);
  return variants.size();
}

std::vector<std::size_t> by_total(const Sensitivity& sensitivity) {
  std::vector<std::size_t> order(sensitivity.total.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return sensitivity.total[a].value > sensitivity.total[b].value;
  });
  return order;
}

std::vector<std::size_t> that_matter(const Sensitivity& sensitivity) {
  std::vector<std::size_t> order = by_total(sensitivity);
  std::erase_if(order, [&](std::size_t p) {
    return sensitivity.total[p].value < share_that_matters || !(sensitivity.total[p].low > 0.0);
  });
  return order;
}

std::vector<std::vector<std::string>> error_rows(const StudyPlan& plan, const Design& design,
                                                 const VariantStudy& results, bool with_values, std::size_t most) {
  std::vector<std::vector<std::string>> rows{{"variant", "group"}};
  std::vector<Index> shown;  // parameters that differ between variants
  for (Index p = 0; with_values && p < std::ssize(plan.parameters); ++p) {
    const auto differs = [&](const Variant& one) { return one.values[p] != design.variants.front().values[p]; };
    if (std::any_of(design.variants.begin(), design.variants.end(), differs)) shown.push_back(p);
  }
  for (const Index p : shown) rows[0].push_back(plan.parameters[p].name);
  for (const char* head : {"load", "largest_error_um", "at_h", "error_at_end_um"}) rows[0].emplace_back(head);
  for (const GroupStudy& group : results.groups) {
    for (const LoadStudy& load : group.loads) {
      for (const VariantError& error : load.errors) {
        if (rows.size() > most) return rows;
        std::vector<std::string> row{std::to_string(error.variant + 1), group.name};
        for (const Index p : shown) row.push_back(fmt::format("{:.6g}", design.variants[error.variant].values[p]));
        row.push_back(load.load);
        row.push_back(fmt::format("{:.6g}", error.largest_um));
        row.push_back(fmt::format("{:.4g}", error.largest_at_s / core::units::hour));
        row.push_back(fmt::format("{:.6g}", error.end_um));
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

VariantStudy gather(const fs::path& study, const StudyPlan& plan, const Design& design,
                    const std::vector<VariantUnit>& units) {
  VariantStudy results;
  const mesh::Machine& machine = plan.machine_case.machine;
  results.poses = mesh::workspace_poses(machine);
  results.loads = plan.loads.size();
  results.results.assign(design.variants.size(), 0);
  for (const int p : design.drawn) results.drawn.push_back(plan.parameters[p].name);
  const std::vector<Unit> plain(units.begin(), units.end());
  const Standing standing = standing_of(study, plain);
  std::map<std::string, std::map<std::size_t, const VariantUnit*>> done;  // load, variant
  for (const std::size_t u : standing.done) {
    for (const std::size_t v : units[u].variants) {
      done[units[u].load][v] = &units[u];
      ++results.results[v];
    }
  }
  results.units_done = standing.done.size();
  results.missing = missing_words(plain, standing);
  results.failed_units = failed_words(plain, standing);
  for (const auto& [u, reason] : standing.failed)
    for (const std::size_t v : units[u].variants) results.failed.push_back({v, units[u].load, reason});
  std::stable_sort(results.failed.begin(), results.failed.end(),
                   [](const FailedVariant& a, const FailedVariant& b) { return a.variant < b.variant; });
  for (std::size_t g = 0; g < design.groups.size(); ++g) {
    const std::vector<std::size_t> members = design.of_group(g);
    GroupStudy group;
    group.name = design.groups[g].name;
    group.asked = group.variants = members.size();
    for (const std::string& load : plan.loads) {
      const Block block = read_block(study, members, done[load]);
      group.variants = std::min(group.variants, block.variants.size());
      if (block.variants.empty()) continue;
      const std::string why = design.drawn.empty() ? "" : obstacle(plan, design, block.variants.size());
      if (!why.empty()) group.why_no_sensitivity = why;
      group.loads.push_back(
          study_load(plan, design, block, load, !design.drawn.empty() && why.empty(), std::ssize(results.poses)));
    }
    results.groups.push_back(std::move(group));
  }
  return results;
}

void write_results(const fs::path& study, const StudyPlan& plan, const Design& design, const VariantStudy& results) {
  for (const GroupStudy& group : results.groups) {
    for (const LoadStudy& load : group.loads) {
      const fs::path folder = study / group.name / load.load;
      core::write_csv(folder / "quantiles.csv", load.quantiles);
      if (!load.sensitivity) continue;
      core::write_file(folder / "sensitivities.csv", by_parameter(results.drawn, *load.sensitivity));
      core::write_file(folder / "sensitivities_by_pose.csv", by_pose(plan.machine_case.machine, results, load));
    }
  }
  std::string errors;
  for (const std::vector<std::string>& row :
       error_rows(plan, design, results, false, design.variants.size() * plan.loads.size()))
    errors += core::join(row, ",") + "\n";
  core::write_file(study / "errors.csv", errors);
  core::write_csv(study / "variants.csv", variants_table(plan, design, results.results), table_digits);
  std::error_code ignored;
  if (results.failed.empty())
    fs::remove(study / "failures.csv", ignored);
  else
    core::write_file(study / "failures.csv", failures(design, results));
}

}  // namespace thermotwin::study
