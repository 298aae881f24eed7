# SPDX-License-Identifier: GPL-3.0-or-later
"""Document 003, Naumann et al. (2023): training campaign, both validations, and an ablation of the composite model.

Trained on tables of the nominal model at 27 poses and three tilts, with noise as of a measurement: steady states with
the machine off (module 1), nine ambient cycles (module 2), single axes and combinations (module 3). Judged between the
poses at the check points of a perturbed machine. The print's figure is of the error vector at each place.
"""
import json
import math
import statistics
import subprocess
from pathlib import Path

from published import chart
from published.records import Record

TOOLS = Path(__file__).resolve().parent.parent
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


def spread(values):
    known = [value for value in values if value is not None]
    if not known:
        return "-"
    return f"{statistics.median(known):.0f} ({min(known):.0f} to {max(known):.0f})"


def figures(rows, model, places):
    """Cells of the vector and of each direction: median over the places, least and most."""
    vector = [removed(rows, model, [f"{d}@check{p}" for d in DIRECTIONS]) for p in places]
    return [spread(vector), *(spread([removed(rows, model, [f"{d}@check{p}"]) for p in places]) for d in DIRECTIONS)]


class Training:
    """Measurement folders of the campaign's tables, by sides and load programs; made once."""

    def __init__(self, bench, inputs):
        self.bench, self.inputs, self.made = bench, inputs, {}
        self.out = bench.options.out / "003"

    def folder(self, sides, loads):
        key = (sides, tuple(loads))
        if key not in self.made:
            if not self.made:
                self.bench.run("campaign", self.bench.options.case, "--reduced", "--model", self.bench.model,
                               "--all-tilts", "--load", *ALL, "--out", self.out, "--quiet")
            folder = self.out / f"training_{len(self.made)}"
            subprocess.run([str(TOOLS / "programs_measurement"), str(self.out / "campaign_reduced"), str(folder),
                            *loads, "--poses", "1", "--held", *(["--sides"] if sides else [])],
                           check=True, capture_output=True)
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


def judge(bench, test):
    """Page of the document. @param test  of documents.py, whose judge is not used: both validations are judged"""
    out, run = bench.options.out / "003", bench.run
    lines, cells, notes = [], {}, []
    judged = {}
    for name in VALIDATIONS:
        test.judge, test.train = name, []
        case, sources = bench.measure(test)
        record = Record(sources[name])
        record.rename_displacements(lambda channel: channel.replace("@", "@check"))
        judged[name] = (case, record.write(out / "judged" / name, name))
    any_record = Record(next(iter(judged.values()))[1])
    training = Training(bench, {c["id"] for c in any_record.channels})
    check = [c["id"] for c in any_record.channels if c["kind"] == "displacement"]
    places = sorted({int(channel.split("@check")[1]) for channel in check})
    for name in VALIDATIONS:
        case, record = judged[name]
        groups = dict.fromkeys((sides, tuple(loads)) for _, _, sides, loads in ABLATION)
        for sides, loads in groups:
            models = [m for _, m, s, own in ABLATION if s == sides and tuple(own) == loads]
            folder = out / name / f"{'sides' if sides else 'whole'}_{len(loads)}"
            extra = [STATIC] if STATIC not in models and sides and list(loads) == ALL else []
            answer = json.loads(run("evaluate", "--data", record, "--train-data", training.folder(sides, list(loads)),
                                    "--models", ",".join([*models, *extra]), "--check", ",".join(check), "--out",
                                    folder, "--quiet", "--json"))
            notes += [note for note in answer["notes"] if "left out" in note and note not in notes]
            rows = [row for row in answer.get("rows", []) if row["part"] == name]
            for model in models:
                cells[name, model, sides, loads] = figures(rows, model, places)
            if extra:
                pictures(folder, out, name, OURS, STATIC)
        twin = json.loads(run("evaluate", case, "--model", bench.model, "--data", record, "--train-programs", name,
                              "--models", "static_regression", "--out", out / name / "twin", "--quiet", "--json"))
        for model in ("reduced_model", "reduced_model_sensors"):
            cells[name, model] = figures([r for r in twin["rows"] if r["part"] == name], model, places)
    lines += ["| test | quantity | published | three modules | one fit of all modules | static regression | "
              "reduced model | with sensors |", "|---" * 8 + "|"]
    for name, published in VALIDATIONS.items():
        for i, quantity in enumerate(("error vector", *DIRECTIONS)):
            own = [cells[name, OURS, True, tuple(ALL)], cells[name, JOINT, False, tuple(ALL)],
                   cells[name, STATIC, False, tuple(ALL)], cells[name, "reduced_model"],
                   cells[name, "reduced_model_sensors"]]
            lines.append("| " + " | ".join([name, quantity, published if i == 0 else "-",
                                            *(of[i] for of in own)]) + " |")
    lines += ["", "Ablation: RMS removed, %, median over the places.", "",
              "| cause | " + " | ".join(f"{n} {q}" for n in VALIDATIONS for q in ("vector", "x", "y", "z")) + " |",
              "|---" * 9 + "|"]
    for cause, model, sides, loads in ABLATION:
        row = [cell.split(" ")[0] for name in VALIDATIONS for cell in cells[name, model, sides, tuple(loads)]]
        lines.append("| " + " | ".join([cause, *row]) + " |")
    return lines + ["", *(f"- {note}" for note in notes)]
