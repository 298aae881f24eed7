# SPDX-License-Identifier: GPL-3.0-or-later
"""Document 001, Tables 2 to 5: one transfer function of place 4, extended over the places by coefficients b_j.

A transfer function is calibrated at place 4 at the low speed. b_j is the mean over time of the ratio of the deformation
at place j to that at place 4, over the rows where the latter is at least a quarter of its largest value: near 0 a ratio
has noise only. Places 2 and 4 get b_j from the corners 1, 3, 5 and 6, bilinear in Y and Z.
"""
from published.measured_machine import fit_percent, rows_of, zeroed
from published.records import Record, value_of
from published.statistics_of import cell

TEST = "four times the speed"   # of documents.py: trained on LOW, judged on HIGH
LOW, HIGH, MODEL, AT = "settled_spindle_3000", "settled_spindle_12000", "output_error", 4
PLACES = range(1, 7)
CORNERS = {1: (1.0, 0.0), 3: (0.0, 0.0), 5: (1.0, 1.0), 6: (0.0, 1.0)}   # shares of the way in Y and Z
BETWEEN = {2: (0.5, 10.0 / 550.0), 4: (0.3, 0.7)}
PRINTED = {
    "b_j, low speed": [1.14, 1.14, 1.08, 1.0, 0.97, 0.9],
    "b_j, high speed": [1.06, 1.07, 1.06, 1.0, 0.93, 0.96],
    "low speed": {"fit, b_j": [92.7, 89.9, 93.9, 90.5, 90.4, 94.8],
                  "fit, one point": [65.5, 66.7, 77.9, 94.4, 83.3, 72.2],
                  "PK, b_j": [11.9, 12.6, 8.4, 8.3, 13.2, 8.7], "PK, one point": [18.1, 17.5, 13.1, 8.5, 16.8, 16.3]},
    "high speed": {"fit, b_j": [84.7, 81.5, 78.1, 68.8, 80.1, 63.0],
                   "fit, one point": [60.2, 59.7, 61.2, 74.5, 81.6, 79.9],
                   "PK, b_j": [12.6, 11.2, 11.2, 13.6, 13.1, 14.5],
                   "PK, one point": [12.4, 12.8, 12.6, 13.2, 16.0, 15.5]},
    "high speed, own b_j": {"fit, b_j": [74.2, 73.6, 75.2, 71.3, 73.3, 75.6]},
}


def deformations(folder):
    rows = rows_of(folder / "data.csv")
    return {place: zeroed([value_of(row[f"dz@{place}"]) for row in rows]) for place in PLACES}


def only_place(source, folder):
    record = Record(source)
    record.keep_displacements(lambda channel: channel["id"] == f"dz@{AT}")
    return record.write(folder)


def predicted(run, source, out, fitted=None):
    """@param fitted  models.toml; None: fitted to the record itself"""
    how = ["--fitted", fitted] if fitted else ["--models", MODEL]
    data = only_place(source, out / "data")
    run("evaluate", "--data", data, "--train-programs", Record(data).programs[0]["name"], *how, "--out", out, "--quiet")
    end = "_as_is" if fitted else ""
    return zeroed([value_of(row[f"dz@{AT}_{MODEL}{end}"]) for row in rows_of(out / "evaluation/predictions.csv")])


def ratio(own, reference):
    least = 0.25 * max(abs(value) for value in reference)
    ratios = [a / b for a, b in zip(own, reference) if abs(b) >= least]
    return sum(ratios) / len(ratios)


def interpolated(corners, y, z):
    return sum(corners[place] * (y if at[0] else 1.0 - y) * (z if at[1] else 1.0 - z) for place, at in CORNERS.items())


def coefficients(measured):
    """b_j of all places: as measured, and as the model uses them."""
    own = {place: ratio(measured[place], measured[AT]) for place in PLACES}
    return own, {place: interpolated(own, *BETWEEN[place]) if place in BETWEEN else own[place] for place in PLACES}


def pk_percent(measured, predicted_values):
    """Peak to peak of the residual over the largest deformation (eq. 3), %."""
    left = [m - p for m, p in zip(measured, predicted_values)]
    return 100.0 * (max(left) - min(left)) / max(abs(value) for value in measured)


def figures(measured, model, shares):
    """Of each place: fit and PK with b_j and without."""
    found = {}
    for place in PLACES:
        extended = [shares[place] * value for value in model]
        found[place] = {"fit, b_j": fit_percent(measured[place], extended),
                        "fit, one point": fit_percent(measured[place], model),
                        "PK, b_j": pk_percent(measured[place], extended),
                        "PK, one point": pk_percent(measured[place], model)}
    return found


def of_machine(run, folder):
    """@param folder  with the records of both speeds as the models see them"""
    measured = {load: deformations(folder / load) for load in (LOW, HIGH)}
    out = folder / "one_function"
    low = predicted(run, folder / LOW, out / "low")
    high = predicted(run, folder / HIGH, out / "high", out / "low/evaluation/models.toml")
    own, used = coefficients(measured[LOW])
    own_high, used_high = coefficients(measured[HIGH])
    return {"b_j, low speed": own, "b_j, high speed": own_high, "low speed": figures(measured[LOW], low, used),
            "high speed": figures(measured[HIGH], high, used),
            "high speed, own b_j": figures(measured[HIGH], high, used_high)}


def row(name, printed, values, digits):
    """@param values  for each place a list over the machines"""
    shown = [f"{printed[i]:g}: {cell(values[i], digits)}" for i in range(len(PLACES))]
    return "| " + " | ".join([name, *shown]) + " |"


def tables(bench, test):
    """Tables 2 to 5: of each place the print's figure, then ours. @param test  that has judged HIGH, trained on LOW"""
    found = [of_machine(bench.run, bench.folder(test, seed)) for seed in bench.seeds]
    lines = ["", "Tables 2 to 5, one transfer function of place 4: print, then ours. Fit in %, PK in % of the largest "
             "deformation.", "",
             "| figure | " + " | ".join(f"place {place}" for place in PLACES) + " |", "|---" * 7 + "|"]
    for name in ("b_j, low speed", "b_j, high speed"):
        lines.append(row(name, PRINTED[name], [[one[name][place] for one in found] for place in PLACES], 2))
    for test_name in ("low speed", "high speed", "high speed, own b_j"):
        for name, printed in PRINTED[test_name].items():
            lines.append(row(f"{test_name}: {name}", printed,
                             [[one[test_name][place][name] for one in found] for place in PLACES], 0))
    return "\n".join(lines) + "\n"
