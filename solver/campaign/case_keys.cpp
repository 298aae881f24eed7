// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/case_keys.h"

#include "solver/operation/load_keys.h"

namespace thermotwin::solver {

using core::Absent;
using core::KeyTable;
using core::positive;
using core::required;
namespace key = core::key;

namespace {

const KeyTable reduction{
    "reduction",
    "The reduced model.",
    {key::number("tolerance_um", "um", positive, 0.1,
                 "Largest error of the TCP translations on the training loads; it decides the order.")}};

const KeyTable check_points{
    "check_points",
    "Poses off the grid at which models are checked; `validate` and `run` ask for them.",
    {key::texts("poses", Absent{}, "Poses as on the command line: \"X=-250,Y=100,Z=200,B=0\".")}};

const KeyTable measured_machine{
    "measured_machine",
    "Without a measurement, `run` simulates one: on a finer mesh, with another time scheme, perturbed parameters, "
    "noise and one hidden effect.",
    {
        key::text("load", required, "The load program that the measured machine runs."),
        key::word("kind", {"source_power", "film_coefficient", "contact_conductance"}, required,
                  "Kind of the hidden effect."),
        key::text("where", required, "Id of the source, film or joint with the hidden effect."),
        key::number("factor", "1", positive, required,
                    "Factor of the hidden effect; it multiplies the perturbed value of the measured machine."),
        key::whole("seed", 0, 1'000'000'000, 7.0, "Seed of the perturbed parameters and the noise."),
        key::number("size_factor", "1", positive, 0.8,
                    "Element sizes of the measured machine over those of the case's mesh."),
        key::number("refine", "1", positive, 0.8, "Time steps of the measured machine over those of the load program."),
    }};

KeyTable table_of_case() {
  return {"case.toml",
          "A case: a machine with its load programs.",
          {
              key::schema(),
              key::text("machine", "machine.toml", "The machine's file, relative to case.toml."),
              key::text("size", "coarse", "Default mesh: coarse, standard, fine or a size factor."),
              key::texts("train", Absent{}, "Training load programs, by file name without .toml."),
              key::texts("holdout", Absent{}, "Held-out load programs, on which errors are stated."),
              key::text("measurement", Absent{}, "A measurement folder that `run` diagnoses."),
              key::table("reduction", reduction, Absent{}, "The reduced model."),
              key::table("time", time_keys(), Absent{}, "For load programs without a [time] of their own."),
              key::table("check_points", check_points, Absent{}, "Poses off the workspace grid."),
              key::table("measured_machine", measured_machine, Absent{},
                         "The virtual measurement that `run` makes where `measurement` is absent."),
          }};
}

}  // namespace

const KeyTable& case_keys() {
  static const KeyTable table = table_of_case();
  return table;
}

}  // namespace thermotwin::solver
