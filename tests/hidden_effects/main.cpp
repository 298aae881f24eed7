// SPDX-License-Identifier: GPL-3.0-or-later
// The bank as a program: see tools/hidden_effects.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "bank.h"
#include "core/error.h"
#include "core/file.h"
#include "core/folder_guard.h"
#include "core/quoted.h"
#include "core/thread_pool.h"
#include "diagnosis/record/diagnose_options.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"
#include "study/units/slurm.h"
#include "study/units/unit.h"
#include "study/units/unit_files.h"
#include "study/units/unit_work.h"

namespace {

using namespace thermotwin;

using Options = std::map<std::string, std::string>;

/// --name value pairs, and names of flags.
Options read_options(int argc, char** argv) {
  static const std::set<std::string> known = {"case",
                                              "model",
                                              "out",
                                              "seed",
                                              "draws",
                                              "singles",
                                              "clean",
                                              "pairs",
                                              "outside",
                                              "changes",
                                              "size",
                                              "loads",
                                              "cache",
                                              "kinds",
                                              "write",
                                              "unseen",
                                              "refine",
                                              "part",
                                              "threads",
                                              "mesh-order",
                                              "tolerance",
                                              "displacement-error",
                                              "temperature-error",
                                              "rows",
                                              "pads-finer",
                                              "radiation"};
  static const std::set<std::string> flags = {"slurm", "gather", "quiet"};
  Options options;
  bool complete = true;
  for (int i = 1; i < argc; ++i) {
    const std::string name = std::string_view(argv[i]).starts_with("--") ? argv[i] + 2 : argv[i];
    if (flags.count(name)) {
      options[name] = "";
    } else if (known.count(name)) {
      complete = complete && i + 1 < argc;
      if (complete) options[name] = argv[++i];
    } else {
      throw core::UsageError("unknown option " + std::string(argv[i]));
    }
  }
  if (!complete || !options.count("case") || !options.count("model") || !options.count("out")) {
    throw core::UsageError(
        "hidden_effects --case DIR --model model.rom.h5 --out DIR [--seed N --draws N --singles N --clean N --pairs N "
        "--outside N --changes N "
        "--size F --mesh-order 1|2 --refine F --tolerance K --loads a,b --kinds a,b --cache DIR --write DIR --unseen "
        "LOAD|none --rows own|sparse|pauses --pads-finer N --radiation stated|exact --displacement-error PERCENT "
        "--temperature-error PERCENT --slurm --part I/N --gather --threads N]");
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

/// The line that a unit has left.
std::string read_line(const std::filesystem::path& file) {
  const std::string text = core::read_file(file);
  return text.substr(0, text.find('\n'));
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

double number(const Options& options, const std::string& name, double otherwise) {
  if (!options.count(name)) return otherwise;
  const std::string& text = options.at(name);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= 0.0))
    throw core::UsageError("--" + name + " " + text + ": a number, not negative");
  return value;
}

std::uint64_t seed_of(const Options& options) { return static_cast<std::uint64_t>(number(options, "seed", 1000)); }

solver::Case read_case(const Options& options) {
  solver::Case machine_case = solver::read_case(options.at("case"));
  machine_case.machine.order = static_cast<int>(number(options, "mesh-order", machine_case.machine.order));
  if (machine_case.machine.order != 1 && machine_case.machine.order != 2)
    throw core::UsageError("--mesh-order " + options.at("mesh-order") + ": allowed are 1 and 2");
  return machine_case;
}

hidden::Rows rows_named(const std::string& name) {
  if (name == "own") return hidden::Rows::own;
  if (name == "sparse") return hidden::Rows::sparse;
  if (name == "pauses") return hidden::Rows::pauses;
  throw core::UsageError("--rows " + name + ": allowed are own, sparse and pauses");
}

hidden::SpecimenOptions specimen_options(const Options& options, std::uint64_t seed) {
  hidden::SpecimenOptions made;
  made.size_factor = number(options, "size", 0.7);
  made.refine = number(options, "refine", made.refine);
  made.tolerance_K = number(options, "tolerance", made.tolerance_K);
  made.seed = seed;
  if (options.count("cache")) made.cache = options.at("cache");
  if (options.count("rows")) made.rows = rows_named(options.at("rows"));
  made.finer_pads = static_cast<int>(number(options, "pads-finer", made.finer_pads));
  const std::string radiation = options.count("radiation") ? options.at("radiation") : "stated";
  if (radiation != "stated" && radiation != "exact")
    throw core::UsageError("--radiation " + radiation + ": allowed are stated and exact");
  made.exact_radiation = radiation == "exact";
  return made;
}

diagnosis::DiagnoseOptions diagnose_options(const Options& options) {
  diagnosis::DiagnoseOptions how;
  if (options.count("displacement-error") > 0)
    how.displacement_error_percent = number(options, "displacement-error", 0);
  if (options.count("temperature-error") > 0) how.temperature_error_percent = number(options, "temperature-error", 0);
  return how;
}

/// One record of the bank.
struct Set {
  hidden::Group group;
  diagnosis::Kind kind;
  std::string id;
  std::uint64_t serial;
};

class Bank {
public:
  explicit Bank(const Options& options)
      : options_(options),
        seed_(seed_of(options)),
        machine_case_(read_case(options)),
        model_(reduction::read_model(options.at("model"))),
        specimen_(machine_case_, specimen_options(options, seed_)),
        how_(diagnose_options(options)),
        expectations_(specimen_, model_, how_),
        loads_(options.count("loads") ? parts_of(options.at("loads")) : machine_case_.holdout),
        unseen_(options.count("unseen") ? options.at("unseen") : machine_case_.train.back()) {
    std::cerr << fmt::format("specimen of {} nodes\n", specimen_.nodes());
    add_sets();
  }

  const std::vector<Set>& sets() const { return sets_; }

  /// One a set.
  std::vector<study::Unit> units() const {
    std::string inputs = study::hash_of_case(machine_case_, std::string("hidden_effects 1 ") + THERMOTWIN_VERSION);
    inputs += " " + core::content_hash(core::read_file(options_.at("model"))) + " " + unseen_;
    for (const char* name :
         {"size", "refine", "tolerance", "displacement-error", "temperature-error", "rows", "pads-finer", "radiation"})
      inputs += " " + (options_.count(name) ? options_.at(name) : "-");
    for (const std::string& load : loads_) inputs += " " + study::words_of_load(machine_case_, load);
    if (unseen_ != "none") inputs += " " + study::words_of_load(machine_case_, unseen_);
    std::vector<study::Unit> units;
    for (const Set& set : sets_)
      units.push_back({core::content_hash(fmt::format("{} {} {} {}", inputs, seed_, set.serial, set.id)), set.id});
    return units;
  }

  /// Measures, diagnoses and judges the set.
  hidden::Line line_of(const Set& set) {
    const hidden::Draw draw = hidden::draw_set(specimen_, expectations_, set.group, set.kind,
                                               loads_[set.serial % loads_.size()], seed_ * 100000 + set.serial);
    const hidden::Record record = specimen_.record(draw);
    if (options_.count("write"))
      compensation::write_measurement(std::filesystem::path(options_.at("write")) / set.id, record.measurement);
    hidden::Draw other = draw;
    other.outside = hidden::Outside::none;
    hidden::Beside beside;
    beside.how = how_;
    beside.inputs = specimen_.followable(draw.load);
    beside.measured_poses = specimen_.measured_poses();
    std::optional<hidden::Record> unaffected;
    beside.diagonal_m = specimen_.diagonal();
    if (set.group == hidden::Group::outside || set.group == hidden::Group::change) {
      beside.affected = &record.noiseless;
      beside.unaffected = &unaffected.emplace(specimen_.record(other)).noiseless;
    }
    other.load = unseen_;
    if (set.group == hidden::Group::single && unseen_ != "none")
      beside.unseen = [&] { return specimen_.measure(other, hidden::Recording::exact); };
    const hidden::Line line =
        hidden::diagnose_set(set.id, set.group, draw, record.measurement, model_, beside, record.effective);
    std::cerr << fmt::format("{} {} {} {:.3g}: {} {} {} ({:.2f}), truth {:.2f}; 2lnB {:.0f}/{:.0f} {}\n", set.id,
                             line.kind, line.where, line.value, diagnosis::name_of(line.verdict), line.named_kind,
                             line.named_where, line.named_probability, line.probability, line.against_none,
                             line.against_rival, line.rival);
    return line;
  }

private:
  void add(hidden::Group group, diagnosis::Kind kind, const std::string& id) {
    sets_.push_back({group, kind, id, sets_.size() + 1});
  }

  void add_sets() {
    std::vector<diagnosis::Kind> kinds;
    if (!options_.count("kinds")) kinds = hidden::offered_kinds(specimen_, loads_.front(), model_);
    for (const std::string& name :
         options_.count("kinds") ? parts_of(options_.at("kinds")) : std::vector<std::string>()) {
      const std::optional<diagnosis::Kind> kind = diagnosis::find_kind(name);
      if (!kind) {
        throw core::UsageError(
            fmt::format("kind {}: the machine has no place for it under the load {}", name, loads_.front()));
      }
      kinds.push_back(*kind);
    }
    const auto count = [&](const char* name, int otherwise) {
      return static_cast<int>(number(options_, name, otherwise));
    };
    for (int i = 0; i < count("draws", 10); ++i)
      for (const diagnosis::Kind kind : kinds) add(hidden::Group::single, kind, fmt::format("{}_{}", name_of(kind), i));
    hidden::Random chance(seed_);
    for (int i = 0; !kinds.empty() && i < count("singles", 0); ++i)
      add(hidden::Group::single, kinds[chance.index(kinds.size())], fmt::format("single_{}", i));
    for (int i = 0; i < count("clean", 200); ++i)
      add(hidden::Group::clean, diagnosis::Kind::none, fmt::format("clean_{}", i));
    for (int i = 0; i < count("pairs", 40); ++i)
      add(hidden::Group::pair, diagnosis::Kind::none, fmt::format("pair_{}", i));
    for (int i = 0; i < count("outside", 40); ++i)
      add(hidden::Group::outside, diagnosis::Kind::none, fmt::format("outside_{}", i));
    for (int i = 0; i < count("changes", 0); ++i)
      add(hidden::Group::change, diagnosis::Kind::none, fmt::format("change_{}", i));
  }

  const Options& options_;
  const std::uint64_t seed_;
  const solver::Case machine_case_;
  const reduction::ReducedModel model_;
  const hidden::Specimen specimen_;
  const diagnosis::DiagnoseOptions how_;
  hidden::Expectations expectations_;
  const std::vector<std::string> loads_;
  const std::string unseen_;
  std::vector<Set> sets_;
};

constexpr const char* line_file = "line.tsv";

/// Scripts for an array job of one task a record, 200 at most, and a gathering job.
void write_scripts(const Options& options, const std::filesystem::path& folder, std::size_t units) {
  study::SlurmJob job;
  job.name = folder.filename().string();
  job.command = core::shell_word(std::filesystem::read_symlink("/proc/self/exe"));
  for (const auto& [name, value] : options) {
    if (name == "slurm") continue;
    const bool path = name == "case" || name == "model" || name == "out" || name == "cache" || name == "write";
    job.command += " --" + name + " " + core::shell_word(path ? std::filesystem::absolute(value).string() : value);
  }
  job.folder = std::filesystem::absolute(folder / "slurm");
  job.tasks = static_cast<int>(std::min<std::size_t>(units, 200));
  study::write_slurm(job);
  std::cout << fmt::format("{} units in {} tasks; submit them: bash '{}'\n", units, job.tasks,
                           (job.folder / "submit.sh").string());
}

/// Before a file is written: to gather, the units' folder has to be there; else it is that of this case.
/// @throws InputError
void open_units(const Options& options, const std::filesystem::path& folder) {
  if (options.count("gather") == 0) return study::claim_folder(folder, options.at("case"));
  if (std::filesystem::exists(folder / study::origin_note)) return;
  throw core::InputError(folder.string(), "no study was begun here, so there is nothing to gather",
                         "the --out of the units; is it mounted?");
}

/// Records of the part, each in its unit; one that fails is named, and the others go on.
int compute_part(Bank& bank, const std::filesystem::path& folder, const std::string& part) {
  const core::FolderGuard guard(folder, folder / study::origin_note);
  const study::Work work =
      study::compute(folder, bank.units(), study::part_of(part),
                     [&](std::size_t unit, const std::filesystem::path& own) -> study::UnitFiles {
                       try {
                         core::write_file(own / line_file, bank.line_of(bank.sets()[unit]).text() + "\n");
                       } catch (const core::Interrupted&) {
                         throw;
                       } catch (const std::exception& error) {
                         throw core::SolverError(error.what());
                       }
                       return {line_file};
                     });
  std::cout << fmt::format("part {}: {} units computed, {} done before, {} failed\n", part, work.computed, work.kept,
                           work.failed.size());
  return 0;
}

/// Of all threads.
double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

int run(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "--score") return score(argc - 2, argv + 2);
  const Options options = read_options(argc, argv);
  if (options.count("threads")) core::set_thread_count(static_cast<int>(number(options, "threads", 0)));
  const bool gather = options.count("gather") > 0;
  const std::filesystem::path out = options.at("out"), folder = out / fmt::format("bank_{}", seed_of(options));
  if (gather || options.count("slurm") > 0 || options.count("part") > 0) open_units(options, folder);
  Bank bank(options);
  if (options.count("slurm")) return write_scripts(options, folder, bank.sets().size()), 0;
  if (options.count("part")) return compute_part(bank, folder, options.at("part"));

  std::filesystem::create_directories(out);
  const std::filesystem::path file = out / fmt::format("bank_{}.tsv", seed_of(options));
  std::vector<hidden::Line> lines;
  std::set<std::string> done;
  for (hidden::Line& line : read_lines(file))
    if (done.insert(line.id).second) lines.push_back(std::move(line));
  std::ofstream log(file, std::ios::app);
  if (done.empty()) log << hidden::Line::header() << "\n";
  const std::vector<study::Unit> units = bank.units();
  const double began = processor_seconds();
  std::vector<std::string> failed;
  for (std::size_t s = 0; s < bank.sets().size(); ++s) {
    const Set& set = bank.sets()[s];
    if (done.count(set.id)) continue;
    try {
      if (gather && !study::is_done(folder, units[s]))
        throw core::InputError(study::failure_of(folder, units[s]).value_or("no result"));
      // As it is read again: a table is the same whether its lines were kept or not.
      lines.push_back(hidden::Line::parse(gather ? read_line(study::unit_folder(folder, units[s]) / line_file)
                                                 : bank.line_of(set).text()));
      log << lines.back().text() << std::endl;
    } catch (const std::exception& error) {
      std::cerr << set.id << ": " << error.what() << "\n";
      failed.push_back(set.id);
    }
  }
  std::cout << hidden::score(lines);
  if (const double computed = lines.size() - done.size(); !gather && computed > 0) {
    std::cout << fmt::format("\nprocessor time of a set, data included, mean of {:.0f}: {:.0f} s\n", computed,
                             (processor_seconds() - began) / computed);
  }
  if (failed.empty()) return 0;
  std::cout << fmt::format("\n{} sets are not in the table, since they {}: {}\n", failed.size(),
                           gather ? "failed or have no result" : "failed", fmt::join(failed, ", "));
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
