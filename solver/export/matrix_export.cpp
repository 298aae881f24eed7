// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/matrix_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/character.h"
#include "core/error.h"
#include "core/file.h"
#include "core/matrix_market.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/full_model.h"
#include "solver/elastic/tcp.h"
#include "solver/operation/layout.h"

namespace thermotwin::solver {

namespace {

using Eigen::Index;
namespace fs = std::filesystem;

/// An id as part of a file's name.
std::string plain(const std::string& id) {
  std::string text = id;
  for (char& c : text)
    if (!core::is_letter_or_digit(c) && c != '_' && c != '-') c = '_';
  return text;
}

template <class Items>
std::string id_of(const Items& items, int index) {
  return plain(items[index].id);
}

std::string term_name(const mesh::Machine& machine, const Term& term) {
  switch (term.kind) {
    case TermKind::film: return "film." + id_of(machine.films, term.item);
    case TermKind::contact: return fmt::format("contact.{}.{}", id_of(machine.joints, term.item), term.part + 1);
    case TermKind::coolant_wall:
      return fmt::format("wall.{}.{}", id_of(machine.coolants, term.item),
                         id_of(machine.coolants[term.item].segments, term.part));
    case TermKind::coolant_flow: return "flow." + id_of(machine.coolants, term.item);
    case TermKind::volume_exchange:
      return fmt::format("exchange.{}.{}", id_of(machine.volumes, term.item), term.part + 1);
    case TermKind::volume_given: return "given." + id_of(machine.volumes, term.item);
  }
  return "term";
}

std::string term_unit(const Term& term) {
  switch (term.kind) {
    case TermKind::coolant_flow: return "kg/s";
    case TermKind::volume_exchange:
    case TermKind::volume_given: return "W/K";
    default: return "W/(m^2 K)";
  }
}

std::string input_name(const mesh::Machine& machine, const Layout& layout, const Input& input) {
  if (input.kind == InputKind::source)
    return fmt::format("source.{}.{}.{}", id_of(machine.sources, input.item), input.place + 1, input.node + 1);
  const std::string of = term_name(machine, layout.terms[input.term]);
  switch (input.kind) {
    case InputKind::coolant_inlet: return of + ".inlet";
    case InputKind::film_gradient: return of + ".gradient";
    case InputKind::volume_given: return of + ".temperature";
    default: return of + ".ambient";
  }
}

std::string input_unit(const Layout& layout, const Input& input) {
  // A parameter times a temperature, or times a gradient.
  if (input.kind == InputKind::source) return "W";
  if (input.kind == InputKind::film_gradient) return "W/m^3";
  const std::string of = term_unit(layout.terms[input.term]);
  return of == "kg/s" ? "kg K/s" : of == "W/K" ? "W" : "W/m^2";
}

void make_unique(std::vector<NamedValue>& all) {
  std::set<std::string> taken;
  for (NamedValue& one : all) {
    const std::string name = one.name;
    for (int number = 2; !taken.insert(one.name).second; ++number) one.name = fmt::format("{}_{}", name, number);
  }
}

/// The channels of a machine that stands at a pose.
Eigen::VectorXd standing_row(const OperatingModel& operating, const mesh::Machine& machine, const mesh::Pose& pose) {
  Eigen::VectorXd row = operating.channels().defaults();
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const bool linear = machine.axes[i].kind == mesh::AxisKind::linear;
    const int channel =
        operating.channels().index("axis." + machine.axes[i].id + (linear ? ".position_mm" : ".position_deg"));
    if (channel >= 0) row[channel] = pose[i] / (linear ? core::units::mm : core::units::deg);
  }
  return row;
}

std::string table(const char* name, const std::vector<NamedValue>& all, bool with_value) {
  std::string text;
  for (const NamedValue& one : all) {
    text += fmt::format("\n[[{}]]\nname = \"{}\"\nunit = \"{}\"\n", name, one.name, one.unit);
    if (with_value) {
      text += fmt::format("value = {}{}\n", one.value,
                          one.value == std::floor(one.value) && std::abs(one.value) < 1e15 ? ".0" : "");
    }
  }
  return text;
}

/// What follows the temperature of its own place and is constant in the matrices; empty: nothing does.
std::string laws_of_temperature(const mesh::Machine& machine) {
  std::vector<std::string> all;
  for (const mesh::FilmSpec& film : machine.films) {
    if (film.emissivity.value > 0.0 && film.exact_radiation)
      all.push_back(fmt::format("radiation = \"exact\" of film '{}', included in its value", film.id));
  }
  for (const mesh::BodySpec& body : machine.bodies) {
    const mesh::Material& material = machine.material(body.material);
    if (!material.conductivity_table.at.empty() || !material.specific_heat_table.at.empty())
      all.push_back(fmt::format("body '{}' (tables of '{}')", body.id, material.id));
  }
  return core::join(all);
}

}  // namespace

MatrixNames matrix_names(const ThermalSystem& thermal, const mesh::Machine& machine, const mesh::Pose& pose) {
  const OperatingModel operating(machine, thermal.layout);
  const Eigen::VectorXd row = standing_row(operating, machine, pose);
  // Where a cooler stands still, its coolant comes in as its reference is.
  const Eigen::VectorXd inlet = Eigen::VectorXd::Zero(std::ssize(machine.coolants));
  const Coefficients standing = operating.coefficients(row, inlet);
  MatrixNames names;
  for (std::size_t j = 0; j < thermal.layout.terms.size(); ++j) {
    names.films.push_back(
        {term_name(machine, thermal.layout.terms[j]), term_unit(thermal.layout.terms[j]), standing.p[j]});
  }
  for (std::size_t k = 0; k < thermal.layout.inputs.size(); ++k) {
    names.inputs.push_back({input_name(machine, thermal.layout, thermal.layout.inputs[k]),
                            input_unit(thermal.layout, thermal.layout.inputs[k]), standing.q[k]});
  }
  for (const mesh::SensorSpec& sensor : machine.sensors) names.outputs.push_back({plain(sensor.id) + "_K", "K"});
  if (machine.has_tcp()) {
    for (const char* name : {"dx_um", "dy_um", "dz_um"}) names.outputs.push_back({name, "um"});
    for (const char* name : {"ra_um_per_m", "rb_um_per_m", "rc_um_per_m"}) names.outputs.push_back({name, "um/m"});
  }
  for (auto* all : {&names.films, &names.inputs, &names.outputs}) make_unique(*all);
  return names;
}

MatrixFiles write_matrices(const fs::path& folder, const FullModel& full, const mesh::Pose& pose) {
  const ThermalSystem& thermal = full.thermal;
  const mesh::Machine& machine = full.mesh.machine;
  MatrixFiles made;
  made.size = thermal.size;
  made.names = matrix_names(thermal, machine, pose);

  const auto sensors = std::ssize(machine.sensors);
  if (made.names.outputs.empty()) {
    throw core::InputError(machine.path.string(), "neither a [[sensor]] nor [tcp]",
                           "one of them: the matrices need an output");
  }
  Eigen::MatrixXd rows(std::ssize(made.names.outputs), thermal.size);
  rows.topRows(sensors) = Eigen::MatrixXd(thermal.sensors.topRows(sensors));
  if (rows.rows() > sensors) {
    const OutputRows of_pose = full.elastic.output_rows(pose);
    for (Index i = 0; i < thermal.size; ++i) {
      const Vector6 error =
          tcp_error(machine, pose, of_pose.tool.col(i), of_pose.table_axis.col(i), of_pose.table_own.col(i)).error;
      rows.col(i).tail(6) << error.head<3>() / core::units::um, error.tail<3>() / core::units::um_per_m;
    }
  }
  const SparseMatrix outputs = rows.sparseView();

  core::write_files_by(folder, [&](const fs::path& staged) {
    std::vector<fs::path> files;
    const auto add = [&](const std::string& name, const SparseMatrix& matrix, const std::string& what) {
      files.emplace_back(name + ".mtx");
      core::write_file(staged / files.back(), core::format_matrix_market(matrix, machine.name + ": " + what));
    };
    add("E", thermal.capacity, "capacities, J/K");
    add("A", -thermal.conduction, "negative conduction within the bodies, W/K");
    for (std::size_t j = 0; j < thermal.terms.size(); ++j) {
      add("A_film_" + made.names.films[j].name, -thermal.terms[j],
          fmt::format("negative, W/K for 1 {}", made.names.films[j].unit));
    }
    add("B", thermal.inputs, "one column per input, see names.toml");
    add("C", outputs, "one row per output, see names.toml");
    std::string names =
        "# " + machine.name +
        ": parameters (films), inputs and outputs of these matrices, with their values for the machine at rest.\n# The "
        "state is in K above the machine's reference temperature. The value of an input that an ambient drives\n# is "
        "the parameter times the ambient's temperature above the reference.\nschema = 1\n";
    names += table("film", made.names.films, true) + table("input", made.names.inputs, true) +
             table("output", made.names.outputs, false);
    core::write_file(staged / "names.toml", names);
    files.emplace_back("names.toml");
    for (const fs::path& file : files) made.files.push_back(file.string());
    return files;
  });
  // Parameters of an earlier export that this machine has not would come back as its own.
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if ((name == "D.mtx" || (name.starts_with("A_film_") && name.ends_with(".mtx"))) &&
        std::find(made.files.begin(), made.files.end(), name) == made.files.end())
      fs::remove(entry.path(), ignored);
  }
  if (const std::string list = laws_of_temperature(machine); !list.empty()) {
    made.notes.push_back(
        fmt::format("linearised at the reference temperature of {:.4g} degC: {}", machine.reference_C, list));
  }
  if (OperatingModel(machine, thermal.layout).follows_temperature()) {
    made.notes.emplace_back(
        "films, conductances or chillers depend on temperatures: the matrices hold their values as parameters and "
        "inputs, not their laws");
  }
  if (rows.rows() == sensors) made.notes.emplace_back("no [tcp]: the outputs are the sensors only");
  return made;
}

}  // namespace thermotwin::solver
