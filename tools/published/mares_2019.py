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
from published.statistics_of import cell, measured_by, median

CALIBRATIONS = ["calibration_spindle", "calibration_Y", "calibration_Z", "calibration_surroundings"]
JUDGED = "air_cutting"
SETTLING_H = 48
SETTLING = (f'[[phase]]\nname = "settling"\nduration_h = {SETTLING_H}\nair_C = 21.0\nfoundation_C = 21.0\n\n')
RISE = "coolant.main.Z_motor.rise"
BASE = {"dT_sp": ("T1", "T9"), "dT_Y": ("T3", "T9"), "dT_Z": ("T5", "T9")}
MODELS = ["armax", "heating_cooling", "output_error"]
PUBLISHED = {"dy": "7.5", "dz": "2.5"}
PRINTED_UM = {"dy": (83, 11), "dz": (47, 19)}   # range without and with compensation, section 3.1
# inputs by direction: equation (4) for y, equation (5) for z
INPUTS = {"dy": ["dT_sp", "dT_Y", "dT_Z", SURROUNDINGS], "dz": ["dT_sp", "dT_Y", RISE, SURROUNDINGS]}
# One cause at a time: machine settled, differences to the base, coolant's rise, noise, parameters perturbed, training
AS_PUBLISHED = {"settled": True, "differences": True, "rise": True, "noise": True, "perturb": "thermal", "own": False}
ABLATION = [("without the coolant's rise", {"rise": False}),
            ("temperatures in place of differences", {"differences": False, "rise": False}),
            ("from a cold start", {"settled": False, "rise": False}),
            ("no noise", {"noise": False}), ("parameters as stated", {"perturb": "none"}),
            ("trained on the judged program", {"own": True})]
TWIN = ("reduced_model", "reduced_model_sensors")


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
    """How many times smaller the range is; None: the model predicts nothing."""
    for row in rows:
        if row["model"] == model and row["channel"].startswith(direction + "@"):
            return measured_by(row, "times")
    return None


def evaluated(run, sources, how, direction, folder):
    """Rows of `evaluate` on air cutting, and the inputs that were missing. @param how  as AS_PUBLISHED"""
    prefix = "settled_" if how["settled"] else ""
    loads = [*([] if how["own"] else CALIBRATIONS), JUDGED]
    data = {load: prepared(sources[prefix + load], how["settled"], how["differences"], how["rise"], direction, folder,
                           load) for load in loads}
    training = (["--train-programs", JUDGED] if how["own"] else
                ["--train-data", ",".join(str(data[load][0]) for load in CALIBRATIONS)])
    answer = json.loads(run("evaluate", "--data", data[JUDGED][0], *training, "--models",
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


class Judgement:
    """Times smaller of every cause, direction and model, by machine."""

    def __init__(self, bench):
        self.bench, self.out = bench, bench.out / "004"
        self.case = settled_case(bench.case, self.out / "case")
        self.cells, self.ranges, self.notes = {}, {}, []

    def measured(self, how, seeds):
        prefixes = ["settled_"] if how["settled"] else [""]
        loads = [prefix + load for prefix in prefixes for load in [*CALIBRATIONS, JUDGED]]
        name = "measured" + ("" if how["settled"] else "_cold") + ("" if how["noise"] else "_no_noise")
        name += "" if how["perturb"] == "thermal" else f"_{how['perturb']}"
        return self.bench.validate(self.case, loads, self.out / name, how["noise"], how["perturb"], seeds, True)

    def add(self, cause, change, seeds):
        how = {**AS_PUBLISHED, **change}
        sources = self.measured(how, seeds)
        for seed in seeds:
            own = {load: folders[seed] for load, folders in sources.items()}
            for direction in INPUTS:
                folder = self.out / cause.replace(" ", "_").replace("'", "") / f"{direction}_{seed}"
                self.of_machine(cause, own, how, direction, folder)
        return sources

    def of_machine(self, cause, sources, how, direction, folder):
        try:
            rows, missing = evaluated(self.bench.run, sources, how, direction, folder)
        except MissingColumn as error:
            self.bench.missing.append(str(error))
            rows, missing = [], [f"{direction}, {cause}: {error}"]
        self.notes += [note for note in missing if note not in self.notes]
        self.put(cause, direction, rows, [*MODELS, "static_regression"])

    def put(self, cause, direction, rows, models):
        for model in models:
            self.cells.setdefault((cause, direction, model), []).append(times_smaller(rows, model, direction))
        for row in rows:
            if row["channel"].startswith(direction + "@") and row["model"] in models:
                self.ranges.setdefault((cause, direction, row["model"]), []).append(
                    (row["peak_to_peak_before"], row["peak_to_peak"]))

    def twin(self, source, seed):
        """The reduced model on the record as it was measured."""
        whole = Record(source)
        whole.channels = [channel for channel in whole.channels if not channel["id"].startswith("coolant.main.")
                          or not channel["id"].endswith(".rise")]
        for channel in whole.channels:
            if channel["kind"] == "displacement":
                channel["zero"] = "absolute"
        data = whole.write(self.out / f"whole_{seed}", JUDGED, SETTLING_H)
        answer = json.loads(self.bench.run("evaluate", self.case, "--model", self.bench.model, "--data", data,
                                           "--train-programs", JUDGED, "--models", "static_regression", "--out",
                                           self.out / f"twin_{seed}", "--quiet", "--json"))
        for direction in INPUTS:
            self.put("as published", direction, [row for row in answer["rows"] if row["part"] == JUDGED], TWIN)

    def table(self):
        lines = ["| direction | published | model | ours | static regression | reduced model | with sensors |",
                 "|---" * 7 + "|"]
        for direction, published in PUBLISHED.items():
            for model in MODELS:
                lines.append("| " + " | ".join([
                    direction, published, f"`{model}`",
                    *(cell(self.cells.get(("as published", direction, of), []), 1)
                      for of in (model, "static_regression", *TWIN))]) + " |")
        return lines

    def ablation(self, causes, count):
        shown = [*MODELS, "static_regression"]
        lines = ["", f"Ablation, {count} machines: times smaller.", "",
                 "| cause | " + " | ".join(f"{d} `{m}`" for d in INPUTS for m in shown) + " |", "|---" * 9 + "|"]
        for cause in causes:
            lines.append("| " + " | ".join([cause, *(cell(self.cells[cause, d, m][:count], 1) for d in INPUTS
                                                     for m in shown)]) + " |")
        return lines


def bars(judgement, path):
    """Range without and with compensation, um, as Figs. 10 and 11 are summed up in print."""
    groups = []
    for direction, (before, after) in PRINTED_UM.items():
        values = [("print: without", before), ("print: with", after)]
        own = judgement.ranges.get(("as published", direction, "armax"), [])
        values += [("ours: without", median([pair[0] for pair in own]))]
        for name, model in (("armax", "armax"), ("reduced model", "reduced_model")):
            pairs = judgement.ranges.get(("as published", direction, model), [])
            values.append((f"ours: {name}", median([pair[1] for pair in pairs])))
        groups.append((direction, values))
    chart.write_bars(path, "Range of the error in air cutting, without and with compensation", groups, "range, um")


def judge(bench, test):
    """Page of the document. @param test  of documents.py, for its name"""
    made = Judgement(bench)
    sources = made.add("as published", {}, bench.seeds)
    for seed in bench.seeds:
        made.twin(sources["settled_" + JUDGED][seed], seed)
    first = bench.seeds[0]
    for direction in INPUTS:
        folder = made.out / "as_published" / f"{direction}_{first}"
        if (folder / "evaluation/predictions.csv").exists():
            picture(folder, made.out / f"mares_2019_{direction}.svg", direction, "armax")
    bars(made, made.out / "mares_2019_range.svg")
    lines = made.table()
    if bench.some:
        for cause, change in ABLATION:
            made.add(cause, change, bench.some)
        lines += made.ablation(["as published", *(cause for cause, _ in ABLATION)], len(bench.some))
    return lines + ["", *(f"- {note}" for note in made.notes)]
