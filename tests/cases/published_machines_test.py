#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured machines and superposed transfer functions of `tools/published_tests 002`, by the built program.

usage: published_machines_test.py THERMOTWIN
"""
import csv
import math
import random
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from published import measured_machine, turning_milling  # noqa: E402
from published.records import MissingColumn, Record  # noqa: E402

PROGRAM = sys.argv.pop(1)
CASE = ROOT / "cases/turnmill"


def run(*arguments):
    result = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    if result.returncode != 0:
        raise AssertionError(f"{arguments}\n{result.stderr}")
    return result.stdout


def write_campaign(folder, load, hours, air, internal, errors):
    """Tables as of a campaign, a row each ten minutes. @param air, internal  degC over h  @param errors  of the row"""
    (folder / load).mkdir(parents=True)
    rows = [600.0 * i for i in range(int(6 * hours) + 1)]
    poses = {"Z_mm": 0, "X_mm": 0, "B_deg": 0}
    tables = {"tcp": [], "sensors": [], "inputs": []}
    for i, time in enumerate(rows):
        hour = time / 3600.0
        tables["tcp"].append({"time_s": time, **poses, **errors(i, hour)})
        tables["sensors"].append({"time_s": time, "T1_C": internal(hour), "T2_C": internal(hour)})
        tables["inputs"].append({"time_s": time, "air.T_C": air(hour), "axis.C.feed_deg_min": 0.0})
    for name, table in tables.items():
        with open(folder / load / f"{name}.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, table[0])
            writer.writeheader()
            writer.writerows(table)


class Lagged:
    """dz = 5 um/K of the air, behind 3 h, and -4 um/K of the spindle against the air, behind 1 h."""

    def __init__(self, air, internal):
        self.air, self.internal, self.slow, self.fast = air, internal, 0.0, 0.0

    def __call__(self, i, hour):
        air = self.air(hour) - self.air(0.0)
        own = self.internal(hour) - self.air(hour)
        if i > 0:
            self.slow += (air - self.slow) * (1.0 - math.exp(-1.0 / 18.0))
            self.fast += (own - self.fast) * (1.0 - math.exp(-1.0 / 6.0))
        dz = 5.0 * self.slow - 4.0 * self.fast
        return {"dx_um": 0.5 * dz, "dy_um": -dz, "dz_um": dz, "rb_um_per_m": 0.0, "dz_um_tool": 99.0}


class MeasuredMachines(unittest.TestCase):
    def test_parameters_are_drawn_within_their_uncertainty(self):
        nominal = (CASE / "machine.toml").read_text()
        pattern = re.compile(r"(\w+) = \{value = ([-+.\de]+), std_percent = ([\d.]+)\}")
        before = pattern.findall(nominal)
        after = pattern.findall(measured_machine.perturbed(nominal, 31))
        self.assertEqual(len(before), len(after))
        self.assertGreater(len(before), 80)
        moved = 0
        for (key, value, percent), (_, other, same) in zip(before, after):
            self.assertEqual(percent, same)
            share = float(other) / float(value) - 1.0
            if key == "default_C":
                self.assertEqual(value, other)
                continue
            self.assertLessEqual(abs(share), 2.5 * float(percent) / 100.0 + 1e-6, key)
            moved += abs(share) > 0.0
        self.assertGreater(moved, len(before) - 5)
        self.assertEqual(measured_machine.perturbed(nominal, 31), measured_machine.perturbed(nominal, 31))
        self.assertNotEqual(measured_machine.perturbed(nominal, 31), measured_machine.perturbed(nominal, 32))

    def test_a_set_up_stands_at_its_pose(self):
        with tempfile.TemporaryDirectory() as folder:
            case = measured_machine.case_at(CASE, Path(folder) / "case", turning_milling.POSES["counter"],
                                            ["counter_spectrum"], turning_milling.of_counter_spindle)
            machine = tomllib.loads((case / "machine.toml").read_text())
            self.assertEqual(machine["workspace"], {"Z_mm": [1500], "X_mm": [100], "B_deg": [0]})
            self.assertEqual(machine["tcp"]["table_body"], "counter_spindle")
            program = tomllib.loads((case / "loads/counter_spectrum.toml").read_text())
            self.assertEqual(program["position"], turning_milling.POSES["counter"])
            self.assertEqual(program["phase"][0]["duration_h"], measured_machine.SETTLING_H)
            self.assertEqual(program["phase"][1]["name"], "1200 rpm")
            self.assertEqual(tomllib.loads((case / "case.toml").read_text())["time"]["scheme"], "adaptive")
            said = run("mesh", case, "--size", 2, "--out", Path(folder) / "mesh", "--json")
            self.assertIn("counter_spindle", said)

    def test_a_test_begins_when_the_machine_has_settled(self):
        with tempfile.TemporaryDirectory() as folder:
            whole, own = Path(folder) / "test" / "whole", Path(folder) / "test"
            write_campaign(Path(folder) / "campaign", "test", 30, lambda h: 21.0, lambda h: 22.0,
                           lambda i, h: {"dx_um": 0.0, "dy_um": 0.0, "dz_um": 2.0 * h, "rb_um_per_m": -h})
            measured_machine.record(Path(folder) / "campaign", "test", whole, 1, "lathe")
            measured_machine.settled(whole, own, 24)
            times = measured_machine.column(own, "time_s")
            self.assertEqual((times[0], times[-1], len(times)), (0.0, 21600.0, 37))
            self.assertAlmostEqual(measured_machine.column(own, "dz@1")[-1], 12.0, delta=1.5)
            truth = [measured_machine.column(own, name, "truth.csv") for name in ("dz@1", "rb@1")]
            self.assertEqual((truth[0][0], truth[0][-1], truth[1][-1]), (0.0, 12.0, -6.0))
            self.assertEqual(len(measured_machine.column(whole, "time_s")), 181)
            (program,) = Record(whole).programs
            self.assertEqual((program["name"], program["from_s"]), ("test", 86400.0))

    def test_other_text_is_refused_with_the_place(self):
        with self.assertRaisesRegex(SystemExit, "machine.toml: .* found 0 times; allowed: once"):
            turning_milling.of_counter_spindle("schema = 1\n")


class Turning(unittest.TestCase):
    def test_the_angle_comes_from_two_probes(self):
        with tempfile.TemporaryDirectory() as folder:
            campaign, record = Path(folder) / "campaign", Path(folder) / "turning_1000"
            write_campaign(campaign, "turning_1000", 40, lambda h: 21.0, lambda h: 25.0,
                           lambda i, h: {"dx_um": 0.0, "dy_um": 0.0, "dz_um": 7.0 * (i > 0),
                                         "rb_um_per_m": 30.0 * (i > 0)})
            errors = measured_machine.record(campaign, "turning_1000", record, 1, "lathe")
            turning_milling.two_probes(run, record, errors, "seed")
            angles = measured_machine.column(record, turning_milling.TURNING)[1:]
            mean = sum(angles) / len(angles)
            spread = math.sqrt(sum((a - mean) ** 2 for a in angles) / len(angles))
            # Two readings of 0.3 um over 0.1 m: 4.24 um/m a row, 0.27 um/m for the mean of 240.
            self.assertAlmostEqual(mean, 30.0, delta=1.1)
            self.assertAlmostEqual(spread, 4.24, delta=0.6)
            (channel,) = [c for c in Record(record).channels if c["id"] == turning_milling.TURNING]
            self.assertEqual((channel["quantity"], channel["unit"]), ("rb", "um/m"))


class Superposed(unittest.TestCase):
    def test_functions_of_separate_tests_add_up(self):
        hall = {"surroundings": lambda h: 21.0 + 1.5 * math.sin(h / 4.0),
                "milling_1400": lambda h: 21.0 + 0.04 * h,
                "milling_spectrum": lambda h: 21.0 + math.sin(h / 5.0)}
        draw = random.Random(3)
        speeds = [draw.choice((0.0, 3.0, 6.0)) for _ in range(12)]

        def own(load, hour):
            if load == "surroundings":
                return 0.0
            if load == "milling_1400":
                return 5.0 if 0.0 < hour < 10.0 else 0.0
            return speeds[min(int(hour / 2.0), 11)] if hour > 0.0 else 0.0

        with tempfile.TemporaryDirectory() as folder:
            campaign, records = Path(folder) / "campaign", Path(folder) / "milling" / "records"
            for load, air in hall.items():
                def internal(hour, load=load, air=air):
                    return air(hour) + own(load, hour)
                write_campaign(campaign, load, 24, air, internal, Lagged(air, internal))
                measured_machine.record(campaign, load, records / load, 5, "lathe")
            made = turning_milling.Superposition(run, Path(folder) / "fits", records / "surroundings",
                                                 records / "milling_1400", "T2")
            (step,) = [s for s in made.first["step_responses"] if s["channel"] == "dz@1"]
            self.assertEqual(step["input"], turning_milling.AMBIENT)
            self.assertAlmostEqual(step["end"], 5.0, delta=0.5)
            self.assertTrue(step["stable"])
            (step,) = [s for s in made.second["step_responses"] if s["channel"] == "dz@1"]
            self.assertAlmostEqual(step["end"], -4.0, delta=0.4)
            self.assertAlmostEqual(step["settling_h"], 3.0, delta=1.0)
            judged = records / "milling_spectrum"
            measured = measured_machine.column(judged, "dz@1")
            both = measured_machine.fit_percent(measured, made.predict(judged)["dz@1"])
            alone = made.part("eps_2", judged, [turning_milling.DIFFERENCE])["dz@1"]
            self.assertGreater(both, 85.0)
            self.assertGreater(both, measured_machine.fit_percent(measured, alone) + 10.0)

    def test_one_factor_corrects_the_size(self):
        predicted = [math.sin(i / 9.0) for i in range(100)]
        measured = [0.7 * value for value in predicted]
        self.assertAlmostEqual(measured_machine.factor_of(measured, predicted), 0.7)
        self.assertAlmostEqual(measured_machine.fit_percent(measured, [0.7 * v for v in predicted]), 100.0)
        self.assertLess(measured_machine.fit_percent(measured, predicted), 60.0)
        other = [0.01 * i for i in range(100)]
        both = [0.7 * a - 2.0 * b for a, b in zip(predicted, other)]
        first, second = measured_machine.two_factors([None, *both], [1.0, *predicted], [1.0, *other])
        self.assertAlmostEqual(first, 0.7)
        self.assertAlmostEqual(second, -2.0)

    def test_a_missing_column_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            write_campaign(Path(folder), "milling_1400", 2, lambda h: 21.0, lambda h: 22.0,
                           lambda i, h: {"dx_um": 0.0, "dy_um": 0.0, "dz_um": 0.0})
            record = Path(folder) / "record"
            measured_machine.record(folder, "milling_1400", record, 1, "lathe")
            with self.assertRaisesRegex(MissingColumn, "data.csv: no column 'T9'; dT_S needs it"):
                turning_milling.prepared(record, Path(folder) / "own", [turning_milling.DIFFERENCE], ["dz@1"], "T9")


unittest.main()
