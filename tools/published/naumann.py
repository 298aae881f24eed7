# SPDX-License-Identifier: GPL-3.0-or-later
"""Document 003, Naumann et al. (2023): training campaign, both validations, and an ablation of the composite model.

Trained on tables of the nominal model at 27 poses and three tilts, with noise as of a measurement: steady states with
the machine off (module 1), nine ambient cycles (module 2), single axes and combinations (module 3). Judged between the
poses at the check points of a perturbed machine. The print's figure is of the error vector at each place.
"""
import json
import math

from published import chart
from published.records import Record
from published.statistics_of import cell, median

BASELINE = ["baseline"]
AMBIENT = [f"ambient_{i}" for i in range(1, 10)]
SINGLE = ["spindle_3000", "spindle_12000", "x_rapid", "y_rapid", "z_rapid", "table_150", "table_1200",
          "swivel_pendular", "swivel_hold_90", "fluid"]
COMBINED = ["fluid_all_axes", "combination_xy", "combination_yzb", "combination_xz_fluid", "combination_xbc"]
ALL = [*BASELINE, *AMBIENT, *SINGLE, *COMBINED]
VALIDATIONS = {"validation_21C": "56 to 72", "validation_35C": "42 to 52"}
OURS, JOINT, STATIC = "composite_modules_grid", "composite_grid", "static_grid"
FEWER = ["ambient_1", "ambient_3", "ambient_7", "ambient_9"]
# name, model, sides apart, load programs: one cause at a time
ABLATION = [
    ("as published", OURS, True, ALL),
    ("sides together", OURS, False, ALL),
    ("modules 2 and 3 in one fit", OURS + ":together", True, ALL),
    ("no module 1", OURS + ":no_baseline", True, ALL),
    ("no delays", OURS + ":no_delays", True, ALL),
    ("air in place of T8 and T9", OURS + ":air", True, ALL),
    ("no combined loads in training", OURS, True, [*BASELINE, *AMBIENT, *SINGLE]),
    ("four ambient cycles of nine", OURS, True, [*BASELINE, *FEWER, *SINGLE, *COMBINED]),
    ("one fit of all modules, air, sides together", JOINT, False, ALL),
    ("static regression", STATIC, False, ALL),
]
JUDGED = [(OURS, True, ALL), (JOINT, False, ALL), (STATIC, False, ALL)]   # of every machine, without an ablation
DIRECTIONS = ("dx", "dy", "dz")
# Figs. 14 and 16: probe 2 at B = 0 and probe 3 at B = 90 deg, by the order of the case's check points.
PICTURES = {"validation_21C": (2, "Fig. 14: probe 2, table vertical axis (B = 0)"),
            "validation_35C": (6, "Fig. 16: probe 3, table tilted (B = 90 deg)")}


def removed(rows, model, channels):
    """RMS removed over channels that belong together, %; None where a channel has no prediction."""
    own = {row["channel"]: row for row in rows if row["model"] == model}
    if any(channel not in own or own[channel]["rms"] is None for channel in channels):
        return None
    before = sum(own[channel]["rms_before"] ** 2 for channel in channels)
    return 100 * (1 - math.sqrt(sum(own[channel]["rms"] ** 2 for channel in channels) / before)) if before else None


def figures(rows, model, places):
    """Of the vector and of each direction: median over the places."""
    vector = [removed(rows, model, [f"{d}@check{p}" for d in DIRECTIONS]) for p in places]
    return [median(vector), *(median([removed(rows, model, [f"{d}@check{p}"]) for p in places]) for d in DIRECTIONS)]


class Training:
    """Measurement folders of the campaign's tables, by sides and load programs; made once."""

    def __init__(self, bench, inputs):
        self.bench, self.inputs, self.made = bench, inputs, {}
        self.out = bench.out / "003"

    def folder(self, sides, loads):
        key = (sides, tuple(loads))
        if key not in self.made:
            if not self.made:
                self.bench.run("campaign", self.bench.case, "--reduced", "--model", self.bench.model,
                               "--all-tilts", "--load", *ALL, "--out", self.out, "--quiet")
            folder = self.out / f"training_{len(self.made)}"
            self.bench.as_measured(self.out / "campaign_reduced", folder, loads, "--poses", "1", "--held",
                                   *(["--sides"] if sides else []))
            record = Record(folder)  # a model may use only what the judged record has
            record.channels = [c for c in record.channels if c["kind"] == "displacement" or c["id"] in self.inputs]
            self.made[key] = record.write(folder)
        return self.made[key]


def pictures(folder, out, name, model, series):
    """Measured and predicted TCP displacement over time at the place that the print shows."""
    place, title = PICTURES[name]
    header, *lines = (folder / "evaluation" / "predictions.csv").read_text().splitlines()
    names = header.split(",")
    rows = [line.split(",") for line in lines]

    def column(key):
        at = names.index(key)
        return [(float(row[0]) / 3600, float(row[at]) if row[at] not in ("", "nan") else math.nan) for row in rows]

    panels = [(d, [("measured", column(f"{d}@check{place}_measured")),
                   ("three modules", column(f"{d}@check{place}_{model}")),
                   ("static regression", column(f"{d}@check{place}_{series}"))]) for d in DIRECTIONS]
    chart.write(out / f"naumann_{name}.svg", title, panels, "time, h", "TCP displacement, um")


class Judgement:
    """Figures of every model of a validation, a list of machines each."""

    def __init__(self, bench, test):
        self.bench, self.out = bench, bench.out / "003"
        self.cells, self.notes, self.records = {}, [], {}
        for name in VALIDATIONS:
            self.measured(name, test)
        first = Record(next(iter(self.records.values())))
        self.training = Training(bench, {c["id"] for c in first.channels})
        self.check = [c["id"] for c in first.channels if c["kind"] == "displacement"]
        self.places = sorted({int(channel.split("@check")[1]) for channel in self.check})

    def measured(self, name, test):
        test.judge, test.train = name, []
        self.case, sources = self.bench.measure(test, self.bench.seeds)
        for seed, folders in sources.items():
            record = Record(folders[name])
            record.rename_displacements(lambda channel: channel.replace("@", "@check"))
            self.records[name, seed] = record.write(self.out / "judged" / name / str(seed), name)

    def evaluated(self, name, seed, sides, loads, models):
        folder = self.out / name / f"{'sides' if sides else 'whole'}_{len(loads)}_{len(models)}" / str(seed)
        answer = json.loads(self.bench.run(
            "evaluate", "--data", self.records[name, seed], "--train-data", self.training.folder(sides, list(loads)),
            "--models", ",".join(models), "--check", ",".join(self.check), "--out", folder, "--quiet", "--json"))
        self.notes += [note for note in answer["notes"] if "left out" in note and note not in self.notes]
        rows = [row for row in answer.get("rows", []) if row["part"] == name]
        for model in models:
            self.cells.setdefault((name, model, sides, tuple(loads)), []).append(figures(rows, model, self.places))
        return folder

    def twin(self, name, seed):
        answer = json.loads(self.bench.run(
            "evaluate", self.case, "--model", self.bench.model, "--data", self.records[name, seed],
            "--train-programs", name, "--models", "static_regression", "--out", self.out / name / f"twin_{seed}",
            "--quiet", "--json"))
        rows = [row for row in answer["rows"] if row["part"] == name]
        for model in ("reduced_model", "reduced_model_sensors"):
            self.cells.setdefault((name, model), []).append(figures(rows, model, self.places))

    def table(self):
        lines = ["| test | quantity | published | three modules | one fit of all modules | static regression | "
                 "reduced model | with sensors |", "|---" * 8 + "|"]
        for name, published in VALIDATIONS.items():
            for i, quantity in enumerate(("error vector", *DIRECTIONS)):
                keys = [(name, OURS, True, tuple(ALL)), (name, JOINT, False, tuple(ALL)),
                        (name, STATIC, False, tuple(ALL)), (name, "reduced_model"), (name, "reduced_model_sensors")]
                lines.append("| " + " | ".join([name, quantity, published if i == 0 else "-", *(
                    cell([one[i] for one in self.cells[key]]) for key in keys)]) + " |")
        return lines

    def bars(self, path):
        """RMS of the error vector removed: the range in print, and the medians of ours."""
        groups = []
        for name, published in VALIDATIONS.items():
            low, high = (float(value) for value in published.split(" to "))
            keys = {"three modules": (name, OURS, True, tuple(ALL)),
                    "static regression": (name, STATIC, False, tuple(ALL)), "reduced model": (name, "reduced_model")}
            groups.append((name, [("print: least", low), ("print: most", high), *(
                (f"ours: {label}", median([one[0] for one in self.cells[key]])) for label, key in keys.items())]))
        chart.write_bars(path, "RMS of the error vector that is removed", groups, "removed, %")

    def ablation(self, count):
        lines = ["", f"Ablation, {count} machines: RMS removed, %.", "",
                 "| cause | " + " | ".join(f"{n} {q}" for n in VALIDATIONS for q in ("vector", "x", "y", "z")) + " |",
                 "|---" * 9 + "|"]
        for cause, model, sides, loads in ABLATION:
            row = [cell([one[i] for one in self.cells[name, model, sides, tuple(loads)][:count]])
                   for name in VALIDATIONS for i in range(1 + len(DIRECTIONS))]
            lines.append("| " + " | ".join([cause, *row]) + " |")
        return lines


def judge(bench, test):
    """Page of the document. @param test  of documents.py, whose judge is not used: both validations are judged"""
    made = Judgement(bench, test)
    groups = dict.fromkeys((sides, tuple(loads)) for _, _, sides, loads in ABLATION)
    for name in VALIDATIONS:
        for seed in bench.seeds:
            folder = made.evaluated(name, seed, True, ALL, [OURS, STATIC])
            made.evaluated(name, seed, False, ALL, [JOINT, STATIC])
            made.twin(name, seed)
            if seed == bench.seeds[0]:
                pictures(folder, made.out, name, OURS, STATIC)
        for seed in bench.some:
            for sides, loads in groups:
                models = [m for _, m, s, own in ABLATION if (s, tuple(own)) == (sides, loads)
                          and (m, s, list(loads)) not in JUDGED]
                if models:
                    made.evaluated(name, seed, sides, loads, models)
    made.bars(made.out / "naumann_vector.svg")
    lines = made.table()
    if bench.some:
        lines += made.ablation(len(bench.some))
    return lines + ["", *(f"- {note}" for note in made.notes)]
