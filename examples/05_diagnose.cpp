// SPDX-License-Identifier: GPL-3.0-or-later
// Example 5: what a measurement shows to be wrong with the model.
//
// Each possible cause is a change to the same equation: a power, a film coefficient, a contact conductance, a sensor's
// offset. diagnose() weighs them by their evidence, judges the best on held-out time, and writes the
// extended machine. The case's [measured_machine] says which deviation is hidden in the machine that is measured here.
//
// Usage: 05_diagnose [CASE [MODEL [OUT]]]    OUT: folder for diagnosis.json, report.html, ...; default diagnosis
#include <algorithm>
#include <cstdio>

#include "compensation/measurement/virtual_measurement.h"
#include "core/error.h"
#include "core/progress.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/report/write_diagnosis.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"

using namespace thermotwin;

namespace {

int run(const char* folder, const char* file, const char* out) {
  const reduction::ReducedModel model = reduction::read_model(file);
  const solver::Case machine_case = solver::read_case(folder);
  if (!machine_case.measured_machine)
    throw core::InputError(machine_case.folder / "case.toml", "no [measured_machine]", "a deviation to be found");
  const solver::MeasuredMachine& hidden = *machine_case.measured_machine;

  // 1. The deviating machine: nominal values perturbed within their uncertainty, then one of them far outside of it.
  const diagnosis::Parameter deviation = diagnosis::make_parameter(diagnosis::kind_named(hidden.kind), hidden.where);
  const mesh::Machine machine =
      diagnosis::with_parameter(compensation::perturbed(machine_case.machine, hidden.seed), deviation, hidden.factor);

  // 2. Its measurement: inputs, temperature sensors and displacements at the check points. A measurement of a real
  //    machine is a folder with channels.toml and data.csv, read by compensation::read_measurement().
  compensation::VirtualOptions truth;
  truth.seed = hidden.seed;
  truth.size_factor = hidden.size_factor * mesh::size_factor(machine, machine_case.size);
  truth.refine = hidden.refine;
  mesh::MeshOptions meshing;
  meshing.size_factor = truth.size_factor;
  const compensation::Measurement measurement = compensation::measure_virtually(
      solver::build_full_model(machine, meshing), machine_case.load(hidden.load), machine_case.check_points, truth);

  // 3. The diagnosis.
  const diagnosis::Diagnosis result = diagnosis::diagnose(model, measurement, {});
  std::printf("%s\n\nprobability   cause\n", result.sentence.c_str());
  for (std::size_t i = 0; i < std::min<std::size_t>(4, result.ranking.size()); ++i) {
    const diagnosis::RankedCause& cause = result.ranking[i];
    std::printf("%9.1f %%   %s = %.3f +- %.3f\n", 100.0 * cause.probability, name_of(cause.parameter).c_str(),
                cause.value, cause.std);
  }
  std::printf("hidden        %s x %.3g of a perturbed value\n", name_of(deviation).c_str(), hidden.factor);

  // 4. The page, the JSON and the extended machine, in files.
  diagnosis::write_diagnosis(out, result, model);
  std::printf("wrote %s/report.html\n", out);

  const auto is_hidden = [&](const diagnosis::RankedCause& cause) {
    return cause.parameter.kind == deviation.kind && cause.parameter.where == deviation.where;
  };
  const bool found = result.verdict == diagnosis::Verdict::explained && result.causes.size() == 1 &&
                     is_hidden(result.causes.front()) && result.heldout_rms_after_um < result.heldout_rms_before_um;
  return found ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  core::set_quiet(true);
  try {
    return run(argc > 1 ? argv[1] : TOY_CASE, argc > 2 ? argv[2] : "model.rom.h5", argc > 3 ? argv[3] : "diagnosis");
  } catch (const core::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_status();
  }
}
