#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""`tools/published_tests` on small records, with a program that stands in for thermotwin: which records a document's
models get, how their rows become figures, and records that lack a column.
"""
import dataclasses
import math
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path
from types import SimpleNamespace

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from published import mares_2019, naumann, okenka, rotary  # noqa: E402
from published.documents import MEASURES, TESTS, TITLES  # noqa: E402
from published.records import MissingColumn, Record, holding_power  # noqa: E402
from published.statistics_of import cell  # noqa: E402

# Stands in for the program: records of an hour with all sensors of vmc5 but $LACKS; each model leaves a quarter of the
# error, the reduced model a tenth; of machine 32 less.
PROGRAM = '''#!/usr/bin/env python3
import json, os, sys, tomllib
from pathlib import Path
words = sys.argv[1:]
def option(name):
    rest = words[words.index(name) + 1:]
    return rest[:next((i for i, w in enumerate(rest) if str(w).startswith("--")), len(rest))]
def channel(text, id, kind, unit, more=""):
    return text + f'[[channel]]\\\\nid = "{id}"\\\\nkind = "{kind}"\\\\nunit = "{unit}"\\\\n{more}'
def measured(folder, load, hours):
    folder.mkdir(parents=True, exist_ok=True)
    sensors = [f"T{i}" for i in range(1, 10) if f"T{i}" not in os.environ.get("LACKS", "").split(",")]
    places = [f"{q}@{i}" for i in range(1, 21) for q in ("dx", "dy", "dz")]
    text = channel('[record]\\nmachine = "vmc5"\\n', "air.T_C", "temperature", "degC", 'input = "air.T_C"\\\\n')
    for name in sensors: text = channel(text, name, "temperature", "degC")
    for name in places: text = channel(text, name, "displacement", "um", f'quantity = "{name[:2]}"\\\\n')
    (folder / "channels.toml").write_text(text)
    rows = [["time_s", "air.T_C", *sensors, *places]]
    for i in range(hours + 1):
        rows.append([3600 * i, 21, *(21 + i for _ in sensors), *(i for _ in places)])
    (folder / "data.csv").write_text("".join(",".join(map(str, row)) + "\\\\n" for row in rows))
if words[0] == "validate":
    assert Path(option("--truth")[0]).name == "finer.rom.h5"
    for load in option("--load"):
        for k in range(int(option("--draws")[0])):
            seed = int(option("--first-seed")[0]) + k
            measured(Path(option("--out")[0]) / "measured/reduced" / load / f"machine_{seed}", load, 60)
elif words[0] == "evaluate":
    data, out = Path(option("--data")[0]), Path(option("--out")[0])
    described = tomllib.loads((data / "channels.toml").read_text())
    displacements = [c["id"] for c in described["channel"] if c["kind"] == "displacement"]
    models = option("--models")[0].split(",") if "--models" in words else ["output_error_as_is"]
    models += ["reduced_model", "reduced_model_sensors"] if "--model" in words else []
    assert described["record"]["machine"] == "vmc5"
    part = described["program"][-1]["name"]
    less = 10 if "32" in str(out) else 0
    rows = [{"part": part, "channel": c, "model": m, "rms_before": 8.0, "peak_to_peak_before": 8.0,
             "rms": 0.8 if m.startswith("reduced") else 2.0, "peak_to_peak": 0.8 if m.startswith("reduced") else 2.0,
             "rms_reduction_percent": 90 if m.startswith("reduced") else 75, "fit": 70 - less,
             "peak_to_peak_reduction_percent": 75} for m in models for c in displacements]
    (out / "evaluation").mkdir(parents=True, exist_ok=True)
    head = ["time_s", *(f"{c}_measured" for c in displacements), *(f"{c}_{m}" for m in models for c in displacements)]
    (out / "evaluation/predictions.csv").write_text(",".join(head) + "\\\\n" + ",".join("0" for _ in head) + "\\\\n" +
                                                    ",".join("1" for _ in head) + "\\\\n")
    print(json.dumps({"rows": rows, "notes": []}))
'''.replace("\\\\n", "\\n")


class Documents(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.out = Path(self.folder.name)
        (self.out / "thermotwin").write_text(PROGRAM)
        (self.out / "thermotwin").chmod(0o755)
        for name in ("model.rom.h5", "finer.rom.h5"):
            (self.out / name).write_text("")

    def tearDown(self):
        self.folder.cleanup()

    def published(self, *words, lacks="", machines=1):
        return subprocess.run([sys.executable, str(ROOT / "tools/published_tests"), *words, "--model",
                               str(self.out / "model.rom.h5"), "--truth", str(self.out / "finer.rom.h5"), "--machines",
                               str(machines), "--out", str(self.out / "out")], capture_output=True, text=True,
                              env={**os.environ, "THERMOTWIN_BUILD": str(self.out), "LACKS": lacks})

    def page(self, document):
        return (self.out / f"out/{document}.md").read_text()

    def test_figures_are_those_of_the_rows(self):
        made = self.published("001", "004", "--ablation", "1")
        self.assertEqual(made.returncode, 0, made.stderr)
        rows = [line for line in self.page("001").splitlines() if "four times the speed" in line]
        self.assertEqual(len(rows), 12)   # two models; as judged and four causes
        self.assertTrue(rows[0].endswith("| `one_point` | 70 | 70 | 70 | 70 |"), rows[0])
        row = "| no noise | dz | 63 to 85, mean 76 (Table 4) | `transfer_grid` | 70 |"
        self.assertTrue(any(row in line for line in rows))
        self.assertIn("| dy | 7.5 | `armax` | 4.0 | 4.0 | 10.0 | 10.0 |", self.page("004"))
        self.assertIn("| from a cold start | 4.0 |", self.page("004"))
        for name in ("004/mares_2019_dz", "004/mares_2019_range", "001/okenka_fig_7", "001/okenka_12000"):
            self.assertIn("</svg>", (self.out / f"out/vmc5/{name}.svg").read_text())
        self.assertIn("| b_j, low speed | 1.14: 1.00 |", self.page("001"))
        record = Record(self.out / "out/vmc5/004/as_published/dz_31/air_cutting")
        # The record has no rise of the coolant: the Z motor's sensor against the base takes its place.
        self.assertEqual([c["id"] for c in record.channels if c["kind"] == "temperature"],
                         ["T_s", "dT_sp", "dT_Y", "dT_Z"])
        self.assertIn("dz: no column 'coolant.main.Z_motor.rise' in the record", self.page("004"))
        self.assertEqual(float(record.rows[0]["time_s"]), 48 * 3600)

    def test_a_cell_is_the_median_and_the_quartiles_of_the_machines(self):
        made = self.published("001", machines=3)
        self.assertEqual(made.returncode, 0, made.stderr)
        row = next(line for line in self.page("001").splitlines() if "four times the speed" in line)
        self.assertTrue(row.endswith("| `one_point` |" + " 70 (65 to 70) |" * 4), row)   # 70, 60, 70
        self.assertEqual(cell([1.0, None, 2.0, 4.0, 10.0], 1), "3.0 (1.8 to 5.5)")
        self.assertEqual((cell([]), cell([3.0])), ("-", "3"))

    def test_a_missing_column_is_named_and_the_others_go_on(self):
        made = self.published("004", "001", lacks="T1")
        self.assertEqual(made.returncode, 3, made.stderr)
        self.assertIn("no column 'T1', which the models need", made.stderr)
        for document, rows in (("001", 6), ("004", 6)):
            page = self.page(document)
            models = [line for line in page.splitlines() if "| `" in line and "cause" not in line]
            self.assertEqual(sum("| - |" in line for line in models), rows, page)
        self.assertIn("- four times the speed: ", self.page("001"))
        self.assertIn("no column 'T1'; dT_sp needs it", self.page("004"))
        self.assertIn(self.page("001"), (self.out / "out/all.md").read_text())
        # A column that one document alone needs.
        made = self.published("004", "001", lacks="T3")
        self.assertEqual(made.returncode, 3, made.stderr)
        self.assertIn("no column 'T3'; dT_Y needs it", self.page("004"))
        self.assertNotIn("no column", self.page("001"))
        self.assertIn("`one_point` | 70 |", self.page("001"))

    def test_tests_name_what_the_case_has(self):
        def loads_of(case):
            return {path.stem for path in (ROOT / f"cases/{case}/loads").glob("*.toml")}
        for test in TESTS:
            case = "ac5" if test.second else "vmc5"
            machine = tomllib.loads((ROOT / f"cases/{case}/machine.toml").read_text())
            self.assertIn(test.document, TITLES)
            self.assertIn(test.measure, MEASURES)
            self.assertLessEqual({*test.train, test.judge}, loads_of(case), test.name)
            self.assertLessEqual({*test.power}, {source["id"] for source in machine["source"]})
            for _, change in test.ablation:
                self.assertNotEqual(dataclasses.replace(test, **change), test)
            for place in test.check:
                self.assertLess(place, len(test.poses), test.name)
        self.assertLessEqual({*naumann.ALL, *naumann.VALIDATIONS, *mares_2019.CALIBRATIONS, mares_2019.JUDGED},
                             loads_of("vmc5"))


class Judging(unittest.TestCase):
    def test_the_error_vector_is_of_all_directions(self):
        rows = [{"model": "m", "channel": f"{d}@check1", "rms": after, "rms_before": before}
                for d, before, after in (("dx", 3.0, 0.0), ("dy", 4.0, 2.5), ("dz", 0.0, 0.0))]
        self.assertEqual(naumann.figures(rows, "m", [1])[:3], [50.0, 100.0, 37.5])
        self.assertEqual(naumann.figures(rows, "other", [1]), [None] * 4)
        self.assertIsNone(naumann.removed(rows, "m", ["dx@check1", "dx@check2"]))

    def test_times_smaller_is_a_ratio_of_ranges(self):
        rows = [{"model": "armax", "channel": "dy@1", "peak_to_peak_before": 9.0, "peak_to_peak": 2.0}]
        self.assertEqual(mares_2019.times_smaller(rows, "armax", "dy"), 4.5)
        self.assertIsNone(mares_2019.times_smaller(rows, "armax", "dz"))

    def test_a_drive_has_the_power_of_its_laws(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "channels.toml").write_text(
                '[[channel]]\nid = "n"\nkind = "speed"\nunit = "rpm"\ninput = "axis.C.speed_rpm"\n'
                '[[channel]]\nid = "T3"\nkind = "temperature"\nunit = "degC"\n')
            (Path(folder) / "data.csv").write_text("time_s,n,T3\n0,0,20\n60,50,\n120,500,22\n")
            law = {"input": "axis.C.speed_rpm", "at": [0, 100], "power_W": [10, 210]}
            record = Record(folder)
            record.add_power({"source": [{"id": "C.drive", "law": [law]}]}, "C.drive")
            self.assertEqual([row["C.drive"] for row in record.rows], ["10.0", "110.0", "210.0"])
            record.add_difference("d", "T3", "n")
            self.assertEqual([row["d"] for row in record.rows], ["20", "", "-478"])
            held = {"kind": "holding", "motion": "A", "full_power_W": 100}
            words = "no column 'axis.A.position_deg'; the power of A.motor needs it"
            with self.assertRaisesRegex(MissingColumn, words):
                record.add_power({"source": [{"id": "A.motor", "law": [held]}]}, "A.motor")

    def test_a_held_axis_needs_more_after_a_motion_against_its_load(self):
        law = {"kind": "holding", "motion": "A", "full_power_W": 100, "friction_share": 0.1, "balanced_at_deg": 0}
        sides = {after: holding_power(law, {"axis.A.position_deg": 30, "axis.A.positive.on": after})
                 for after in (1.0, 0.5, 0.0)}
        self.assertAlmostEqual(sides[1.0], 36.0)    # (0.5 + 0.1)^2
        self.assertAlmostEqual(sides[0.0], 16.0)
        self.assertAlmostEqual(sides[0.5], 26.0)
        self.assertAlmostEqual(holding_power(law, {"axis.A.position_deg": 30}), 26.0)
        swept = {"axis.A.feed_deg_min": 9, "axis.A.low_deg": 0, "axis.A.high_deg": 90, "axis.A.positive.on": 0.75}
        angles = [math.radians(90 * (i + 0.5) / 1000) for i in range(1000)]
        self.assertAlmostEqual(holding_power(law, swept), sum(
            75 * (math.sin(a) + 0.1) ** 2 + 25 * (math.sin(a) - 0.1) ** 2 for a in angles) / 1000, places=4)


class OnePoint(unittest.TestCase):
    def test_coefficients_are_ratios_and_bilinear_between_the_corners(self):
        sizes = {1: 1.3, 2: 9.0, 3: 1.1, 4: 1.0, 5: 0.9, 6: 0.7}
        measured = {place: [size * value for value in (0.0, 0.01, 3.0, 4.0)] for place, size in sizes.items()}
        measured[1][1] = 50.0   # a ratio near 0 is noise
        own, used = okenka.coefficients(measured)
        self.assertAlmostEqual(own[1], 1.3)
        self.assertAlmostEqual(used[2], 1.2 - 0.4 * 10.0 / 550.0)
        self.assertAlmostEqual(used[4], 0.3 * (0.3 * 1.3 + 0.7 * 0.9) + 0.7 * (0.3 * 1.1 + 0.7 * 0.7))
        found = okenka.figures(measured, measured[4], used)
        self.assertAlmostEqual(found[6]["fit, b_j"], 100.0)
        self.assertAlmostEqual(found[6]["PK, one point"], 100.0 * 0.3 / 0.7)


class Chart(unittest.TestCase):
    def drawn(self, page, *words):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "page.md").write_text(page)
            made = subprocess.run([sys.executable, str(ROOT / "tools/published_chart"), str(Path(folder) / "page.md"),
                                   str(Path(folder) / "out.svg"), *words], capture_output=True, text=True)
            picture = Path(folder) / "out.svg"
            return made, picture.read_text() if picture.exists() else ""

    def test_a_picture_has_the_figures_of_the_page(self):
        page = "| a | b |\n|---|---|\n| 1 | 2 |\n\n| test | published | `ours` |\n|---|---|---|\n" \
               "| one | 56 to 72 (6.1) | 83 (80 to 86) |\n|  | no test in print | -9.5 |\n| two | 1 | 2 |\n"
        words = ["--column", "published", "`ours`", "--where", "test=one"]
        made, picture = self.drawn(page, *words)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(re.findall(r"<title>([^<]*)</title>", picture), ["56 to 72", "83", "-9.5"])
        self.assertIn(">ours</text>", picture)
        made, picture = self.drawn(page, "--column", "theirs")
        self.assertEqual((made.returncode, picture), (3, ""))
        self.assertIn("allowed: a table with the columns test, theirs", made.stderr)


class Rotary(unittest.TestCase):
    def test_rows_stand_beside_what_is_printed(self):
        def missing(call):
            return "no column 'x'"
        lines = rotary.judge(SimpleNamespace(seeds=range(31, 33)), 2, missing)
        self.assertEqual(len([line for line in lines if line.startswith("| ")]), 9)
        self.assertIn("- A/C: C axis, R-Tests (Table 6.4): no column 'x'", lines)
        row = "| X0C (- before) | 48 | `phenomenological` | - | - | - | - |"
        self.assertTrue(any(row in line for line in lines))


unittest.main()
