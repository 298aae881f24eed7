// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/calculix_deck.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/file.h"
#include "core/range.h"
#include "solver/export/calculix_loads.h"
#include "solver/export/calculix_model.h"
#include "solver/export/calculix_static.h"
#include "solver/operation/layout.h"

namespace thermotwin::solver {

using Eigen::Index;
using namespace calculix;

namespace {

Layout layout_at_pose(const Model& model) {
  std::vector<JointGrid> grids;
  for (const mesh::JointSpec& joint : model.machine().joints) {
    const int axis = joint.axis.empty() ? -1 : model.machine().axis_index(joint.axis);
    grids.push_back({axis, false, {axis < 0 ? 0.0 : model.pose[axis]}});
  }
  return make_layout(model.machine(), std::move(grids));
}

void fill(Program& program, const Model& model) {
  const DeckOptions& options = model.options;
  if (!options.program) {
    program.rows = {program.operating.channels().defaults()};
    return;
  }
  const LoadProgram& load = *options.program;
  if (options.steady_at >= 0.0) {
    if (!(options.steady_at <= load.duration())) {
      throw core::InputError("steady state at", fmt::format("{} s", options.steady_at),
                             fmt::format("0 to {} s, the length of '{}'", load.duration(), load.name()));
    }
    program.rows = {load.row_at(options.steady_at, options.steady_at)};
    return;
  }
  program.ends = load.step_ends(options.refine);
  for (std::size_t i = 0; i < program.ends.size(); ++i)
    program.rows.push_back(load.row(i > 0 ? program.ends[i - 1] : 0.0, program.ends[i]));
}

/// Runs of equal increments, within a phase of the program.
struct Step {
  double length = 0;
  long increments = 0;
  std::string phase;
};

std::vector<Step> steps_of(const LoadProgram& load, const std::vector<double>& ends) {
  std::vector<Step> steps;
  double from = 0.0;
  for (const double end : ends) {
    const double size = end - from;
    const bool same = !steps.empty() && !load.is_corner(from) &&
                      std::abs(size * steps.back().increments / steps.back().length - 1.0) < 1e-9;
    if (!same) steps.push_back({0.0, 0, load.phase_at(0.5 * (from + end))});
    steps.back().length += size;
    ++steps.back().increments;
    from = end;
  }
  return steps;
}

std::string header(const Model& model, const std::string& title) {
  std::string text =
      "** " + title + "\n** machine " + model.machine().name + ", written by thermotwin; SI units, degC\n";
  const std::string pose = mesh::format_pose(model.machine(), model.pose);
  if (!pose.empty()) text += "** pose " + pose + "\n";
  return text;
}

std::string comments(const std::vector<std::string>& notes) {
  constexpr std::size_t width = 100;
  std::string text;
  for (const std::string& note : notes) {
    std::size_t from = 0;
    while (from < note.size()) {
      std::size_t to = note.size() - from <= width ? note.size() : note.rfind(' ', from + width);
      if (to == std::string::npos || to <= from) to = std::min(note.size(), from + width);
      text += (from == 0 ? "** - " : "**   ") + note.substr(from, to - from) + "\n";
      from = to + (to < note.size() ? 1 : 0);
    }
  }
  return text;
}

/// Nodes nearest to the sensors, to be printed at every increment.
std::string sensors_text(Model& model) {
  std::string text;
  for (const mesh::SensorSpec& sensor : model.machine().sensors) {
    const int b = model.machine().body_index(sensor.body);
    if (!model.takes(b)) continue;
    const mesh::TetMesh& body = model.mesh.bodies[b];
    Index nearest = 0;
    const double distance =
        std::sqrt((body.points.colwise() - sensor.point).colwise().squaredNorm().minCoeff(&nearest));
    text += fmt::format("** sensor {}: node {}, {:.3g} mm beside it\n*NSET, NSET=SENSORS\n{}\n", sensor.id,
                        model.node(b, nearest), 1e3 * distance, model.node(b, nearest));
  }
  return text;
}

std::string heat_steps(Model& model, const Program& program, const Loads& loads, bool sensors, DeckSummary& summary) {
  const std::string output =
      std::string("*NODE FILE, FREQUENCY=999999\nNT\n") + (sensors ? "*NODE PRINT, NSET=SENSORS\nNT\n" : "");
  if (program.steady()) {
    summary.steps = 1;
    summary.increments = 1;
    return "*STEP\n*HEAT TRANSFER, STEADY STATE\n1, 1\n" + loads.lines + output + "*END STEP\n";
  }
  std::string text;
  const std::vector<Step> steps = steps_of(*model.options.program, program.ends);
  for (const Step& step : steps) {
    text += fmt::format("** {}\n*STEP, INC={}, AMPLITUDE=STEP\n*HEAT TRANSFER, DIRECT\n{:.15g}, {:.15g}\n",
                        step.phase.empty() ? "phase" : step.phase, step.increments + 1, step.length / step.increments,
                        step.length);
    if (summary.steps == 0) text += loads.lines;
    text += output + "*END STEP\n";
    ++summary.steps;
    summary.increments += step.increments;
  }
  summary.end = program.ends.back();
  return text;
}

/// Differences of the two programs in space and time that stay on one mesh.
void note_schemes(const mesh::Machine& machine, const DeckOptions& options, bool steady,
                  std::vector<std::string>& notes) {
  if (machine.lumped_capacity)
    notes.push_back("the capacity matrix is lumped in thermotwin and consistent in CalculiX");
  notes.push_back(std::string("CalculiX integrates capacity and films with ") +
                  (machine.order == 1 ? "one point (C3D4)" : "four and three points (C3D10)") +
                  ", thermotwin exactly; both converge, but on one mesh they differ by their discretisation errors");
  if (!steady && options.program->time().scheme != TimeScheme::backward_euler) {
    notes.push_back(
        "CalculiX steps by implicit Euler, first order; thermotwin's own scheme of this load is of second order");
  }
}

}  // namespace

calculix::Program::Program(const Model& model) : operating(model.machine(), layout_at_pose(model)) {
  fill(*this, model);
  const Eigen::VectorXd no_inlets = Eigen::VectorXd::Zero(std::ssize(model.machine().coolants));
  for (const Eigen::VectorXd& row : rows) coefficients.push_back(operating.coefficients(row, no_inlets));
}

std::vector<double> calculix::Program::coefficient(TermKind kind, int item, int* term) const {
  const std::vector<Term>& terms = operating.layout().terms;
  const auto at =
      std::find_if(terms.begin(), terms.end(), [&](const Term& t) { return t.kind == kind && t.item == item; }) -
      terms.begin();
  if (term) *term = at;
  std::vector<double> values;
  for (const Coefficients& c : coefficients) values.push_back(c.p[at]);
  return values;
}

void DeckOptions::validate() const {
  core::require_within("deck options: refine", refine, core::positive);
  core::require_within("deck options: steady_at", steady_at, core::any_number);
  if (!pose.allFinite())
    throw core::InputError("deck options: pose", "a position that is not a number", "finite values");
}

DeckSummary write_calculix_deck(const std::filesystem::path& folder, const mesh::MachineMesh& mesh,
                                const DeckOptions& options) {
  options.validate();
  Model model(mesh, options);
  const mesh::Machine& machine = mesh.machine;
  DeckSummary summary;
  bool with_heat_only = false, with_elastic = false;
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    if (!model.taken[b]) continue;
    summary.nodes += mesh.bodies[b].nodes();
    summary.elements += mesh.bodies[b].elements();
    (machine.bodies[b].elastic ? with_elastic : with_heat_only) = true;
  }
  const Program program(model);
  const auto contact = contacts(model);
  const std::string joints = contact_text(model, program, contact);
  const Loads loads = loads_text(model, program, contact);
  if (program.steady() && !loads.has_level) {
    throw core::InputError("steady state", "no film, mount or coolant wall with a coefficient above 0",
                           "a machine with a path for its heat, or a load program");
  }
  const bool with_static = with_elastic && !options.heat_only;
  if (!with_elastic) model.notes.push_back("no body of the deck is elastic: there is no static.inp");
  const Statics elastic = with_static ? statics(model) : Statics{};
  note_schemes(machine, options, program.steady(), model.notes);
  if (!machine.volumes.empty())
    model.notes.push_back("volumes (tanks, working areas) and their exchanges are not in the deck");
  const std::string sensors = sensors_text(model);
  const double initial = options.program ? options.program->initial_C() : machine.reference_C;
  const std::string load = !options.program ? "the machine at rest, steady state"
                           : options.steady_at >= 0
                               ? fmt::format("steady state of {} at {:g} s", options.program->name(), options.steady_at)
                               : "load " + options.program->name() + ": " + options.program->title();
  const std::string include = "*INCLUDE, INPUT=mesh.inp\n";
  std::string heat = header(model, "Heat transfer: " + load) +
                     "** run: ccx heat; temperatures are in heat.frd at the end of each step\n";
  heat += comments(model.notes) + include + materials_text(model, true);
  if (with_heat_only) heat += "*INCLUDE, INPUT=heat_only.inp\n" + materials_text(model, false);
  heat += joints + sensors + elastic.heat_model;
  heat += fmt::format("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNODES, {:.10g}\n", initial);
  if (!elastic.heat_model.empty()) heat += fmt::format("TAPES, {:.10g}\n", initial);
  heat += loads.amplitudes + heat_steps(model, program, loads, !sensors.empty(), summary);

  std::string bend =
      header(model, "Thermo-elastic displacement at the end of heat.inp") + "** run: ccx heat, then ccx static\n";
  bend += comments(model.notes) + include + materials_text(model, true) + elastic.model;
  bend += fmt::format("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNODES, {:.10g}\n", machine.reference_C);
  if (!elastic.heat_model.empty()) bend += fmt::format("TAPES, {:.10g}\n", machine.reference_C);
  bend += fmt::format("*STEP\n*STATIC\n*TEMPERATURE, FILE=heat.frd, BSTEP={}\nNODES, {:.10g}\n", summary.steps,
                      machine.reference_C);
  if (!elastic.heat_model.empty()) bend += fmt::format("TAPES, {:.10g}\n", machine.reference_C);
  bend += "*NODE FILE\nU, NT\n*EL FILE\nS\n*END STEP\n";

  core::write_files_by(folder, [&](const std::filesystem::path& staged) {
    std::vector<std::filesystem::path> files;
    const auto write = [&](const char* name, const std::string& text) {
      core::write_file(staged / name, text);
      files.emplace_back(name);
      summary.files.emplace_back(name);
    };
    write("mesh.inp", header(model, "Nodes and elements") + nodes_text(model) + elements_text(model, true));
    if (with_heat_only) {
      write("heat_only.inp",
            header(model, "Elements of bodies that take part in heat only") + elements_text(model, false));
    }
    if (with_static) write("static.inp", bend);
    write("heat.inp", heat);
    return files;
  });
  summary.notes = std::move(model.notes);
  return summary;
}

}  // namespace thermotwin::solver
