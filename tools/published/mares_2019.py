# SPDX-License-Identifier: GPL-3.0-or-later
"""Document 004, Mareš et al. (2019): four calibrations, air cutting, and an ablation of the inputs and the start.

The machine stands for 48 h before each program: the source calibrates between equilibria, and a machine that has just
been switched on warms by its cabinet, chiller and holding currents, which no input shows. Inputs after equations (4)
and (5): sensors against the base, the surroundings, and for z the coolant's rise over the Z motor.
"""
import json
import shutil

from published import chart
from published.documents import MIDDLE, SURROUNDINGS
from published.records import MissingColumn, Record

CALIBRATIONS = ["calibration_spindle", "calibration_Y", "calibration_Z", "calibration_surroundings"]
JUDGED = "air_cutting"
SETTLING_H = 48
SETTLING = (f'[[phase]]\nname = "settling"\nduration_h = {SETTLING_H}\nair_C = 21.0\nfoundation_C = 21.0\n\n')
RISE = "coolant.main.Z_motor.rise"
BASE = {"dT_sp": ("T1", "T9"), "dT_Y": ("T3", "T9"), "dT_Z": ("T5", "T9")}
MODELS = ["armax", "heating_cooling", "output_error"]
PUBLISHED = {"dy": "7.5", "dz": "2.5"}
# inputs by direction: equation (4) for y, equation (5) for z
INPUTS = {"dy": ["dT_sp", "dT_Y", "dT_Z", SURROUNDINGS], "dz": ["dT_sp", "dT_Y", RISE, SURROUNDINGS]}
# cause, machine settled, differences to the base, coolant's rise
ABLATION = [("as published", True, True, True), ("without the coolant's rise", True, True, False),
            ("temperatures in place of differences", True, False, False),
            ("from a cold start", False, True, False)]


def settled_case(case, folder):
    """The case, whose programs of this document begin with the machine standing for 48 h, measured in the middle."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(case / "machine.toml", folder)
    for name in ("cad", "loads"):
        if not (folder / name).exists():
            shutil.copytree(case / name, folder / name)
    for load in [*CALIBRATIONS, JUDGED]:
        text = (case / "loads" / f"{load}.toml").read_text()
        at = text.index("[[phase]]")
        (folder / "loads" / f"settled_{load}.toml").write_text(text[:at] + SETTLING + text[at:])
    text = (case / "case.toml").read_text()
    (folder / "case.toml").write_text(f'{text[:text.index("[check_points]")]}[check_points]\nposes = ["{MIDDLE}"]\n')
    return folder


def prepared(source, settled, differences, rise, direction, folder, load):
    """@return the folder, and the names of inputs that the record lacks"""
    record = Record(source)
    known = {channel["id"] for channel in record.channels}
    wanted = [name for name in INPUTS[direction] if rise or name != RISE]
    if not rise and direction == "dz":
        wanted.insert(2, "dT_Z")
    missing = [name for name in wanted if name == RISE and name not in known]
    wanted = ["dT_Z" if name in missing else name for name in wanted]
    for name, (first, second) in BASE.items():
        if differences:
            record.add_difference(name, first, second)
    if not differences:
        wanted = [BASE[name][0] if name in BASE else name for name in wanted]
    record.rename_ambient(SURROUNDINGS)
    record.keep_displacements(lambda channel: channel["quantity"] == direction)
    record.keep_inputs(wanted)
    hours = float(record.rows[-1]["time_s"]) / 3600
    if settled:
        record.cut(SETTLING_H, hours)
    return record.write(folder / load, load, SETTLING_H if settled else 0.0), missing


def times_smaller(rows, model, direction):
    for row in rows:
        if row["model"] == model and row["channel"].startswith(direction + "@") and row["peak_to_peak"]:
            return f"{row['peak_to_peak_before'] / row['peak_to_peak']:.1f}"
    return "-"


def evaluated(run, sources, settled, differences, rise, direction, folder):
    """Rows of `evaluate` on air cutting, and the inputs that were missing."""
    prefix = "settled_" if settled else ""
    data = {load: prepared(sources[prefix + load], settled, differences, rise, direction, folder, load)
            for load in [*CALIBRATIONS, JUDGED]}
    answer = json.loads(run("evaluate", "--data", data[JUDGED][0], "--train-data",
                            ",".join(str(data[load][0]) for load in CALIBRATIONS), "--models",
                            ",".join([*MODELS, "static_regression"]), "--out", folder, "--quiet", "--json"))
    notes = [f"{direction}: no column '{name}' in the record; dT_Z (T5 against the base) took its place"
             for name in data[JUDGED][1]]
    return [row for row in answer["rows"] if row["part"] == JUDGED], notes


def picture(folder, path, direction, model):
    header, *lines = (folder / "evaluation" / "predictions.csv").read_text().splitlines()
    names, rows = header.split(","), [line.split(",") for line in lines]
    first = float(rows[0][0])

    def column(key):
        at = names.index(f"{direction}@1_{key}")
        return [((float(row[0]) - first) / 3600, float(row[at]) if row[at] not in ("", "nan") else float("nan"))
                for row in rows]

    measured, predicted = column("measured"), column(model)
    left = [(t, m - p) for (t, m), (_, p) in zip(measured, predicted)]
    chart.write(path, f"Air cutting, {direction}: Figs. 10 and 11",
                [("without compensation", [("measured", measured), (model, predicted)]),
                 ("with compensation", [("left", left)])], "time, h", "deformation, um")


def judge(bench, test):
    """Page of the document. @param test  of documents.py, for its name"""
    out, run = bench.options.out / "004", bench.run
    case = settled_case(bench.options.case, out / "case")
    loads = [prefix + load for prefix in ("settled_", "") for load in [*CALIBRATIONS, JUDGED]]
    how = ["--perturb", "thermal", "--coolant"] if bench.options.full else ["--truth", bench.truth]
    run("validate", case, "--model", bench.model, *how, "--draws", 1, "--first-seed", bench.options.seed, "--load",
        *loads, "--out", out, "--quiet")
    kept = out / "measured" / ("thermal" if bench.options.full else "reduced")
    sources = {load: kept / load / f"machine_{bench.options.seed}" for load in loads}
    cells, notes = {}, []
    for number, (cause, settled, differences, rise) in enumerate(ABLATION):
        for direction in INPUTS:
            folder = out / f"{number}_{direction}"
            try:
                rows, missing = evaluated(run, sources, settled, differences, rise, direction, folder)
            except MissingColumn as error:
                bench.missing.append(str(error))
                rows, missing = [], [f"{direction}, {cause}: {error}"]
            notes += [note for note in missing if note not in notes]
            for model in [*MODELS, "static_regression"]:
                cells[cause, direction, model] = times_smaller(rows, model, direction)
            if number == 0 and rows:
                picture(folder, out / f"mares_2019_{direction}.svg", direction, "armax")
    whole = Record(sources["settled_" + JUDGED])
    whole.channels = [channel for channel in whole.channels if not channel["id"].startswith("coolant.main.")
                      or not channel["id"].endswith(".rise")]
    for channel in whole.channels:
        if channel["kind"] == "displacement":
            channel["zero"] = "absolute"
    whole.write(out / "whole", JUDGED, SETTLING_H)
    twin = json.loads(run("evaluate", case, "--model", bench.model, "--data", out / "whole", "--train-programs", JUDGED,
                          "--models", "static_regression", "--out", out / "twin", "--quiet", "--json"))
    rows = [row for row in twin["rows"] if row["part"] == JUDGED]
    lines = ["| direction | published | model | ours | static regression | reduced model | with sensors |",
             "|---" * 7 + "|"]
    for direction, published in PUBLISHED.items():
        for model in MODELS:
            lines.append("| " + " | ".join([
                direction, published, f"`{model}`", cells["as published", direction, model],
                cells["as published", direction, "static_regression"],
                *(times_smaller(rows, name, direction) for name in ("reduced_model", "reduced_model_sensors"))]) + " |")
    lines += ["", "Ablation: times smaller.", "",
              "| cause | " + " | ".join(f"{d} `{m}`" for d in INPUTS for m in [*MODELS, "static"]) + " |",
              "|---" * 9 + "|"]
    for cause, *_ in ABLATION:
        lines.append("| " + " | ".join([cause, *(cells[cause, d, m] for d in INPUTS
                                                 for m in [*MODELS, "static_regression"])]) + " |")
    return lines + ["", *(f"- {note}" for note in notes)]
