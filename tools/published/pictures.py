# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of documents 000 and 001 with our records, in the axes of the print; its numbers beside ours."""
import csv
import math

from published import chart
from published.statistics_of import LEAST_UM, measured_by, median

# 000: what the tables print before and after compensation, um (Tables 6.3 and 6.4)
PRINTED_RANGES = {("A/C: A axis (Fig. 6.8)", "dx"): ("X0T", 17.0, 7.0),
                  ("A/C: A axis (Fig. 6.8)", "dz"): ("Z0A", 9.5, 5.5),
                  ("A/C: A and C (Fig. 6.13)", "dx"): ("X0C", 30.5, 16.0),
                  ("A/C: A and C (Fig. 6.13)", "dz"): ("Z0T", 90.1, 34.3)}
CURVES = {"A/C: A axis (Fig. 6.8)": ("gebhardt_a_cycle", "Figs. 6.10 and 6.11: A axis, 62 h"),
          "A/C: A and C (Fig. 6.13)": ("gebhardt_ac_cycle", "Figs. 6.15 and 6.16: A and C axis, 36 h"),
          "A/C: C axis (Figs. 5.18, 5.19)": ("gebhardt_c_cycle", "Fig. 5.22: C axis, 83 h")}
# 001: fit by sphere, %, of the extrapolated and of the standard transfer function (Tables 3 and 4)
PRINTED_FITS = {"calibration": ("okenka_3000", "Table 3: at the speed of the calibration",
                                [92.7, 89.9, 93.9, 90.5, 90.4, 94.8], [65.5, 66.7, 77.9, 94.4, 83.3, 72.2]),
                "four times the speed": ("okenka_12000", "Table 4: at four times the speed",
                                         [84.7, 81.5, 78.1, 68.8, 80.1, 63.0], [60.2, 59.7, 61.2, 74.5, 81.6, 79.9])}


def predictions(folder):
    """Columns of predictions.csv: name -> [(h from its first row, value)]."""
    with open(folder / "evaluation" / "predictions.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    first = float(rows[0]["time_s"])
    return {name: [((float(row["time_s"]) - first) / 3600,
                    float(row[name]) if row[name] not in ("", "nan") else math.nan) for row in rows]
            for name in rows[0] if name != "time_s"}


def rotary_curves(bench, test):
    """Error over time without and with compensation, at the first machine."""
    name, title = CURVES[test.name]
    columns = predictions(bench.folder(test, bench.seeds[0]))
    panels = []
    for quantity in test.quantities:
        measured, model = columns[f"{quantity}@1_measured"], columns.get(f"{quantity}@1_{test.models[0]}")
        if model is None:
            continue
        left = [(t, m - p) for (t, m), (_, p) in zip(measured, model)]
        error, before, after = PRINTED_RANGES.get((test.name, quantity), (None, None, None))
        words = f"; {error} in print: range {before:g} um without, {after:g} um with" if error else ""
        panels.append((quantity + words, [("without", measured), ("with", left)]))
    chart.write(bench.out / test.document / f"{name}.svg", title, panels, "time, h", "error, um")


def ranges(judged, path):
    """Ranges before and after in print beside ours, um: medians of the machines."""
    groups = []
    for test, result in judged:
        for (name, quantity), (error, before, after) in PRINTED_RANGES.items():
            if name != test.name or isinstance(result, str):
                continue
            found, _ = result

            def of(model, key, found=found, quantity=quantity):
                return median([row[key] for rows in found.values() for row in rows
                               if row["model"] == model and row["channel"] == f"{quantity}@1"])
            model = test.models[0]
            groups.append((f"{error}, ours {quantity}", [
                ("print: without", before), ("print: with", after), ("ours: without", of(model, "peak_to_peak_before")),
                (f"ours: {model}", of(model, "peak_to_peak")), ("ours: reduced model", of("reduced_model",
                                                                                          "peak_to_peak"))]))
    if groups:
        chart.write_bars(path, "Range of the error: A axis (left two), A and C axis (right two)", groups, "range, um")


def fits(test, found, path, title, extrapolated, standard):
    """Fit of each sphere, % : the print's model with b_j and without, and ours."""
    groups = []
    for place in range(1, 7):
        def of(model, place=place):
            return median([measured_by(row, "fit") for rows in found.values() for row in rows
                           if row["model"] == model and row["channel"] == f"dz@{place}"
                           and row["peak_to_peak_before"] > LEAST_UM])
        groups.append((f"{place}", [("print: with b_j", extrapolated[place - 1]),
                                    ("print: without b_j", standard[place - 1]), ("ours: one_point", of("one_point")),
                                    ("ours: transfer_grid", of("transfer_grid")),
                                    ("ours: reduced model", of("reduced_model"))]))
    chart.write_bars(path, f"{title}; spheres 1 to 6", groups, "fit, %")


def spindle_curves(bench, test, found):
    """Figs. 4 and 7: z over time at a control place, and at the best and the worst place of four times the speed."""
    columns = predictions(bench.folder(test, bench.seeds[0]))
    rows = [row for row in found[bench.seeds[0]] if row["model"] == "one_point" and row["fit"] is not None]
    if not rows:
        return
    rows.sort(key=lambda row: row["fit"])
    chosen = [("place 4", "dz@4")] if test.train == [test.judge] else [("best place", rows[-1]["channel"]),
                                                                        ("worst place", rows[0]["channel"])]
    panels = []
    for words, channel in chosen:
        measured, model = columns[f"{channel}_measured"], columns[f"{channel}_one_point"]
        left = [(t, m - p) for (t, m), (_, p) in zip(measured, model)]
        panels.append((f"{words}, {channel}", [("measured", measured), ("one_point", model), ("residual", left)]))
    number = "4" if test.train == [test.judge] else "7"
    chart.write(bench.out / "001" / f"okenka_fig_{number}.svg", f"Fig. {number}: Z deformation over time", panels,
                "time, h", "Z deformation, um")


def draw(document, judged, benches):
    for test, result in judged:
        if isinstance(result, str):
            continue
        bench = benches.of(test.second)
        if test.name in CURVES:
            rotary_curves(bench, test)
        if test.name in PRINTED_FITS:
            name, *printed = PRINTED_FITS[test.name]
            fits(test, result[0], bench.out / "001" / f"{name}.svg", *printed)
            spindle_curves(bench, test, result[0])
    if document == "000":
        ranges(judged, benches.of(True).out / "000" / "gebhardt_ranges.svg")
