# SPDX-License-Identifier: GPL-3.0-or-later
"""The A/C machine of Gebhardt (2014): Tables 6.3 and 6.4.

C: location errors of virtual R-Tests once an hour, in random cycles. A: rows of the full model's tables with noise, in
the middle of the workspace, because the load program of a planned test counts the way to a held angle as part of the
holding.
"""
import json
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

from published.records import Record

TOOLS = Path(__file__).resolve().parent.parent
OF_C = ["random_cycle", "--axis", "C", "--load", "C", "--interval", "60", "--speeds", "5,60", "--standstills",
        "--cool-down", "4"]
PLANS = {"c_train": [*OF_C, "--seed", "6", "--warm-up", "30"], "c_cycle": [*OF_C, "--seed", "7", "--warm-up", "32"]}
OF_A = ["a_hold_90_16h", "a_pendular_16h", "a_cycle_62h"]


@dataclass
class RotaryTest:
    name: str
    train: list
    judge: str
    power: str       # source of the drive's power
    channels: dict   # in print: channel here
    published: dict  # % of the range removed, computed from before and after in print


TESTS = [
    RotaryTest("A/C: A axis, 62 h (Table 6.3)", OF_A[:2], OF_A[2], "A.motor",
               {"dz at the middle": "dz@2", "dx at the middle": "dx@2", "dy at the middle": "dy@2"},
               {"dz at the middle": "42 (Z0A)", "dx at the middle": "59 (X0T)"}),
    RotaryTest("A/C: C axis, 36 h (Table 6.4)", ["c_train"], "c_cycle", "C.motor",
               {"X0C": "X0C", "Z0T": "Z0T", "R0T": "R0T"}, {"X0C": "48", "Z0T": "62", "R0T": "71"}),
]
MODELS = ["static_regression", "phenomenological", "phenomenological_switched", "rotary_unit"]


def measured(run, case, plan, out, seed):
    """Measurement folder of a virtual R-Test; made once."""
    folder = out / plan / "errors" / "measurement"
    if not (folder / "channels.toml").exists():
        run("measure", "plan", *PLANS[plan], "--case", case, "--out", out / plan / "plan")
        run("measure", "simulate", out / plan / "plan", "--case", case, "--machine-seed", seed, "--out",
            out / plan / "record", "--quiet")
        run("measure", "analyse", out / plan / "record", "--record", out / plan / "record" / "loads", "--out",
            out / plan / "errors", "--quiet")
    return folder


def from_campaign(run, case, out):
    """Rows of the full model at the corners and the middle of the workspace, with noise, a program a load."""
    folder = out / "campaign"
    if not all((folder / "campaign" / load / "done").exists() for load in OF_A):
        run("campaign", case, "--load", *OF_A, "--out", folder, "--quiet")
    record = folder / "record"
    subprocess.run([str(TOOLS / "programs_measurement"), str(folder / "campaign"), str(record), *OF_A, "--held"],
                   check=True, capture_output=True)
    return record


def evaluated(run, case, out, seed, test, machine):
    """Rows of `evaluate` for the judged program."""
    folder = out / test.judge / "prepared"

    def prepared(source, name, program=None):
        record = Record(source)
        record.add_power(machine, test.power)
        # B0C tells the rotary unit that the cradle turns about x. The way of the probe is no input of the source.
        record.keep_displacements(lambda channel: channel["id"] in [*test.channels.values(), "B0C"])
        record.channels = [c for c in record.channels
                           if not c.get("input", "").startswith(("axis.X.", "axis.Y.", "axis.Z."))]
        return record.write(folder / name, program)

    if test.judge in PLANS:
        data = prepared(measured(run, case, test.judge, out, seed), "judged", test.judge)
        training = ["--train-data", ",".join(str(prepared(measured(run, case, plan, out, seed), plan, plan))
                                             for plan in test.train)]
    else:
        data, training = prepared(from_campaign(run, case, out), "record"), ["--train-programs", ",".join(test.train)]
    answer = json.loads(run("evaluate", "--data", data, *training, "--models", ",".join(MODELS), "--out", folder,
                            "--quiet", "--json"))
    return [row for row in answer["rows"] if row["part"] == test.judge]


def of_the_model(run, case, model, out, seed, test):
    """The same of the reduced model, on the records as measured."""
    own = measured(run, case, test.judge, out, seed) if test.judge in PLANS else out / "campaign" / "record"
    whole = Record(own)
    data = whole.write(out / test.judge / "whole", test.judge if test.judge in PLANS else None)
    answer = json.loads(run("evaluate", case, "--model", model, "--data", data, "--train-programs", test.judge,
                            "--models", "static_regression", "--out", out / test.judge / "twin", "--quiet", "--json"))
    return [row for row in answer["rows"] if row["part"] == test.judge and row["model"].startswith("reduced_model")]


def judge(run, case, model, out, seed, guarded=lambda call: call()):
    """Lines of the table: a row for each model and location error.

    @param guarded  calls, and returns the words on a column that is missing in place of the result
    """
    machine = tomllib.loads((case / "machine.toml").read_text())
    lines, notes = [], []
    for test in TESTS:
        rows = guarded(lambda test=test: evaluated(run, case, out, seed, test, machine))
        if isinstance(rows, str):
            notes.append(f"- {test.name}: {rows}")
            rows = []
        elif model:
            rows += of_the_model(run, case, model, out, seed, test)
        for quantity, channel in test.channels.items():
            own = {row["model"]: row for row in rows if row["channel"] == channel}
            cells = {name: f"{row['peak_to_peak_reduction_percent']:.0f}" for name, row in own.items()}
            before = f" ({next(iter(own.values()))['peak_to_peak_before']:.1f} before)" if own else ""
            for name in MODELS[1:]:
                lines.append("| " + " | ".join([
                    test.name, "range removed, %", ", ".join(test.train), test.judge, quantity + before,
                    test.published.get(quantity, "-"), f"`{name}`",
                    *(cells.get(of, "-") for of in (name, MODELS[0], "reduced_model", "reduced_model_sensors")),
                ]) + " |")
    return [*lines, "", *notes] if notes else lines
