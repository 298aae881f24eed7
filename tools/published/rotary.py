# SPDX-License-Identifier: GPL-3.0-or-later
"""The C axis of the A/C machine of Gebhardt (2014).

Table 6.4: location errors of virtual R-Tests once an hour. The machine is a full model with all uncertain values drawn
anew (`measure simulate --machine-seed`), on the mesh of `--measured-size`, in random cycles of the C axis.
Fig. 5.24: how long a record has to be; sections of the record of Fig. 5.22 fit its model.
"""
import json

from published.records import Record
from published.statistics_of import cell

OF_C = ["random_cycle", "--axis", "C", "--load", "C", "--interval", "60", "--speeds", "5,60", "--standstills",
        "--cool-down", "4"]
PLANS = {"c_train": [*OF_C, "--seed", "6", "--warm-up", "30"], "c_cycle": [*OF_C, "--seed", "7", "--warm-up", "32"]}
NAME, TRAIN, JUDGED, POWER = "A/C: C axis, R-Tests (Table 6.4)", "c_train", "c_cycle", "C.motor"
PUBLISHED = {"X0C": "48", "Z0T": "62", "R0T": "71"}  # % of the range removed, from before and after in print
MODELS = ["static_regression", "phenomenological", "phenomenological_switched", "rotary_unit"]


def measured(bench, plan, out, seed):
    """Measurement folder of a virtual R-Test; made once."""
    folder = out / plan / "errors" / "measurement"
    if not (folder / "channels.toml").exists():
        bench.run("measure", "plan", *PLANS[plan], "--case", bench.case, "--out", out / plan / "plan")
        bench.run("measure", "simulate", out / plan / "plan", "--case", bench.case, "--machine-seed", seed, "--seed",
                  seed, "--size", bench.options.measured_size, "--out", out / plan / "record", "--quiet")
        bench.run("measure", "analyse", out / plan / "record", "--record", out / plan / "record" / "loads", "--out",
                  out / plan / "errors", "--quiet")
    return folder


def prepared(bench, source, folder, plan):
    record = Record(source)
    record.add_power(bench.machine, POWER)
    # B0C tells the rotary unit that the cradle turns about x. The way of the probe is no input of the source.
    record.keep_displacements(lambda channel: channel["id"] in [*PUBLISHED, "B0C"])
    record.channels = [c for c in record.channels
                       if not c.get("input", "").startswith(("axis.X.", "axis.Y.", "axis.Z."))]
    return record.write(folder / plan, plan)


def judged(bench, seed):
    """Rows of `evaluate` for the judged cycle: fitted models, and the reduced model on the record as measured."""
    out = bench.out / "rtests" / f"machine_{seed}"
    folder = out / "prepared"
    source = measured(bench, JUDGED, out, seed)
    data, training = (prepared(bench, own, folder, plan) for own, plan in
                      ((source, JUDGED), (measured(bench, TRAIN, out, seed), TRAIN)))
    answer = json.loads(bench.run("evaluate", "--data", data, "--train-data", training, "--models", ",".join(MODELS),
                                  "--out", folder, "--quiet", "--json"))
    whole = Record(source).write(out / "whole", JUDGED)
    twin = json.loads(bench.run("evaluate", bench.case, "--model", bench.model, "--data", whole, "--train-programs",
                                JUDGED, "--models", "static_regression", "--out", out / "twin", "--quiet", "--json"))
    return [row for row in answer["rows"] if row["part"] == JUDGED] + \
           [row for row in twin["rows"] if row["part"] == JUDGED and row["model"].startswith("reduced_model")]


LENGTHS_TEST = "A/C: C axis (Figs. 5.18, 5.19)"
LENGTHS_OF, LENGTHS_IN = "phenomenological", "dz@1"


def lengths(bench, test):
    """Lines of a table: the residual of the model over the length of the section that it is fitted to.

    @param test  its judged program is cut at the first machine
    """
    seed = bench.seeds[0]
    _, sources = bench.measure(test, [seed])
    folder = bench.out / test.document / "lengths"
    record = bench.prepared(test, test.judge, sources[seed][test.judge], folder)
    answer = json.loads(bench.run("evaluate", "--data", record, "--models", LENGTHS_OF, "--length-study", LENGTHS_OF,
                                  LENGTHS_IN, "--out", folder, "--quiet", "--json"))

    def box(row, key):
        low, high = row[f"{key}_rms_quartiles"]
        return f"{row[f'{key}_rms_median']:.2f} ({low:.2f} to {high:.2f})"
    lines = ["", f"Length of the record (Fig. 5.24): `{LENGTHS_OF}` fitted to random sections of {test.judge}, "
                 f"{LENGTHS_IN}, machine of seed {seed}.", "",
             "| section, h | RMS in it, um | RMS outside it, um |", "|---" * 3 + "|"]
    return lines + [f"| {row['hours']:.0f} | {box(row, 'fit')} | {box(row, 'outside')} |"
                    for row in answer["length_study"]]


def judge(bench, machines, guarded=lambda call: call()):
    """Lines of the table: a row for each model and location error.

    @param guarded  calls, and returns the words on a column that is missing in place of the result
    """
    found = guarded(lambda: [judged(bench, seed) for seed in bench.seeds[:machines]])
    lines, notes = [], []
    if isinstance(found, str):
        notes, found = [f"- {NAME}: {found}"], []
    for quantity, published in PUBLISHED.items():
        own = [{row["model"]: row for row in rows if row["channel"] == quantity} for rows in found]

        def figures(key, model, digits=0, own=own):
            return cell([rows[model][key] for rows in own if model in rows], digits)
        before = figures("peak_to_peak_before", MODELS[0], 1)
        for name in MODELS[1:]:
            lines.append("| " + " | ".join([
                NAME, "range removed, %", "random cycle, 34 h", "another, 36 h", f"{quantity} ({before} before)",
                published, f"`{name}`", *(figures("peak_to_peak_reduction_percent", of) for of in
                                          (name, MODELS[0], "reduced_model", "reduced_model_sensors"))]) + " |")
    return [*lines, "", *notes] if notes else lines
