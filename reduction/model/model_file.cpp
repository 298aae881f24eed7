// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/model_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/error.h"
#include "core/file.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "reduction/linear/hdf5_store.h"
#include "reduction/model/output_grid.h"
#include "reduction/model/parts_file.h"
#include "solver/operation/layout.h"

namespace thermotwin::reduction {
namespace {

using core::InputError;
namespace fs = std::filesystem;

constexpr char format_name[] = "thermotwin reduced model";

template <class Item>
Eigen::Index size_of(const std::vector<Item>& items) {
  return std::ssize(items);
}

std::string axis_units(const mesh::Machine& machine) {
  std::string units;
  for (const mesh::Axis& axis : machine.axes) {
    if (!units.empty()) units += ' ';
    units += axis.id + (axis.kind == mesh::AxisKind::linear ? "_m" : "_rad");
  }
  return units;
}

void write_layout(StoreWriter& writer, const solver::Layout& layout) {
  IntRows grids(size_of(layout.grids), 3), terms(size_of(layout.terms), 3), inputs(size_of(layout.inputs), 5);
  std::vector<double> positions;
  for (Eigen::Index i = 0; i < grids.rows(); ++i) {
    const solver::JointGrid& grid = layout.grids[i];
    grids.row(i) << grid.axis, grid.periodic ? 1 : 0, std::ssize(grid.positions);
    positions.insert(positions.end(), grid.positions.begin(), grid.positions.end());
  }
  for (Eigen::Index i = 0; i < terms.rows(); ++i) {
    const solver::Term& term = layout.terms[i];
    terms.row(i) << static_cast<int>(term.kind), term.item, term.part;
  }
  for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
    const solver::Input& input = layout.inputs[i];
    inputs.row(i) << static_cast<int>(input.kind), input.term, input.item, input.place, input.node;
  }
  writer.group("/layout");
  writer.integers("/layout/grids", grids);
  writer.describe("/layout/grids", "axis periodic nodes", "index, 0 or 1, count; one row a joint");
  writer.vector("/layout/positions", Eigen::Map<const Eigen::VectorXd>(positions.data(), std::ssize(positions)));
  writer.describe("/layout/positions", "nodes of all grids in their order", "m or rad");
  writer.integers("/layout/terms", terms);
  writer.describe("/layout/terms", "kind item part",
                  "kind: 0 film, 1 contact, 2 coolant wall, 3 coolant flow, 4 volume exchange, 5 volume given");
  writer.integers("/layout/inputs", inputs);
  writer.describe("/layout/inputs", "kind term item place node",
                  "kind: 0 film ambient, 1 contact ambient, 2 source, 3 coolant inlet, 4 film gradient, 5 volume "
                  "ambient, 6 volume given");
}

Eigen::MatrixXd pose_rows(const std::vector<mesh::Pose>& poses, Eigen::Index axes) {
  Eigen::MatrixXd rows(std::ssize(poses), axes);
  for (std::size_t i = 0; i < poses.size(); ++i) rows.row(i) = poses[i].transpose();
  return rows;
}

void write_all(StoreWriter& writer, const ReducedModel& model) {
  const ReducedSystem& system = model.system;
  const Eigen::Index r = system.order();
  const Eigen::Index axes = size_of(model.machine.axes);
  writer.text_attribute("/", "format", format_name);
  writer.integer_attribute("/", "version", model_file_version);
  writer.integer_attribute("/", "order", r);
  writer.integer_attribute("/", "full_size", model.full_size);
  writer.text_attribute("/", "size", model.size);
  writer.text("/machine.toml", model.machine.text);
  write_layout(writer, system.layout);

  writer.group("/system");
  writer.matrix("/system/capacity", system.capacity);
  writer.describe("/system/capacity", "state", "J/K");
  writer.matrix("/system/conduction", system.conduction);
  writer.describe("/system/conduction", "state", "W/K");
  writer.stack("/system/terms", system.terms, r, r);
  writer.describe("/system/terms", "(term, state, state)", "W/K for a coefficient of 1 in its unit");
  writer.matrix("/system/inputs", system.inputs);
  writer.describe("/system/inputs", "input", "W for an input of 1");
  writer.matrix("/system/sensors", system.sensors);
  writer.describe("/system/sensors", "state", "K; one row a sensor, then what coefficients and chillers follow");
  writer.vector("/system/one_kelvin", system.one_kelvin);
  writer.describe("/system/one_kelvin", "state of 1 K everywhere", "1");

  const ReducedOutputs& outputs = model.outputs;
  writer.group("/outputs");
  writer.matrix("/outputs/tool_poses", pose_rows(outputs.tool_poses, axes));
  writer.describe("/outputs/tool_poses", axis_units(model.machine), "m, rad");
  writer.stack("/outputs/tool", outputs.tool, 6, r);
  writer.describe("/outputs/tool", "(pose, dx dy dz ra rb rc, state)", "m, rad");
  writer.matrix("/outputs/table_poses", pose_rows(outputs.table_poses, axes));
  writer.describe("/outputs/table_poses", axis_units(model.machine), "m, rad");
  writer.stack("/outputs/table_axis", outputs.table_axis, 6, r);
  writer.describe("/outputs/table_axis", "(pose, dx dy dz ra rb rc, state)", "m, rad");
  writer.stack("/outputs/table_own", outputs.table_own, 7, r);
  writer.describe("/outputs/table_own", "(pose, dx dy dz ra rb rc R0T, state)", "m, rad");

  Eigen::MatrixXd errors(std::ssize(model.errors), 5);
  std::string loads;
  for (std::size_t i = 0; i < model.errors.size(); ++i) {
    const ReductionErrors& error = model.errors[i];
    errors.row(i) << error.peak_um, error.max_um, error.rms_um, error.estimate_max_um, error.effectivity;
    loads += error.load + "\n";
  }
  writer.group("/errors");
  writer.matrix("/errors/values", errors);
  writer.describe("/errors/values", "peak max rms estimate effectivity", "um, um, um, um, 1");
  writer.text("/errors/loads", loads);

  Eigen::MatrixXd trained(model.trained.low.size(), 2);
  if (trained.rows() > 0) trained << model.trained.low, model.trained.high;
  writer.group("/trained");
  writer.matrix("/trained/coefficients", trained);
  writer.describe("/trained/coefficients", "low high", "unit of the term's coefficient; one row a term");
  if (model.sensor_air) {
    writer.group("/sensor_air");
    writer.integers("/sensor_air/film", IntRows(model.sensor_air->film));
    writer.describe("/sensor_air/film", "sensors", "index of the film whose ambient is beside it; -1: none");
    writer.matrix("/sensor_air/volumes", model.sensor_air->volumes);
    writer.describe("/sensor_air/volumes", "state", "K; one row a volume");
  }
  if (model.mesh_error) {
    writer.group("/mesh_error");
    writer.vector("/mesh_error/sensors", model.mesh_error->sensors);
    writer.describe("/mesh_error/sensors", "sensors", "share of the change of each");
    writer.vector("/mesh_error/tcp", model.mesh_error->tcp);
    writer.describe("/mesh_error/tcp", "dx dy dz ra rb rc", "share of the motion in all three directions");
    writer.text("/mesh_error/second", model.mesh_error->second);
  }
  if (model.parts) write_parts(writer, *model.parts, model);
  if (!model.patches.items.empty()) write_patches(writer, model.patches, model.machine);
}

/// Terms and inputs follow from the machine and the grids; the file's own lists must agree.
solver::Layout read_layout(const StoreReader& reader, const mesh::Machine& machine) {
  const IntRows grids = reader.integers("/layout/grids", 3);
  const Eigen::VectorXd positions = reader.vector("/layout/positions", StoreReader::any);
  if (grids.rows() != std::ssize(machine.joints)) {
    reader.fail(fmt::format("/layout/grids with {} rows", grids.rows()),
                fmt::format("one per joint of its machine.toml: {}", machine.joints.size()));
  }
  std::vector<solver::JointGrid> list;
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < grids.rows(); ++i) {
    const int axis = grids(i, 0), nodes = grids(i, 2);
    if (axis < -1 || axis >= std::ssize(machine.axes) || nodes < 1 || next + nodes > positions.size()) {
      reader.fail(fmt::format("/layout/grids row {} with axis {} and {} nodes", i, axis, nodes),
                  "an axis of the machine and nodes that /layout/positions holds");
    }
    solver::JointGrid grid{axis, grids(i, 1) != 0, {}};
    grid.positions.assign(positions.data() + next, positions.data() + next + nodes);
    next += nodes;
    list.push_back(std::move(grid));
  }
  solver::Layout layout = solver::make_layout(machine, std::move(list));
  const IntRows terms = reader.integers("/layout/terms", 3), inputs = reader.integers("/layout/inputs", 5);
  bool same = terms.rows() == std::ssize(layout.terms) && inputs.rows() == std::ssize(layout.inputs);
  for (Eigen::Index i = 0; same && i < terms.rows(); ++i) {
    const solver::Term& term = layout.terms[i];
    same = terms(i, 0) == static_cast<int>(term.kind) && terms(i, 1) == term.item && terms(i, 2) == term.part;
  }
  for (Eigen::Index i = 0; same && i < inputs.rows(); ++i) {
    const solver::Input& input = layout.inputs[i];
    same = inputs(i, 0) == static_cast<int>(input.kind) && inputs(i, 1) == input.term && inputs(i, 2) == input.item &&
           inputs(i, 3) == input.place && inputs(i, 4) == input.node;
  }
  if (!same) {
    reader.fail("/layout/terms or /layout/inputs other than its machine.toml gives",
                "a file of this version (write it anew: thermotwin reduce)");
  }
  return layout;
}

std::vector<mesh::Pose> read_poses(const StoreReader& reader, const std::string& path, Eigen::Index axes) {
  const Eigen::MatrixXd rows = reader.matrix(path, StoreReader::any, axes);
  std::vector<mesh::Pose> poses;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) poses.push_back(rows.row(i).transpose());
  return poses;
}

void check_header(const StoreReader& reader) {
  if (!reader.has_attribute("format") || !reader.has_attribute("version") ||
      reader.text_attribute("format") != format_name) {
    reader.fail("an HDF5 file, but not a reduced model", "a model.rom.h5 that `thermotwin reduce` wrote");
  }
  const std::int64_t version = reader.integer_attribute("version");
  if (version != model_file_version) {
    reader.fail(fmt::format("version {} of the model file", version),
                fmt::format("version {} (write it anew: thermotwin reduce)", model_file_version));
  }
}

ReducedModel read_all(const StoreReader& reader, const fs::path& path) {
  check_header(reader);
  ReducedModel model;
  model.machine = mesh::parse_machine(reader.text("/machine.toml"), path / "machine.toml");
  model.size = reader.text_attribute("size");
  model.full_size = reader.integer_attribute("full_size");
  const std::int64_t order = reader.integer_attribute("order");
  if (order < 1 || order > 10000) reader.fail(fmt::format("order {}", order), "1 .. 10000");
  const Eigen::Index r = order;

  ReducedSystem& system = model.system;
  system.layout = read_layout(reader, model.machine);
  system.capacity = reader.matrix("/system/capacity", r, r);
  system.conduction = reader.matrix("/system/conduction", r, r);
  system.terms = reader.stack("/system/terms", size_of(system.layout.terms), r, r);
  system.inputs = reader.matrix("/system/inputs", r, size_of(system.layout.inputs));
  system.sensors =
      reader.matrix("/system/sensors", size_of(model.machine.sensors) + size_of(system.layout.observed), r);
  system.one_kelvin = reader.vector("/system/one_kelvin", r);

  ReducedOutputs& outputs = model.outputs;
  const Eigen::Index axes = size_of(model.machine.axes);
  outputs.tool_poses = read_poses(reader, "/outputs/tool_poses", axes);
  outputs.table_poses = read_poses(reader, "/outputs/table_poses", axes);
  const OutputGrid grid(model.machine);
  const Eigen::Index tables = grid.table_count();
  if (!OutputGrid::can_store(model.machine, outputs.tool_poses.size()) || size_of(outputs.table_poses) != tables) {
    reader.fail(fmt::format("{} tool poses and {} table poses", outputs.tool_poses.size(), outputs.table_poses.size()),
                fmt::format("{} (or {} without lines) and {}, as its workspace says (an earlier build had others: "
                            "write it anew, thermotwin reduce)",
                            grid.tool_count(), grid.grid_count(), tables));
  }
  outputs.tool = reader.stack("/outputs/tool", size_of(outputs.tool_poses), 6, r);
  outputs.table_axis = reader.stack("/outputs/table_axis", tables, 6, r);
  outputs.table_own = reader.stack("/outputs/table_own", tables, 7, r);

  const Eigen::MatrixXd errors = reader.matrix("/errors/values", StoreReader::any, 5);
  const std::string loads = reader.text("/errors/loads");
  std::size_t from = 0;
  for (Eigen::Index i = 0; i < errors.rows(); ++i) {
    const std::size_t end = loads.find('\n', from);
    if (end == std::string::npos) reader.fail("/errors/loads with too few names", fmt::format("{}", errors.rows()));
    model.errors.push_back(
        {loads.substr(from, end - from), errors(i, 0), errors(i, 1), errors(i, 2), errors(i, 3), errors(i, 4)});
    from = end + 1;
  }
  const Eigen::MatrixXd trained = reader.matrix("/trained/coefficients", StoreReader::any, 2);
  if (trained.rows() != 0 && trained.rows() != size_of(system.layout.terms)) {
    reader.fail(fmt::format("/trained/coefficients with {} rows", trained.rows()),
                fmt::format("none or one a term: {}", system.layout.terms.size()));
  }
  model.trained = {trained.col(0), trained.col(1)};
  if (reader.has("/sensor_air")) {
    SensorAir air;
    const IntRows film = reader.integers("/sensor_air/film", 1);
    if (film.rows() != size_of(model.machine.sensors) ||
        (film.size() > 0 && (film.minCoeff() < -1 || film.maxCoeff() >= size_of(model.machine.films))))
      reader.fail("/sensor_air/film that does not fit", "a film of the machine, or -1, for each sensor");
    air.film = film.col(0);
    air.volumes = reader.matrix("/sensor_air/volumes", size_of(model.machine.volumes), r);
    model.sensor_air = std::move(air);
  }
  if (reader.has("/mesh_error")) {
    MeshError error;
    error.sensors = reader.vector("/mesh_error/sensors", size_of(model.machine.sensors));
    error.tcp = reader.vector("/mesh_error/tcp", 6);
    error.second = reader.text("/mesh_error/second");
    const auto share = [](double value) { return value >= 0.0 && value <= 1.0; };
    if (!std::all_of(error.sensors.begin(), error.sensors.end(), share) ||
        !std::all_of(error.tcp.begin(), error.tcp.end(), share))
      reader.fail("/mesh_error with a share outside 0 to 1", "shares of a change");
    model.mesh_error = std::move(error);
  }
  model.parts = read_parts(reader, model);
  model.patches = read_patches(reader, model);
  return model;
}

}  // namespace

void write_model(const fs::path& path, const ReducedModel& model) {
  StoreWriter writer(path.string());
  write_all(writer, model);
  core::write_file(path, writer.finish());
}

ReducedModel read_model(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    const bool beside = fs::is_regular_file(path / "model.rom.h5", error);
    throw InputError(path.string(), "a folder, where a reduced model is read",
                     beside ? (path / "model.rom.h5").string() : "a model.rom.h5 that `thermotwin reduce` wrote");
  }
  if (!fs::is_regular_file(path, error)) {
    throw InputError(path.string(), "no such file", "a model.rom.h5 that `thermotwin reduce` wrote");
  }
  return read_all(StoreReader(path), path);
}

}  // namespace thermotwin::reduction
