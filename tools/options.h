// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the command line asks for, one struct a verb, and the verbs themselves. A verb prints its
// results to stdout (text, or one JSON object) and returns normally, or throws a core::Error.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/record/diagnose_options.h"

namespace thermotwin::tools {

struct CommonOptions {
  std::filesystem::path out = "out";
  int threads = 0;  ///< 0: all cores
  bool quiet = false, json = false;
};

struct RunOptions : CommonOptions {
  std::filesystem::path case_path;
  std::string size;    ///< empty: the case's own
  int mesh_order = 0;  ///< of the tetrahedra, 1 or 2; 0: the machine's own
  bool resume = false;
  std::string solver = "auto";
};
struct MeshOptions : CommonOptions {
  std::filesystem::path machine;
  std::string size = "coarse";
  int mesh_order = 0;
};
struct SimulateOptions : CommonOptions {
  std::filesystem::path case_path;
  std::string size, load, pose;
  int mesh_order = 0;
  double fields_every_s = 3600;
  std::vector<double> output_times;  ///< s; empty: every output_s of the load
  std::filesystem::path start_from, start_from_sensors;
  double start_time_s = -1;  ///< of start_from_sensors; negative: its first row
  bool resume = false;
  double checkpoint_every_s = 60;
  std::string solver = "auto";
  bool steady = false;  ///< the state that each phase tends to, instead of the run
};
struct CampaignOptions : CommonOptions {
  std::filesystem::path case_path;
  std::string size;
  int mesh_order = 0;
  std::vector<std::string> loads;
  bool resume = false;
  double checkpoint_every_s = 60;
  std::string solver = "auto";
  bool reduced = false;                    ///< by the reduced model
  bool exact = false;                      ///< without time error where coefficients stand
  bool bound = false;                      ///< error_bound.csv from bound.rom.h5 beside the model
  std::vector<std::string> poses;          ///< with reduced: instead of the workspace grid
  bool all_tilts = false;                  ///< with reduced: the grid at each position of the table's axes
  std::filesystem::path model, reference;  ///< of it; empty: out/model.rom.h5, reference.rom.h5 beside it
};
struct ReduceOptions : CommonOptions {
  std::filesystem::path case_path;
  std::string size;
  int mesh_order = 0;
  int order = 0;
  bool order_by_observer = false;
  bool resume = false;
  std::string solver = "auto";
  std::filesystem::path matrices;  ///< instead of a case: a folder of Matrix Market files
  std::string method;              ///< empty: combined for a case, balanced for matrices
  double tolerance = 1e-3;
  bool absolute = false, compare = false;
  bool bound = false;                    ///< bound.rom.h5 too ...
  std::vector<std::string> bound_poses;  ///< ... for these poses; empty: the middle of the workspace
  std::vector<std::string> films;        ///< "name=value[,value...]"
  bool identify = false;                 ///< from the tables of a campaign alone ...
  std::filesystem::path campaign;        ///< ... in this folder; empty: out/campaign
};
struct CompensateOptions : CommonOptions {
  CompensateOptions() { out = "-"; }  ///< a file here, "-" for stdout
  std::filesystem::path model;
  std::string in = "-";
  std::string in_name = "standard input";  ///< of rows that come there, for messages
  bool no_sensors = false;
  double step_s = 60;
  double start_C = 20;                   ///< of the machine, without sensors
  double largest_um = 0, rate_um_s = 0;  ///< of an offset; 0: by the model
  bool strict = false;
  double probe_std_um = 0.5;
  bool probed_compensated = false;
  std::filesystem::path learned, explain;  ///< written at the end; empty: not
  std::filesystem::path lines;             ///< a line for each axis, written at the end; empty: not
  double lines_every_s = 60;
  std::filesystem::path axis_errors;  ///< folder of tables, written at the end; empty: not
  std::filesystem::path state;        ///< read at the start, written each minute and at the end; empty: not
  int order = 0;                      ///< of the model; 0: its own
  bool json_lines = false;            ///< a line of JSON a row instead of CSV
  bool announce = false;              ///< with json_lines: a first line for `serve` (tools/serve/model_line.h)
};
struct OffsetsOptions : CommonOptions {
  OffsetsOptions() { out = "-"; }  ///< a file here, "-" for stdout
  std::filesystem::path in;
  std::string chain;
  std::vector<std::string> along_letter;  ///< axes whose body goes with the letter though it carries the workpiece
  bool orientation = false;
  std::vector<std::string> axes;
  double table_radius_mm = 300;
};
struct EvaluateOptions : CommonOptions {
  std::filesystem::path case_path, data, model, extended, fitted;
  std::vector<std::filesystem::path> also, train_data;
  double train_until_h = 0;  ///< 0: a day, of a short record half
  std::vector<std::string> train_programs, models, check;
  bool cross = false;
  std::vector<std::string> length_study;  ///< model and channel
};
struct DiagnoseOptions : CommonOptions {
  std::filesystem::path case_path, model;
  std::vector<std::filesystem::path> data;           ///< one or more records of one machine
  std::filesystem::path accept;                      ///< new folder for the case with the extended machine
  std::optional<double> displacement_error_percent;  ///< absent: of diagnosis::DiagnoseOptions
  std::optional<double> temperature_error_percent;
};
struct ValidateOptions : CommonOptions {
  std::filesystem::path case_path, model;
  std::vector<std::string> loads;
  int draws = 5;
  std::uint64_t first_seed = 1;
  double size_factor = 0.7;
  std::string perturb = "all";  ///< or "thermal", "none"
  bool power_off = false, failed_sensors = false, restart = false;
  double rate_um_s = 0;  ///< of the offsets after a restart; 0: by the model
  bool coolant_rise = false, no_noise = false;
  std::filesystem::path reference;  ///< truth instead of the full model
  int full_draws = 0;               ///< of the draws, so many on full models too
};
struct ExportOptions : CommonOptions {
  std::filesystem::path model;  ///< case or machine
  bool calculix = false, matrices = false, heat_only = false;
  std::string size, load, pose, body;
  int mesh_order = 0;
  double time_step_s = 0;   ///< 0: the load's own
  double steady_at_s = -1;  ///< negative: transient
};

void run(const RunOptions& options);
void mesh_machine(const MeshOptions& options);
void simulate(const SimulateOptions& options);
void simulate_steady(const SimulateOptions& options);
void campaign(const CampaignOptions& options);
void reduced_campaign(const CampaignOptions& options);
void reduce(const ReduceOptions& options);
void reduce_matrices(const ReduceOptions& options);
void reduce_from_campaign(const ReduceOptions& options);
void compensate(const CompensateOptions& options);
void offsets(const OffsetsOptions& options);
void evaluate(const EvaluateOptions& options);
void diagnose(const DiagnoseOptions& options);
void validate(const ValidateOptions& options);
void export_model(const ExportOptions& options);

/// Prints the summary of a verb: the text, or the JSON object where --json asks for it.
void print_summary(const CommonOptions& options, const std::string& text, const std::string& json);

}  // namespace thermotwin::tools
