// SPDX-License-Identifier: GPL-3.0-or-later
// The bank as a program: see tools/hidden_effects.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "bank.h"
#include "core/error.h"
#include "diagnosis/record/diagnose_options.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"

namespace {

using namespace thermotwin;

/// --name value pairs.
std::map<std::string, std::string> read_options(int argc, char** argv) {
  static const std::set<std::string> known = {"case",
                                              "model",
                                              "out",
                                              "seed",
                                              "draws",
                                              "singles",
                                              "clean",
                                              "pairs",
                                              "outside",
                                              "size",
                                              "loads",
                                              "cache",
                                              "kinds",
                                              "write",
                                              "unseen",
                                              "refine",
                                              "mesh-order",
                                              "tolerance",
                                              "displacement-error",
                                              "temperature-error"};
  std::map<std::string, std::string> options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = std::string(argv[i]).substr(2);
    if (!known.count(name)) throw core::UsageError("unknown option " + std::string(argv[i]));
    options[name] = argv[i + 1];
  }
  if (argc % 2 == 0 || !options.count("case") || !options.count("model") || !options.count("out")) {
    throw core::UsageError(
        "hidden_effects --case DIR --model model.rom.h5 --out DIR [--seed N --draws N --singles N --clean N --pairs N "
        "--outside N "
        "--size F --mesh-order 1|2 --refine F --tolerance K --loads a,b --kinds a,b --cache DIR --write DIR --unseen "
        "LOAD|none --displacement-error PERCENT --temperature-error PERCENT]");
  }
  return options;
}

std::vector<std::string> parts_of(const std::string& list) {
  std::vector<std::string> parts;
  std::string part;
  for (const char c : list + ",") {
    if (c != ',')
      part += c;
    else if (!part.empty())
      parts.push_back(part), part.clear();
  }
  return parts;
}

/// Sets of an earlier run; none where there is no such file.
std::vector<hidden::Line> read_lines(const std::filesystem::path& file) {
  std::vector<hidden::Line> lines;
  std::ifstream in(file);
  for (std::string text; std::getline(in, text);) {
    if (!text.starts_with("id\t"))
      if (hidden::Line line = hidden::Line::parse(text); !line.id.empty()) lines.push_back(std::move(line));
  }
  return lines;
}

/// The table of all sets in these files.
int score(int count, char** files) {
  std::vector<hidden::Line> lines;
  for (int i = 0; i < count; ++i) {
    const std::vector<hidden::Line> more = read_lines(files[i]);
    if (more.empty())
      throw core::UsageError(std::string("--score ") + files[i] + ": holds no sets; give files bank_SEED.tsv");
    lines.insert(lines.end(), more.begin(), more.end());
  }
  if (lines.empty()) throw core::UsageError("--score: give files bank_SEED.tsv");
  std::cout << hidden::score(lines);
  return 0;
}

int run(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "--score") return score(argc - 2, argv + 2);
  const auto options = read_options(argc, argv);
  const auto number = [&](const std::string& name, double otherwise) {
    if (!options.count(name)) return otherwise;
    const std::string& text = options.at(name);
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value >= 0.0))
      throw core::UsageError("--" + name + " " + text + ": a number, not negative");
    return value;
  };
  const auto seed = static_cast<std::uint64_t>(number("seed", 1000));
  solver::Case machine_case = solver::read_case(options.at("case"));
  machine_case.machine.order = static_cast<int>(number("mesh-order", machine_case.machine.order));
  if (machine_case.machine.order != 1 && machine_case.machine.order != 2)
    throw core::UsageError("--mesh-order " + options.at("mesh-order") + ": allowed are 1 and 2");
  const reduction::ReducedModel model = reduction::read_model(options.at("model"));
  const std::filesystem::path out = options.at("out");
  std::filesystem::create_directories(out);
  const std::filesystem::path file = out / fmt::format("bank_{}.tsv", seed);

  std::vector<hidden::Line> lines;
  std::set<std::string> done;
  for (hidden::Line& line : read_lines(file))
    if (done.insert(line.id).second) lines.push_back(std::move(line));
  std::ofstream log(file, std::ios::app);
  if (done.empty()) log << hidden::Line::header() << "\n";

  hidden::SpecimenOptions made;
  made.size_factor = number("size", 0.7);
  made.refine = number("refine", made.refine);
  made.tolerance_K = number("tolerance", made.tolerance_K);
  made.seed = seed;
  if (options.count("cache")) made.cache = options.at("cache");
  const hidden::Specimen specimen(machine_case, made);
  std::cerr << fmt::format("specimen of {} nodes\n", specimen.nodes());
  diagnosis::DiagnoseOptions how;
  if (options.count("displacement-error") > 0) how.displacement_error_percent = number("displacement-error", 0);
  if (options.count("temperature-error") > 0) how.temperature_error_percent = number("temperature-error", 0);
  hidden::Expectations expectations(specimen, model, how);
  const std::vector<std::string> loads = options.count("loads") ? parts_of(options.at("loads")) : machine_case.holdout;
  const std::string unseen_load = options.count("unseen") ? options.at("unseen") : machine_case.train.back();
  std::uint64_t serial = 0;
  std::vector<std::string> failed;
  const auto one = [&](hidden::Group group, diagnosis::Kind kind, const std::string& id) {
    const std::uint64_t own = seed * 100000 + ++serial;
    if (done.count(id)) return;
    const hidden::Draw draw = hidden::draw_set(specimen, expectations, group, kind, loads[serial % loads.size()], own);
    try {
      const hidden::Record record = specimen.record(draw);
      if (options.count("write"))
        compensation::write_measurement(std::filesystem::path(options.at("write")) / id, record.measurement);
      hidden::Draw other = draw;
      other.outside = hidden::Outside::none;
      hidden::Beside beside;
      beside.how = how;
      beside.inputs = specimen.followable(draw.load);
      beside.measured_poses = specimen.measured_poses();
      std::optional<hidden::Record> unaffected;
      if (group == hidden::Group::outside) {
        beside.affected = &record.noiseless;
        beside.unaffected = &unaffected.emplace(specimen.record(other)).noiseless;
      }
      other.load = unseen_load;
      if (group == hidden::Group::single && unseen_load != "none")
        beside.unseen = [&] { return specimen.measure(other, hidden::Recording::exact); };
      lines.push_back(hidden::diagnose_set(id, group, draw, record.measurement, model, beside, record.effective));
    } catch (const std::exception& error) {
      std::cerr << id << ": " << error.what() << "\n";
      failed.push_back(id);
      return;
    }
    const hidden::Line& line = lines.back();
    log << line.text() << std::endl;
    std::cerr << fmt::format("{} {} {} {:.3g}: {} {} {} ({:.2f}), truth {:.2f}; 2lnB {:.0f}/{:.0f} {}\n", id, line.kind,
                             line.where, line.value, diagnosis::name_of(line.verdict), line.named_kind,
                             line.named_where, line.named_probability, line.probability, line.against_none,
                             line.against_rival, line.rival);
  };
  std::vector<diagnosis::Kind> kinds;
  if (!options.count("kinds")) kinds = hidden::offered_kinds(specimen, loads.front(), model);
  for (const std::string& name : options.count("kinds") ? parts_of(options.at("kinds")) : std::vector<std::string>()) {
    const std::optional<diagnosis::Kind> kind = diagnosis::find_kind(name);
    if (!kind) {
      throw core::UsageError(
          fmt::format("kind {}: the machine has no place for it under the load {}", name, loads.front()));
    }
    kinds.push_back(*kind);
  }
  for (int i = 0; i < static_cast<int>(number("draws", 10)); ++i)
    for (const diagnosis::Kind kind : kinds) one(hidden::Group::single, kind, fmt::format("{}_{}", name_of(kind), i));
  hidden::Random chance(seed);
  for (int i = 0; !kinds.empty() && i < static_cast<int>(number("singles", 0)); ++i)
    one(hidden::Group::single, kinds[chance.index(kinds.size())], fmt::format("single_{}", i));
  for (int i = 0; i < static_cast<int>(number("clean", 200)); ++i)
    one(hidden::Group::clean, diagnosis::Kind::none, fmt::format("clean_{}", i));
  for (int i = 0; i < static_cast<int>(number("pairs", 40)); ++i)
    one(hidden::Group::pair, diagnosis::Kind::none, fmt::format("pair_{}", i));
  for (int i = 0; i < static_cast<int>(number("outside", 40)); ++i)
    one(hidden::Group::outside, diagnosis::Kind::none, fmt::format("outside_{}", i));
  std::cout << hidden::score(lines);
  if (failed.empty()) return 0;
  std::cout << fmt::format("\n{} sets are not in the table, since they failed: {}\n", failed.size(),
                           fmt::join(failed, ", "));
  return 3;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const core::UsageError& error) {
    std::cerr << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 3;
  }
}
