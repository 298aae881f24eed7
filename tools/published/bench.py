# SPDX-License-Identifier: GPL-3.0-or-later
"""Machines of a test, measured virtually, and the judgement of the document's models on them.

A measured machine is perturbed as by `validate --perturb thermal`: powers, films and contact conductances. It is a
reduced model of reference order on a finer mesh (`reduce --size`), run by matrix exponentials, or with --full the full
model on that mesh with TR-BDF2 and error control. Noise is 0.05 K and 0.3 um.
"""
import dataclasses
import hashlib
import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

from published.documents import SURROUNDINGS
from published.records import Record

TOOLS = Path(__file__).resolve().parent.parent
ORDER = 240   # of the model of measured machines; its reference, which is run, has half as many again
STATIC = {True: "static_grid", False: "static_regression"}  # whether places are held out


def link_to(case, folder):
    """A case of its own case.toml beside the machine of another."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("machine.toml", "loads", "cad"):
        if not (folder / name).exists():
            os.symlink((case / name).resolve(), folder / name)


def case_with_poses(case, poses, folder):
    """The case with other check points, where the virtual measurement probes."""
    if not poses:
        return case
    link_to(case, folder)
    text = (case / "case.toml").read_text()
    head = text[:text.index("[check_points]")]
    places = "".join(f'  "{pose}",\n' for pose in poses)
    (folder / "case.toml").write_text(f"{head}[check_points]\nposes = [\n{places}]\n")
    return folder


def case_with_one_program(case, folder):
    """The case with the last of its training programs alone: the basis of a model of this order hardly needs them."""
    link_to(case, folder)
    own = tomllib.loads((case / "case.toml").read_text())
    (folder / "case.toml").write_text(f'schema = 1\nsize = "{own["size"]}"\ntrain = ["{own["train"][-1]}"]\n')
    return folder


class Bench:
    """One case with its reduced model; measures its machines once."""

    def __init__(self, run, options, case, model, truth, missing):
        self.run, self.options, self.case, self.missing = run, options, case, missing
        self.out = options.out / case.name
        self.model = model or self.reduced("reduced", case) / "model.rom.h5"
        self.given_truth = truth
        self.machine = tomllib.loads((case / "machine.toml").read_text())
        self.seeds = range(options.seed, options.seed + options.machines)
        self.some = self.seeds[:options.ablation]   # machines of the ablations
        self.measured, self.campaigns, self.said = {}, {}, set()

    def reduced(self, name, case, *more):
        folder = self.out / name
        if not (folder / "model.rom.h5").exists():
            self.run("reduce", case, *more, "--out", folder, "--quiet")
        return folder

    def truth(self):
        """Reduced model of the measured machines, on a finer mesh; made once (minutes)."""
        if not self.given_truth:
            size, case = self.options.measured_size, case_with_one_program(self.case, self.out / "finer_case")
            self.given_truth = self.reduced(f"finer_{size:g}", case, "--size", size, "--order",
                                            ORDER) / "reference.rom.h5"
        return self.given_truth

    def validate(self, case, loads, out, noise=True, perturb="thermal", seeds=None, coolant=False):
        """Folder of each load program by seed, as measured."""
        seeds = seeds or self.seeds
        full = self.options.full
        how = ["--measured-size", self.options.measured_size] if full else ["--truth", self.truth()]
        how += ["--coolant"] if full and coolant else []
        how += [] if noise else ["--no-noise"]
        self.run("validate", case, "--model", self.model, *how, "--perturb", perturb, "--draws", len(seeds),
                 "--first-seed", seeds[0], "--load", *loads, "--out", out, "--quiet")
        kept = out / "measured" / (perturb if full else "reduced")
        return {load: {seed: kept / load / f"machine_{seed}" for seed in seeds} for load in loads}

    def measure(self, test, seeds):
        """The case, and for each seed the folder of each load program of the test."""
        own = [] if test.from_campaign else test.train
        loads = sorted({*own, test.judge})
        digest = hashlib.sha256("|".join(test.poses).encode()).hexdigest()[:12]
        key = f"poses_{digest}" if test.poses else "check_points"
        key += ("" if test.noise else "_no_noise") + ("" if test.perturb == "thermal" else f"_{test.perturb}")
        out = self.out / key
        case = case_with_poses(self.case, test.poses, out / "case")
        missing = [load for load in loads if any((key, load, seed) not in self.measured for seed in seeds)]
        if missing:
            found = self.validate(case, missing, out, test.noise, test.perturb, seeds)
            for load, folders in found.items():
                for seed, folder in folders.items():
                    self.measured[key, load, seed] = folder
        return case, {seed: {load: self.measured[key, load, seed] for load in loads} for seed in seeds}

    def campaign(self, loads):
        """Tables of the nominal model on the grid at all tilts, as one measurement folder with a program a load."""
        key = tuple(loads)
        if key not in self.campaigns:
            out = self.out / "campaign"
            self.run("campaign", self.case, "--reduced", "--model", self.model, "--all-tilts", "--load", *loads,
                     "--out", out, "--quiet")
            folder = out / "record"
            self.as_measured(out / "campaign_reduced", folder, loads, "--poses", "1", "--noise-um", "0.01",
                             "--noise-k", "0.001", "--held")
            self.campaigns[key] = folder
        return self.campaigns[key]

    def as_measured(self, tables, folder, loads, *how):
        subprocess.run([str(TOOLS / "programs_measurement"), str(tables), str(folder), *loads, "--machine",
                        self.machine["name"], *how], check=True, capture_output=True)

    def prepared(self, test, load, source, folder):
        record = Record(source)
        for name, (first, second) in test.differences.items():
            record.add_difference(name, first, second)
        if test.differences:
            record.rename_ambient(SURROUNDINGS)
        for power in test.power:
            record.add_power(self.machine, power)
        record.keep_displacements(lambda channel: channel["quantity"] in test.quantities)
        if test.inputs:
            record.keep_inputs(test.inputs)
        if test.hours:
            record.cut(test.start_h, test.hours)
        if test.from_campaign:
            record.rename_displacements(lambda name: name.replace("@", "@check"))
        return record.write(folder / load, load)

    def folder(self, test, seed):
        plain = "".join("_" if c in " ,':;/()" else c for c in test.name)
        return self.out / test.document / plain / f"machine_{seed}"

    def judge(self, test, seeds=None):
        """For each machine the rows of the evaluation: of the fitted models, and of the reduced model on the record as
        it was measured. @return rows by seed, and the models with the static regression first
        """
        seeds = seeds or self.seeds
        case, sources = self.measure(test, seeds)
        models = [STATIC[bool(test.check)], *test.models]
        return {seed: self.judge_machine(test, case, sources[seed], models, self.folder(test, seed))
                for seed in seeds}, models

    def judge_machine(self, test, case, sources, models, folder):
        judged = self.prepared(test, test.judge, sources[test.judge], folder)
        check = [f"{q}@{i + 1}" for i in test.check for q in test.quantities]
        if test.from_campaign:
            training = ["--train-data", self.campaign(test.train)]
            check = [c["id"] for c in Record(judged).channels if c["kind"] == "displacement"]
        elif test.train == [test.judge]:
            training = ["--train-programs", test.judge]
        else:
            training = ["--train-data", ",".join(str(self.prepared(test, load, sources[load], folder))
                                                 for load in test.train if load != test.judge)]
        fitted = json.loads(self.run("evaluate", "--data", judged, *training, "--models", ",".join(models),
                                     *(["--check", ",".join(check)] if check else []), "--out", folder, "--quiet",
                                     "--json"))
        for note in fitted["notes"]:
            words = f"{test.document} {test.name}: {note}"
            if "left out" in note and words not in self.said:   # once for all machines
                self.said.add(words)
                print(words, file=sys.stderr)
        rows = [row for row in fitted["rows"] if row["part"] in (test.judge, folder.name)]
        whole = Record(sources[test.judge])
        if test.hours:
            whole.until(test.start_h + test.hours)
        if test.from_campaign:
            whole.rename_displacements(lambda name: name.replace("@", "@check"))
        whole.write(folder / "whole", test.judge, test.start_h)
        twin = json.loads(self.run("evaluate", case, "--model", self.model, "--data", folder / "whole",
                                   "--train-programs", test.judge, "--models", "static_regression", "--out",
                                   folder / "twin", "--quiet", "--json"))
        return rows + [row for row in twin["rows"] if row["model"].startswith("reduced_model")]

    def ablation(self, test):
        """For each cause of the test its name and the rows by seed, of the machines of the ablations."""
        found = [("as judged", self.judge(test, self.some))]
        for cause, change in test.ablation:
            changed = dataclasses.replace(test, name=f"{test.name} {cause}", **change)
            found.append((cause, self.judge(changed, self.some)))
        return found
