# SPDX-License-Identifier: GPL-3.0-or-later
"""Mareš et al. (2020) on cases/turnmill: set-ups of milling, drilling and turning, superposition, a second machine.

Each machine is the full model with other parameters, on a finer mesh, with another time scheme and noise. Transfer
functions of the ambient (eps_1) are fitted to the surroundings test alone, those of a spindle (eps_2) to what eps_1
leaves of its heating and cooling, and both are added (eq. 6); gamma_1 takes the main spindle's speed (eq. 7).
Directions are those of the document: X is vertical (dz of the model), Z along the spindle (dx), Y across (dy).
"""
import json
import os
import random
import shutil
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from published import chart
from published.measured_machine import (PROBE_UM, case_at, column, factor_of, fit_percent, perturbed, record, replaced,
                                        rows_of, settled, two_factors, zeroed)
from published.records import Record
from published.statistics_of import cell, median

POSES = {
    "milling": {"Z_mm": 0, "X_mm": 100, "B_deg": 0},
    "drilling": {"Z_mm": 600, "X_mm": -250, "B_deg": 90},
    "turning": {"Z_mm": 0, "X_mm": 0, "B_deg": 0},
    "counter": {"Z_mm": 1500, "X_mm": 100, "B_deg": 0},
}
PROGRAMS = {
    "milling": ["surroundings", "milling_1400", "milling_spectrum"],
    "drilling": ["surroundings", "milling_1400", "drilling_spectrum"],
    "turning": ["surroundings", "turning_1000", "turning_spectrum"],
    "counter": ["counter_spectrum"],
    "second": ["second_spectrum"],
}
DIRECTIONS = {"X": "dz@1", "Y": "dy@1", "Z": "dx@1"}
AMBIENT, DIFFERENCE, SPEED = "T_s", "dT_S", "axis.C.feed_deg_min"
PROBES_MM = (50.0, 150.0)   # places on the mandrel in the main spindle, X1 and X2: 100 mm apart (eq. 1)
TURNING = "rb@1"
SECOND = 1000               # added to a seed: the second machine
SECOND_SPREAD = 2.0         # of its parameters: other assembly and wear
FACTOR_HOURS = 6.5          # the first spectrum, from which the correction factor is taken
SUM = "eps_1 + eps_2"

# set-up, direction, figure in print (fit, %; section 5.2: reduction), sensor of the spindle
ROWS = [
    ("milling", "X", "71"), ("drilling", "Z", "77"), ("turning", "angle", "68"), ("drilling", "X", "10"),
    ("drilling", "Y", "74"), ("turning", "X", "53"), ("turning", "Y", "60"), ("turning", "Z", "74"),
    ("second machine, as it is", "X", "-"), ("second machine, one factor", "X", "85 (factor 0.7)"),
    ("counter spindle", "X", "80"),
]


def of_counter_spindle(text):
    """machine.toml with the workpiece in the counter spindle."""
    text = replaced(text, r"^kinematic_chain = [^\n]*", 'kinematic_chain = "V [w b Z X Y B (C1) t]"', "machine.toml")
    text = replaced(text, r'^table_body = "main_spindle"', 'table_body = "counter_spindle"', "machine.toml")
    text = replaced(text, r'^table_surface = "main_spindle.face"', 'table_surface = "counter_spindle.face"',
                    "machine.toml")
    return replaced(text, r"^table_point_mm = \[0, 0, 0\]", "table_point_mm = [2100, 0, 0]", "machine.toml")


def counter_case(case, folder):
    """The case with the workpiece in the counter spindle, and the workspace before it; what trains and is held out."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("loads", "cad"):
        if not (folder / name).exists():
            os.symlink((Path(case) / name).resolve(), folder / name)
    text = of_counter_spindle((Path(case) / "machine.toml").read_text())
    (folder / "machine.toml").write_text(replaced(text, r"^Z_mm = [^\n]*", "Z_mm = [900, 1200, 1500]", "machine.toml"))
    (folder / "case.toml").write_text('schema = 1\nsize = "coarse"\ntrain = ["ambient_11", "ambient_31", '
                                      '"milling_6500", "z_rapid", "x_rapid", "y_rapid"]\n'
                                      'holdout = ["counter_spectrum"]\n')
    return folder


def made_models(run, case, out, main=None, counter=None):
    """Paths of both reduced models; those that are not given are made once (minutes)."""
    models = {"main": main, "counter": counter}
    for name, made in (("main", lambda: case), ("counter", lambda: counter_case(case, out / "counter_case"))):
        if models[name]:
            continue
        models[name] = out / f"reduced_{name}" / "model.rom.h5"
        if not models[name].exists():
            run("reduce", made(), "--out", models[name].parent, "--quiet")
    return models


def changes(setup, text):
    return of_counter_spindle(text) if setup == "counter" else text


class Machine:
    """Records of one perturbed machine in the set-ups that are asked for."""

    def __init__(self, run, case, out, seed, size, spread=1.0):
        self.run, self.case, self.out, self.seed, self.size, self.spread = run, case, Path(out), seed, size, spread
        self.name = tomllib.loads((Path(case) / "machine.toml").read_text())["name"]

    def record(self, setup, load, key=None):
        """Measurement folder; measured once. @param key  of PROGRAMS, which are run together"""
        key = key or setup
        folder = self.out / key
        if not (folder / "done").exists():
            def change(text):
                return changes(setup, perturbed(text, self.seed, self.spread))
            own = case_at(self.case, folder / "case", POSES[setup], PROGRAMS[key], change)
            self.run("campaign", own, "--size", self.size, "--out", folder, "--quiet", "--threads", 1)
            for name in PROGRAMS[key]:
                whole = folder / "records" / name / "whole"
                errors = record(folder / "campaign", name, whole, self.seed, self.name)
                if setup == "turning":
                    two_probes(self.run, whole, errors, f"mandrel {self.seed} {name}")
                settled(whole, folder / "records" / name)
            (folder / "done").touch()
        return folder / "records" / load


def two_probes(run, folder, errors, seed):
    """Readings of X1 and X2, from which `measure analyse` computes the angle; it joins the record as rb@1.

    @param errors  quantity: values of the tool against the workpiece at the tool point, um and um/m
    """
    noise = random.Random(seed)
    mandrel = folder / "mandrel"
    mandrel.mkdir(exist_ok=True)
    tool_x = POSES["turning"]["Z_mm"] + 300.0   # mm, of the tool point at home and by Z
    text = 'schema = 1\nmandrel = "table"\nquantities = ["dz", "rb"]\npoint_mm = [100, 0, 0]\nreference = "absolute"\n'
    for name, place in zip(("X1", "X2"), PROBES_MM):
        text += (f'[[probe]]\nid = "{name}"\nat_mm = [{place}, 0, 0]\ndirection = [0, 0, 1]\nstd_um = {PROBE_UM}\n'
                 "place_std_mm = 0.1\n")
    (mandrel / "mandrel.toml").write_text(text)
    times = [row["time_s"] for row in rows_of(folder / "data.csv")]
    with open(mandrel / "readings.csv", "w") as file:
        file.write("time_s,X1_um,X2_um\n")
        for time, dz, rb in zip(times, errors["dz"], errors["rb"]):
            # Tool against workpiece at a place x along the mandrel: dz - rb (x - x_tool); the mandrel moves against it.
            readings = [-(dz - 1e-3 * rb * (place - tool_x)) + noise.gauss(0.0, PROBE_UM) for place in PROBES_MM]
            file.write(f"{time},{readings[0]:.6g},{readings[1]:.6g}\n")
    run("measure", "analyse", mandrel, "--out", mandrel / "errors", "--quiet")
    angles = [row["rb_um_per_m"] for row in rows_of(mandrel / "errors" / "displacements.csv")]
    joined = Record(folder)
    for row, angle in zip(joined.rows, angles):
        row[TURNING] = angle
    channel = dict(next(c for c in joined.channels if c["kind"] == "displacement"))
    channel.update(id=TURNING, quantity="rb", unit="um/m", uncertainty=round(10 * 2 ** 0.5 * PROBE_UM, 3))
    joined.channels.append(channel)
    joined.write(folder)


def prepared(source, folder, inputs, displacements, sensor, less=None):
    """A record as the document's models see it.

    @param inputs  of AMBIENT, DIFFERENCE and SPEED  @param less  channel: values to take off
    """
    own = Record(source)
    if DIFFERENCE in inputs:
        own.add_difference(DIFFERENCE, sensor, "air.T_C")
    if SPEED not in inputs:
        own.rename_ambient(AMBIENT)
    own.keep_inputs(inputs)
    own.keep_displacements(lambda channel: channel["id"] in displacements)
    for channel, values in (less or {}).items():
        for row, value in zip(own.rows, values):
            if row[channel] not in ("", "nan"):
                row[channel] = f"{float(row[channel]) - value:.6g}"
    return own.write(folder, Path(source).name)


class Superposition:
    """eps_1 on one record, then eps_2 on what it leaves of another; their sum predicts."""

    def __init__(self, run, out, ambient, internal, sensor):
        self.run, self.out, self.sensor = run, Path(out), sensor
        channels = list(DIRECTIONS.values())
        first = prepared(ambient, self.out / "ambient", [AMBIENT], channels, sensor)
        self.first = self.fitted(first, "eps_1")
        left = self.part("eps_1", internal, [AMBIENT])
        self.second = self.fitted(prepared(internal, self.out / "internal", [DIFFERENCE], channels, sensor, left),
                                  "eps_2")

    def fitted(self, folder, name):
        """@return the summary of evaluate; every row trains"""
        return evaluated(self.run, folder, ["output_error"], self.out / name)

    def part(self, name, source, inputs):
        """Channel: contribution of eps_1 or eps_2 to a record, 0 at its first row."""
        return predicted(self.run, source, self.out / name, inputs, list(DIRECTIONS.values()), self.sensor,
                         "output_error")

    def predict(self, source):
        parts = [self.part("eps_1", source, [AMBIENT]), self.part("eps_2", source, [DIFFERENCE])]
        return {channel: [sum(pair) for pair in zip(*(part[channel] for part in parts))]
                for channel in parts[0].keys() & parts[1].keys()}


def evaluated(run, folder, models, out, training=None):
    """@param training  folders; none: all rows of the folder train"""
    how = ["--train-data", ",".join(map(str, training))] if training else ["--train-programs",
                                                                           Record(folder).programs[0]["name"]]
    return json.loads(run("evaluate", "--data", folder, *how, "--models", ",".join(models), "--out", out, "--quiet",
                          "--json"))


def predicted(run, source, fit, inputs, channels, sensor, model):
    """Channel: what the models saved in a folder of evaluate predict for a record, 0 at its first row."""
    folder = fit / f"of_{Path(source).parent.parent.name}_{Path(source).name}"
    data = prepared(source, folder / "data", inputs, channels, sensor)
    run("evaluate", "--data", data, "--fitted", fit / "evaluation/models.toml", "--out", folder, "--quiet", "--json")
    rows = rows_of(folder / "evaluation/predictions.csv")
    return {channel: zeroed([float(row[f"{channel}_{model}_as_is"]) for row in rows])
            for channel in channels if f"{channel}_{model}_as_is" in rows[0]}


def static_fits(run, out, judged, training, inputs, channels, sensor, model="static_regression"):
    """Channel: fit of a static regression, or another model, on the same records and inputs."""
    folders = [prepared(source, out / f"train_{Path(source).name}", inputs, channels, sensor) for source in training]
    data = prepared(judged, out / "judged", inputs, channels, sensor)
    answer = evaluated(run, data, [model], out, folders)
    return {row["channel"]: row["fit"] for row in answer["rows"]
            if row["part"] == Path(judged).name and row["model"] == model}


def twin_values(run, out, model, judged):
    """(key, channel): what the reduced model predicts without and with sensors, 0 at the first row of the test.

    It runs through the record as a whole and sees none of the training records.
    """
    run("evaluate", "--model", model, "--data", Path(judged) / "whole", "--train-programs", Path(judged).name,
        "--models", "static_regression", "--out", out, "--quiet", "--json")
    count = len(rows_of(Path(judged) / "data.csv"))
    rows = rows_of(out / "evaluation/predictions.csv")[-count:]
    return {(key, channel): zeroed([float(row[f"{channel}_{name}"]) for row in rows])
            for key, name in (("reduced", "reduced_model"), ("sensors", "reduced_model_sensors"))
            for channel in [*DIRECTIONS.values(), TURNING] if f"{channel}_{name}" in rows[0]}


def twin_fits(run, out, model, judged):
    """(key, channel): fit of these predictions, %."""
    return {(key, channel): fit_percent(column(judged, channel), values)
            for (key, channel), values in twin_values(run, out, model, judged).items()}


class Judged:
    """Fits in % of one seed: (set-up, direction) -> model -> value; what the models are; traces for pictures."""

    def __init__(self, run, case, models, out, seed, size):
        self.run, self.models, self.out, self.seed = run, models, Path(out), seed
        self.machine = Machine(run, case, self.out / "machine", seed, size)
        self.second = Machine(run, case, self.out / "second_machine", seed + SECOND, size, SECOND_SPREAD)
        self.cells, self.factors, self.steps, self.ablations = {}, {}, [], {}

    def put(self, setup, direction, **values):
        self.cells.setdefault((setup, direction), {}).update(values)

    def judge(self):
        milling = self.superposed("milling", "T2")
        drilling = self.superposed("drilling", "T2")
        turning = self.superposed("turning", "T1")
        self.linear("milling", "milling_spectrum", {"X": (milling, "dz@1")}, "T2")
        # One model for the head in milling and drilling (section 3): its axis is the model's z, then x.
        self.linear("drilling", "drilling_spectrum", {"Z": (milling, "dz@1"), "X": (drilling, "dz@1"),
                                                      "Y": (drilling, "dy@1")}, "T2")
        self.drilled_alone(milling, drilling)
        self.linear("turning", "turning_spectrum", {d: (turning, DIRECTIONS[d]) for d in "XYZ"}, "T1")
        self.angle()
        self.counter(milling)
        self.transfer(milling)
        self.steps += [("eps_1", milling.first), ("eps_2", milling.second)]
        return self

    def superposed(self, setup, sensor):
        ambient, internal, _ = (self.machine.record(setup, load) for load in PROGRAMS[setup])
        return Superposition(self.run, self.out / "fits" / setup, ambient, internal, sensor)

    def linear(self, setup, load, models, sensor):
        """@param models  direction: (superposition, the channel that it was fitted to)"""
        source = self.machine.record(setup, load)
        training = [self.machine.record(setup, name) for name in PROGRAMS[setup][:2]]
        static = static_fits(self.run, self.out / "static" / setup, source, training, [AMBIENT, DIFFERENCE],
                             list(DIRECTIONS.values()), sensor)
        if setup == "turning":
            together = static_fits(self.run, self.out / "together" / setup, source, training, [AMBIENT, DIFFERENCE],
                                   [DIRECTIONS["Z"]], sensor, "output_error")
            self.ablations["turning Z", "both functions fitted together"] = together.get(DIRECTIONS["Z"])
        twin = twin_fits(self.run, self.out / "twin" / setup, self.models["main"], source)
        predictions = {}
        for direction, (model, fitted) in models.items():
            channel = DIRECTIONS[direction]
            if model not in predictions:
                predictions[model] = model.predict(source)
            self.put(setup, direction, ours=fit_percent(column(source, channel), predictions[model][fitted]),
                     quiet=fit_percent(column(source, channel, "truth.csv"), predictions[model][fitted]),
                     static=static.get(channel), reduced=twin.get(("reduced", channel)),
                     sensors=twin.get(("sensors", channel)))

    def drilled_alone(self, milling, drilling):
        """What the functions of milling cost in drilling: Z with eps_1, then both, calibrated there."""
        source = self.machine.record("drilling", "drilling_spectrum")
        measured, own = column(source, "dx@1"), drilling.part("eps_1", source, [AMBIENT])["dx@1"]
        for label, head in (("eps_1 calibrated in drilling", milling.part("eps_2", source, [DIFFERENCE])["dz@1"]),
                            ("eps_1 and eps_2 calibrated in drilling",
                             drilling.part("eps_2", source, [DIFFERENCE])["dx@1"])):
            self.ablations["drilling Z", label] = fit_percent(measured, [a + b for a, b in zip(own, head)])

    def angle(self):
        calibration, source = (self.machine.record("turning", load) for load in PROGRAMS["turning"][1:])
        fit = self.out / "fits" / "angle"
        data = prepared(calibration, fit / "internal", [SPEED], [TURNING], "T1")
        self.steps.append(("gamma_1", evaluated(self.run, data, ["output_error_activity"], fit)))
        values = predicted(self.run, source, fit, [SPEED], [TURNING], "T1", "output_error_activity")
        static = static_fits(self.run, self.out / "static" / "angle", source, [calibration], [AMBIENT, DIFFERENCE],
                             [TURNING], "T1")
        twin = twin_fits(self.run, self.out / "twin" / "angle", self.models["main"], source)
        self.put("turning", "angle", ours=fit_percent(column(source, TURNING), values[TURNING]),
                 quiet=fit_percent(column(source, TURNING, "truth.csv"), values[TURNING]),
                 static=static.get(TURNING), reduced=twin.get(("reduced", TURNING)),
                 sensors=twin.get(("sensors", TURNING)))
        self.angle_without_noise(calibration, source)
        self.angle_in_the_hall(calibration, source)

    def angle_without_noise(self, calibration, source):
        """With probes that have none, in calibration and judging."""
        noise = [a - b for a, b in zip(column(calibration, TURNING), column(calibration, TURNING, "truth.csv"))]
        fit = self.out / "fits" / "angle_quiet"
        evaluated(self.run, prepared(calibration, fit / "internal", [SPEED], [TURNING], "T1", {TURNING: noise}),
                  ["output_error_activity"], fit)
        values = predicted(self.run, source, fit, [SPEED], [TURNING], "T1", "output_error_activity")
        self.ablations["turning angle", "no probe noise, in calibration too"] = fit_percent(
            column(source, TURNING, "truth.csv"), values[TURNING])

    def angle_in_the_hall(self, calibration, source):
        """With a function of the ambient, which the document leaves out of the angle."""
        surroundings = self.machine.record("turning", "surroundings")
        hall = self.out / "fits" / "angle_hall"
        evaluated(self.run, prepared(surroundings, hall / "ambient", [AMBIENT], [TURNING], "T1"), ["output_error"],
                  hall / "eps_1")
        left = predicted(self.run, calibration, hall / "eps_1", [AMBIENT], [TURNING], "T1", "output_error")
        data = prepared(calibration, hall / "internal", [SPEED], [TURNING], "T1", left)
        evaluated(self.run, data, ["output_error_activity"], hall / "gamma_1")
        values = predicted(self.run, source, hall / "gamma_1", [SPEED], [TURNING], "T1", "output_error_activity")
        ambient = predicted(self.run, source, hall / "eps_1", [AMBIENT], [TURNING], "T1", "output_error")
        both = [a + b for a, b in zip(values[TURNING], ambient[TURNING])]
        self.ablations["turning angle", "no probe noise, and a function of the ambient"] = fit_percent(
            column(source, TURNING, "truth.csv"), both)

    def counter(self, milling):
        """The milling model, unchanged, at the counter spindle (section 5.3)."""
        source = self.machine.record("counter", "counter_spectrum")
        training = [self.machine.record("milling", name) for name in PROGRAMS["milling"][:2]]
        static = static_fits(self.run, self.out / "static" / "counter", source, training, [AMBIENT, DIFFERENCE],
                             ["dz@1"], "T2")
        twin = twin_fits(self.run, self.out / "twin" / "counter", self.models["counter"], source)
        sums = milling.predict(source)["dz@1"]
        self.scaled("counter spindle", milling, source)
        self.put("counter spindle", "X", ours=fit_percent(column(source, "dz@1"), sums),
                 quiet=fit_percent(column(source, "dz@1", "truth.csv"), sums),
                 static=static.get("dz@1"), reduced=twin.get(("reduced", "dz@1")),
                 sensors=twin.get(("sensors", "dz@1")))

    def scaled(self, row, milling, source):
        """What factors would do that are taken from the whole test and judged on it: one, and one a function."""
        measured, sums = column(source, "dz@1"), milling.predict(source)["dz@1"]
        one = factor_of(measured, sums)
        self.ablations[row, "one factor from the whole test, judged on it"] = fit_percent(
            measured, [one * value for value in sums])
        parts = [milling.part(*of)["dz@1"] for of in (("eps_1", source, [AMBIENT]), ("eps_2", source, [DIFFERENCE]))]
        factors = two_factors(measured, *parts)
        self.ablations[row, "a factor for eps_1 and one for eps_2, judged on the same test"] = fit_percent(
            measured, [factors[0] * a + factors[1] * b for a, b in zip(*parts)])

    def transfer(self, milling):
        """The first machine's model on a second one: as it is, and with one factor from its first spectrum."""
        source = self.second.record("milling", "second_spectrum", "second")
        hours = [float(row["time_s"]) / 3600.0 for row in rows_of(source / "data.csv")]
        truth = column(source, "dz@1", "truth.csv")
        measured, sums = column(source, "dz@1"), milling.predict(source)["dz@1"]
        early = [i for i, hour in enumerate(hours) if hour <= FACTOR_HOURS]
        late = [i for i, hour in enumerate(hours) if hour > FACTOR_HOURS]
        factor = factor_of([measured[i] for i in early], [sums[i] for i in early])

        def fit(values, scale, against=measured):
            return fit_percent([against[i] for i in late], [scale * values[i] for i in late])

        training = [self.machine.record("milling", name) for name in PROGRAMS["milling"][:2]]
        out = self.out / "static" / "second"
        static_fits(self.run, out, source, training, [AMBIENT, DIFFERENCE], ["dz@1"], "T2")
        static = [float(row["dz@1_static_regression"]) for row in rows_of(out / "evaluation/predictions.csv")]
        of_static = factor_of([measured[i] for i in early], [static[i] for i in early])
        twins = {key: values for (key, channel), values in twin_values(
            self.run, self.out / "twin" / "second", self.models["main"], source).items() if channel == "dz@1"}
        for setup, corrected in (("second machine, as it is", False), ("second machine, one factor", True)):
            scales = {key: factor_of([measured[i] for i in early], [values[i] for i in early]) if corrected else 1.0
                      for key, values in twins.items()}
            self.put(setup, "X", ours=fit(sums, factor if corrected else 1.0),
                     quiet=fit(sums, factor if corrected else 1.0, truth),
                     static=fit(static, of_static if corrected else 1.0),
                     **{key: fit(values, scales[key]) for key, values in twins.items()})
        self.scaled("second machine, one factor", milling, source)
        self.factors = {"ours": factor, "static": of_static}


def table(all_seeds):
    lines = ["| set-up | direction | published | ours | ours, no probe noise | static regression | reduced model | "
             "with sensors |", "|---" * 8 + "|"]
    for setup, direction, published in ROWS:
        found = [seed.cells[setup, direction] for seed in all_seeds]
        cells = [cell([one.get(key) for one in found]) for key in ("ours", "quiet", "static", "reduced",
                                                                                "sensors")]
        lines.append("| " + " | ".join([setup, direction, published, *cells]) + " |")
    return lines


def bars(all_seeds, path):
    """Fit of each row: in print, ours, a static regression, the reduced model; medians of the machines."""
    groups = []
    for setup, direction, published in ROWS:
        found = [seed.cells[setup, direction] for seed in all_seeds]
        values = [("print", float(published.split()[0]) if published != "-" else None)]
        values += [(label, median([one.get(key) for one in found])) for label, key in
                   (("ours", "ours"), ("static regression", "static"), ("reduced model", "reduced"))]
        groups.append((f"{setup} {direction}", values))
    chart.write_bars(path, "Fit of each test: print and ours", groups, "fit, %")


def stability(all_seeds):
    """Lines about the step responses of the functions that the document draws (Figs. 6, 8 and 10)."""
    lines = ["| function | of | stable | largest pole | settles at | unit | 95 % after, h |", "|---" * 7 + "|"]
    names = {"eps_1": ("dz@1", "um/K"), "eps_2": ("dz@1", "um/K"), "gamma_1": (TURNING, "(um/m)/1000 rpm")}
    for function, (channel, unit) in names.items():
        found = [step for seed in all_seeds for name, summary in seed.steps if name == function
                 for step in summary["step_responses"] if step["channel"] == channel]
        scale = 360000.0 if function == "gamma_1" else 1.0
        stable = sum(step["stable"] for step in found)
        lines.append(f"| {function} | {found[0]['input']} | {stable} of {len(found)} | "
                     f"{max(step['largest_pole'] for step in found):.4f} | "
                     f"{cell([scale * step['end'] for step in found], 1)} | {unit} | "
                     f"{cell([step['settling_h'] for step in found], 1)} |")
    return lines


def judge(run, case, models, out, seeds, size, workers=2):
    """Lines of Markdown. @param models  reduced models: {"main": path, "counter": path or None}; None: made here"""
    out = Path(out)
    models = made_models(run, case, out, **models)
    with ThreadPoolExecutor(workers) as pool:
        found = list(pool.map(lambda seed: Judged(run, case, models, out / f"seed_{seed}", seed, size).judge(), seeds))
    first = out / f"seed_{seeds[0]}" / "fits"
    for name, folder, model in (("ambient", first / "milling" / "eps_1", "output_error"),
                                ("milling_head", first / "milling" / "eps_2", "output_error"),
                                ("main_spindle", first / "angle", "output_error_activity")):
        shutil.copy(folder / "evaluation" / f"step_response_{model}.svg", out / f"step_response_{name}.svg")
    factors = cell([seed.factors["ours"] for seed in found], 2)
    lines = [f"Fit, % (eq. 4); {len(seeds)} pairs of machines: median (quartiles).", "", *table(found), "",
             f"Correction factor of the second machine: {factors}; 0.7 in print.", "", *stability(found), "",
             "| row | with one change | fit, % |", "|---|---|---|"]
    for row, change in found[0].ablations:
        lines.append(f"| {row} | {change} | {cell([one.ablations[row, change] for one in found])} |")
    lines.append("")
    bars(found, out / "mares_2020_fit.svg")
    (out / "cells.json").write_text(json.dumps(
        [{"seed": seed.seed, "factor": seed.factors, "cells": {f"{s}: {d}": value for (s, d), value in
                                                               seed.cells.items()}} for seed in found], indent=1))
    return lines
