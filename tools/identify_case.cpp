// SPDX-License-Identifier: GPL-3.0-or-later
// `reduce CASE --from-campaign`: a model identified from the tables of a campaign alone.

#include "tools/identify_case.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "core/error.h"
#include "core/file.h"
#include "core/line_chart.h"
#include "core/text.h"
#include "reduction/basis/reduce.h"
#include "reduction/systems/system_file.h"
#include "solver/campaign/case.h"
#include "solver/campaign/load_result.h"
#include "solver/export/picture.h"
#include "tools/chain.h"

namespace thermotwin::tools {

namespace fs = std::filesystem;

std::vector<reduction::ReductionErrors> IdentifiedCase::errors(Eigen::Index order) const {
  const reduction::ReducedLinearSystem system = model.model(order);
  std::vector<reduction::ReductionErrors> all;
  for (std::size_t i = 0; i < heldout.size(); ++i) {
    solver::LoadResult truth;
    truth.load = tables[i].load;
    truth.tcp = tables[i].tcp;
    all.push_back(reduction::compare(truth, model.predicted(system, heldout[i], tables[i])));
  }
  return all;
}

IdentifiedCase identify_case(const solver::Case& machine_case, const fs::path& campaign, Eigen::Index order) {
  const Stopwatch watch;
  const mesh::Machine& machine = machine_case.machine;
  reduction::CampaignInputs inputs(machine);
  std::vector<reduction::Samples> training, heldout;
  std::vector<reduction::CampaignTables> tables;
  std::vector<std::string> outputs;
  for (const std::string& load : machine_case.train) {
    const reduction::CampaignTables of_load = reduction::read_campaign_tables(campaign, load);
    training.push_back(reduction::make_samples(inputs, of_load, machine.reference_C));
    if (outputs.empty()) outputs = reduction::campaign_output_names(machine, of_load);
  }
  for (const std::string& load : machine_case.holdout) {
    tables.push_back(reduction::read_campaign_tables(campaign, load));
    heldout.push_back(reduction::make_samples(inputs, tables.back(), machine.reference_C));
  }
  reduction::IdentifyOptions how;
  how.order = order;
  reduction::Identification model(training, inputs.even(), how);
  return {std::move(inputs),  std::move(model),   std::move(tables),
          std::move(heldout), std::move(outputs), watch.seconds()};
}

namespace {

std::vector<std::string> names_of(const IdentifiedCase& made, const std::vector<Eigen::Index>& inputs) {
  std::vector<std::string> names;
  for (const Eigen::Index k : inputs) names.push_back(made.inputs.names()[k]);
  return names;
}

/// RMS on what was kept out, and the worst on each held-out load, over the order.
void write_picture(const fs::path& file, const std::string& machine, const IdentifiedCase& made,
                   const std::vector<std::vector<reduction::ReductionErrors>>& errors) {
  core::LineChart chart;
  chart.title = fmt::format("Order and error of models identified from tables, {}", machine);
  chart.x_title = "order";
  chart.y_title = "TCP error, \u00b5m";
  chart.log_y = true;
  core::LineChart::Line line{"RMS on " + made.model.kept_out(), {}};
  for (const auto& [order, error] : made.model.order_error_um()) line.points.emplace_back(order, error);
  chart.lines.push_back(std::move(line));
  for (std::size_t l = 0; l < made.heldout.size(); ++l) {
    core::LineChart::Line of_load{made.heldout[l].load + ", largest", {}};
    for (std::size_t i = 0; i < errors.size(); ++i)
      of_load.points.emplace_back(made.model.order_error_um()[i].first, errors[i][l].max_um);
    chart.lines.push_back(std::move(of_load));
  }
  core::write_file(file, chart.svg());
}

}  // namespace

void reduce_from_campaign(const ReduceOptions& options) {
  const Stopwatch time;
  const solver::Case machine_case = solver::read_case(options.case_path);
  const fs::path folder = options.campaign.empty() ? options.out / "campaign" : options.campaign;
  const IdentifiedCase made = identify_case(machine_case, folder, options.order);
  const Eigen::Index order = made.model.order();
  require_writable(options.out);

  reduction::SystemReductionOptions how;
  how.order = order;
  reduction::SystemReduction reduced = reduction::reduce_system(made.model.lags(), how);
  reduced.model = made.model.model(order);
  const reduction::SystemNames names{made.inputs.names(), made.outputs, "identified"};
  reduction::write_system(options.out, made.model.lags(), reduced, &names);

  nlohmann::json json = {{"method", "identified"},
                         {"order", order},
                         {"lags", made.model.lags().base.size()},
                         {"inputs", made.inputs.names().size()},
                         {"kept_out", made.model.kept_out()},
                         {"ridge", made.model.ridge()},
                         {"stable", reduced.stable()},
                         {"identify_s", made.seconds},
                         {"never_moved", names_of(made, made.model.never_moved())}};
  std::vector<std::vector<std::string>> table{{"order", "RMS on held-out rows um"}};
  for (const reduction::Samples& load : made.heldout) table[0].push_back(load.load + " max um");
  std::vector<std::vector<reduction::ReductionErrors>> errors;
  for (const auto& [tried, error] : made.model.order_error_um()) {
    errors.push_back(made.errors(tried));
    table.push_back({std::to_string(tried), fmt::format("{:.2f}", error)});
    for (const auto& e : errors.back()) table.back().push_back(fmt::format("{:.2f}", e.max_um));
    json["orders"].push_back({{"order", tried}, {"kept_out_rms_um", error}});
  }
  std::string text = core::format_table(table) + "\n\n";
  table = {{"held-out load", "peak um", "max error um", "rms um", "of peak %", "inputs beyond training"}};
  const std::vector<reduction::ReductionErrors> chosen = made.errors(order);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const reduction::ReductionErrors& e = chosen[i];
    const std::vector<std::string> beyond = names_of(made, made.model.beyond(made.heldout[i]));
    table.push_back({e.load, fmt::format("{:.2f}", e.peak_um), fmt::format("{:.2f}", e.max_um),
                     fmt::format("{:.2f}", e.rms_um), fmt::format("{:.1f}", 100 * e.max_um / e.peak_um),
                     beyond.empty() ? "-" : fmt::format("{}", fmt::join(beyond, ", "))});
    json["heldout"].push_back(
        {{"load", e.load}, {"peak_um", e.peak_um}, {"max_um", e.max_um}, {"rms_um", e.rms_um}, {"beyond", beyond}});
  }
  text += core::format_table(table) + "\n";
  write_picture(options.out / "order.svg", machine_case.machine.name, made, errors);
  json["seconds"] = time.seconds();
  const std::vector<std::string> unknown = names_of(made, made.model.never_moved());
  if (!unknown.empty())
    text += fmt::format("unknown     the effect of {}, which are constant in all training loads\n",
                        fmt::join(unknown, ", "));
  text += fmt::format(
      "identified  order {}{}, from {} first-order lags of {} inputs, stable; {} training loads; ridge {:.0e}, chosen "
      "on {}; {:.1f} s\n",
      order, options.order > 0 ? "" : " (chosen with the ridge)", made.model.lags().base.size(),
      made.model.lags().base.inputs(), machine_case.train.size(), made.model.ridge(), made.model.kept_out(),
      made.seconds);
  text += fmt::format("{}, matrices and order.svg in {}; {:.1f} s\n", reduction::system_file_name, options.out.string(),
                      time.seconds());
  print_summary(options, text, json.dump());
}

}  // namespace thermotwin::tools
