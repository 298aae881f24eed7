// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/study/tests_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/html_page.h"
#include "core/plot.h"
#include "core/quoted.h"
#include "core/statistics.h"
#include "core/text.h"
#include "study/tests/stated_parameters.h"
#include "tools/page.h"
#include "tools/shell_command.h"

namespace thermotwin::tools {

using Eigen::Index;
using Eigen::VectorXd;
using study::TestPath;

namespace {

/// The same choice again.
std::string command_of(const StudyTestsOptions& options) {
  const StudyTestsOptions usual;
  return ShellCommand("thermotwin study tests " + core::shell_word(options.case_path))
      .text("--model", options.model)
      .text("--hours", fmt::format("{}", options.hours))
      .number("--leave", options.leave_um, usual.leave_um)
      .number("--block", options.block_min, usual.block_min)
      .number("--interval", options.interval_min, usual.interval_min)
      .texts("--program", options.programs)
      .flag("--no-programs", options.no_programs)
      .flag("--no-standard", options.no_standard)
      .flag("--chamber", options.chamber)
      .texts("--load", options.loads)
      .texts("--parameter", options.parameters)
      .number("--every", options.every_min, usual.every_min)
      .number("--bias", options.bias_K, usual.bias_K)
      .number("--probe-every", options.probe_every_min, usual.probe_every_min)
      .number("--probe-std", options.probe_um, usual.probe_um)
      .text("--probe-pose", options.probe_pose)
      .flag("--no-probe", options.no_probe)
      .number("--exchanges", options.exchanges, usual.exchanges)
      .number("--orders", options.orders, usual.orders)
      .number("--seed", options.seed, usual.seed)
      .text("--out", options.out)
      .words();
}

constexpr std::size_t told_at_most = 3;
constexpr double told_share = 0.1;        ///< of the block's largest
constexpr double predicted_within = 2.0;  ///< times as much as predicted, above which the difference is explained

VectorXd curve_hours(const TestPath& path) {
  VectorXd hours(std::ssize(path.hours) + 1);
  hours[0] = 0.0;
  for (Index i = 1; i < hours.size(); ++i) hours[i] = path.hours[i - 1];
  return hours;
}

VectorXd curve_um(const TestPath& path, double prior_um2) {
  VectorXd left(std::ssize(path.variance_um2) + 1);
  left[0] = std::sqrt(prior_um2);
  for (Index i = 1; i < left.size(); ++i) left[i] = std::sqrt(path.variance_um2[i - 1]);
  return left;
}

std::string hours_svg(const TestStudy& study) {
  core::Axis across{"hours"}, up{"left of the TCP error, um", true};
  across.include(0.0);
  const auto include = [&](const TestPath& path) {
    across.include(curve_hours(path));
    up.include(curve_um(path, study.prior_um2));
  };
  include(study.chosen);
  include(study.iso);
  for (const TestPath& path : study.random) include(path);
  across.close();
  up.close(0.05);
  core::Plot plot(820, 340, "hours of the test against the standard deviation of the TCP error that remains");
  core::Panel panel(plot, {64, 34, 730, 250}, across, up);
  panel.y_axis();
  panel.x_axis();
  const auto draw = [&](const TestPath& path, core::Ink ink) {
    panel.line(curve_hours(path), curve_um(path, study.prior_um2), ink);
  };
  for (const TestPath& path : study.random) draw(path, core::Ink::grey);
  draw(study.iso, core::Ink::orange);
  draw(study.best(), core::Ink::black);
  draw(study.chosen, core::Ink::blue);
  panel.dots(curve_hours(study.chosen), curve_um(study.chosen, study.prior_um2), core::Ink::blue);
  double x = plot.key(64, 18, "chosen", core::Ink::blue);
  x = plot.key(x, 18, fmt::format("best of {} random orders", study.random.size()), core::Ink::black);
  x = plot.key(x, 18, "random orders", core::Ink::grey);
  plot.key(x, 18, "order of ISO 230-3", core::Ink::orange);
  return core::html_wide(900, plot.inset());
}

std::vector<std::vector<std::string>> machines_table(const TestStudy& study) {
  std::vector<std::vector<std::string>> rows{{"machine", "machine.toml um", "chosen test um", "random order um"}};
  for (std::size_t i = 0; i < study.confirmed.size(); ++i) {
    const study::ConfirmedMachine& one = study.confirmed[i];
    rows.push_back({std::to_string(i + 1), fmt::format("{:.2f}", one.nominal_um),
                    fmt::format("{:.2f}", one.tests_um[0]), fmt::format("{:.2f}", one.tests_um[1])});
  }
  return rows;
}

double median_of(const TestStudy& study, double (*value)(const study::ConfirmedMachine&)) {
  std::vector<double> values;
  for (const study::ConfirmedMachine& one : study.confirmed) values.push_back(value(one));
  return core::median(values);
}

}  // namespace

std::string told_by(const TestStudy& study, std::size_t block) {
  const VectorXd& shares = study.chosen.shares[block];
  std::vector<Index> order(shares.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return shares[a] > shares[b]; });
  std::vector<std::string> names;
  for (const Index p : order)
    if (names.size() < told_at_most && shares[p] > 0 && shares[p] >= told_share * shares[order.front()])
      names.push_back(study::key_of(study.parameters[p]));
  return core::join(names);
}

std::vector<std::vector<std::string>> test_table(const TestStudy& study) {
  std::vector<std::vector<std::string>> rows{{"until h", "block", "left um", "tells"}};
  rows.push_back({"0", "-", fmt::format("{:.3f}", std::sqrt(study.prior_um2)), "-"});
  for (std::size_t i = 0; i < study.chosen.blocks.size(); ++i) {
    rows.push_back({fmt::format("{:.4g}", study.chosen.hours[i]), study.chosen.blocks[i]->name,
                    fmt::format("{:.3f}", std::sqrt(study.chosen.variance_um2[i])), told_by(study, i)});
  }
  return rows;
}

std::vector<std::vector<std::string>> parameter_table(const TestStudy& study) {
  // With --leave the others run for other times, so that their deviations are no comparison.
  const bool alone = study.leave_um > 0;
  std::vector<std::vector<std::string>> rows{
      {"parameter", "prior %", "chosen %", "random %", "ISO 230-3 %", "gain um2"}};
  VectorXd gain = VectorXd::Zero(std::ssize(study.parameters));
  for (const VectorXd& shares : study.chosen.shares) gain += shares;
  std::vector<Index> order(gain.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return gain[a] > gain[b]; });
  for (const Index p : order) {
    const double prior = 100.0 * study.parameters[p].std;
    const auto after = [&](const TestPath& path) {
      return fmt::format("{:.2f}", prior * std::sqrt(std::max(0.0, path.covariance(p, p))));
    };
    rows.push_back({study::key_of(study.parameters[p]), fmt::format("{:.2f}", prior), after(study.chosen),
                    alone ? "" : after(study.best()), alone ? "" : after(study.iso), fmt::format("{:.4g}", gain[p])});
  }
  return rows;
}

namespace {

/// Of a test that may leave so much: its hours beside those of the others.
std::string hours_sentence(const TestStudy& study) {
  const auto until = [&](const TestPath& path) {
    const std::optional<double> hours = study.hours_until(path);
    return hours ? fmt::format("{:.4g} h", *hours) : fmt::format("more than {:.4g} h", path.hours.back());
  };
  std::optional<double> least;
  for (const TestPath& path : study.random)
    if (const std::optional<double> hours = study.hours_until(path); hours && (!least || *hours < *least))
      least = hours;
  const std::string others = fmt::format(
      "{} needs {} for it, the order of ISO 230-3 {}.",
      study.random.size() == 1 ? "A random order" : fmt::format("The best of {} random orders", study.random.size()),
      least ? fmt::format("{:.4g} h", *least) : fmt::format("more than {:.4g} h", study.best().hours.back()),
      until(study.iso));
  if (!study.hours_until(study.chosen)) {
    return fmt::format(
        "{:.4g} h of this test leave {:.3f} um of the TCP error ({:.3f} um before), more than the {:g} um of --leave. "
        "More hours, or more and better sensors, are needed. {}",
        study.chosen.hours.back(), std::sqrt(study.chosen.end_um2()), std::sqrt(study.prior_um2), study.leave_um,
        others);
  }
  return fmt::format(
      "{:.4g} h of this test leave {:.3f} um of the TCP error ({:.3f} um before); {:g} um may be left. {}",
      study.chosen.hours.back(), std::sqrt(study.chosen.end_um2()), std::sqrt(study.prior_um2), study.leave_um, others);
}

}  // namespace

std::string test_sentence(const TestStudy& study) {
  if (study.leave_um > 0) return hours_sentence(study);
  const std::size_t count = study.random.size();
  const auto against = [&](const TestPath& other) {
    const double gain = study.gain_percent(other);
    if (gain < 1e-6) return std::string("equal to");
    return gain < 0.5 ? std::string("less than 1 % below") : fmt::format("{:.0f} % below", gain);
  };
  std::string words = fmt::format(
      "{:.4g} h of this test leave {:.3f} um of the TCP error ({:.3f} um before). {} leaves {:.3f} um, the order of "
      "ISO 230-3 {:.3f} um. The variance is {} that of the former and {} that of the latter.",
      study.chosen.hours.back(), std::sqrt(study.chosen.end_um2()), std::sqrt(study.prior_um2),
      count == 1 ? "A random order" : fmt::format("The best of {} random orders", count),
      std::sqrt(study.best().end_um2()), std::sqrt(study.iso.end_um2()), against(study.best()), against(study.iso));
  if (study.start != "greedy") {
    words += fmt::format(" The greedy order left {:.3f} um; the test starts from the {} instead.",
                         std::sqrt(study.greedy_um2),
                         study.start == "iso_230_3" ? "order of ISO 230-3" : "best random order");
  }
  return words;
}

namespace {

/// Of the machines' errors, um.
std::string verdict_of(double nominal, double chosen, double random, double predicted) {
  std::string words = chosen < nominal ? "The test makes the prediction better" : "The test does not help";
  words += chosen <= random ? " and is no worse than the random order." : ", and the random order is better.";
  if (chosen > predicted_within * predicted) {
    words += fmt::format(
        " It leaves {:.1f} times as much as predicted: the prediction counts the values alone, not the errors of mesh "
        "and model, which these machines have too.",
        chosen / predicted);
  }
  return words;
}

}  // namespace

std::string confirmed_sentence(const TestStudy& study) {
  if (study.confirmed.empty()) return "";
  const double nominal = median_of(study, [](const study::ConfirmedMachine&one) { return one.nominal_um; }),
               chosen = median_of(study, [](const study::ConfirmedMachine&one) { return one.tests_um[0]; }),
               random = median_of(study, [](const study::ConfirmedMachine&one) { return one.tests_um[1]; }),
               predicted = std::sqrt(study.chosen.end_um2());
  return fmt::format(
      "On {} measured virtually the prediction has an error of {:.2f} um with the values of machine.toml, of {:.2f} um "
      "with those from the chosen test, of {:.2f} um with those from a random order (medians of the RMS). Predicted "
      "were {:.2f}, {:.2f} and {:.2f} um. {}",
      study.confirmed.size() == 1 ? "one machine" : fmt::format("{} machines", study.confirmed.size()), nominal, chosen,
      random, std::sqrt(study.prior_um2), predicted, std::sqrt(study.random.front().end_um2()),
      verdict_of(nominal, chosen, random, predicted));
}

std::string tests_page(const StudyTestsOptions& options, const TestStudy& study) {
  const std::string title = "Test of " + study.machine;
  std::vector<std::string> sentences{core::html_sentence(test_sentence(study))};
  if (const std::string confirmed = confirmed_sentence(study); !confirmed.empty())
    sentences.push_back(core::html_sentence(confirmed));
  const bool better = study.leave_um > 0 ? study.hours_until(study.chosen).has_value()
                                         : study.gain_percent(study.best()) > 0 && study.gain_percent(study.iso) > 0;
  std::string body =
      core::html_title(title, "load programs that leave the prediction of the TCP error the least variance") +
      core::html_finding(better ? core::Tone::good : core::Tone::plain, "test", sentences) +
      core::html_section("Hours", "standard deviation over poses and times, by the uncertain values of machine.toml",
                         hours_svg(study)) +
      core::html_section("Blocks", "in their order, and the values that each tells most",
                         core::html_table(test_table(study))) +
      core::html_section("Values", "standard deviations before and after a test",
                         core::html_table(parameter_table(study)));
  if (!study.confirmed.empty()) {
    body += core::html_section("Machines measured virtually", "RMS of the prediction's error at the check points",
                               core::html_table(machines_table(study)));
  }
  const std::string folder = core::shell_word(options.out / "study/tests");
  std::vector<core::NextStep> next{
      {"Run the test on the full model:",
       fmt::format("cp {1}/load.toml {0}/loads/test.toml && thermotwin simulate {0} --load test --out {2}",
                   core::shell_word(options.case_path), folder, core::shell_word(options.out))}};
  if (!options.no_probe) {
    next.push_back({"Measure it virtually, with the probe:",
                    fmt::format("thermotwin measure simulate {} --case {} --out {}", folder,
                                core::shell_word(options.case_path), core::shell_word(options.out / "record"))});
  }
  next.push_back({"Confirm the choice on machines measured virtually:", command_of(options) + " --confirm 3"});
  return core::html_document(title, body + core::html_next_steps(next));
}

}  // namespace thermotwin::tools
