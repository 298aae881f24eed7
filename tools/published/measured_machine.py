# SPDX-License-Identifier: GPL-3.0-or-later
"""A machine of a case measured virtually: the full model with other parameters, mesh and time scheme, and noise.

All uncertain nominal values of machine.toml are multiplied by 1 + spread * std_percent / 100 * N(0, 1), N within 2.5:
powers, films, contacts, stiffnesses, expansions and capacities. The mesh is finer than that of the case, and time is
taken by the adaptive scheme as in `validate`. Tool and table stand at one pose, at which the displacements and
rotations are recorded.
"""
import csv
import json
import math
import os
import random
import re
from pathlib import Path

from published.records import Record, value_of

SENSOR_K, PROBE_UM = 0.05, 0.3   # noise, one standard deviation, as in `validate`
FARTHEST = 2.5                   # of a value, in its standard deviations
TIME = '\n[time]                          # as of `validate`\nscheme = "adaptive"\ntolerance_K = 0.063\n'
SETTLING_H = 24   # a machine that is on comes to balance with its surroundings before a test
SETTLING = f'\n[[phase]]\nname = "settling"\nduration_h = {SETTLING_H}\nair_C = 21.0\nfoundation_C = 21.0\n'
UNCERTAIN = re.compile(r"(?P<key>\w+ = )\{value = (?P<value>[-+.\deE]+), std_percent = (?P<percent>[-+.\deE]+)\}")
ENDS = ((".on", "state", "1"), ("speed_rpm", "speed", "rpm"), ("feed_mm_min", "speed", "mm_min"),
        ("feed_deg_min", "speed", "deg_min"), (".power_W", "power", "W"), (".T_C", "temperature", "degC"),
        ("_mm", "position", "mm"), ("_deg", "position", "deg"))


def perturbed(text, seed, spread=1.0):
    """machine.toml with all uncertain values drawn anew but the temperatures of ambients, which the programs state."""
    draw = random.Random(f"machine {seed}")

    def other(found):
        normal = min(max(draw.gauss(0.0, 1.0), -FARTHEST), FARTHEST)
        if found["key"].startswith("default_C"):
            return found[0]
        factor = max(0.2, 1.0 + spread * float(found["percent"]) / 100.0 * normal)
        return f"{found['key']}{{value = {float(found['value']) * factor:.9g}, std_percent = {found['percent']}}}"

    return UNCERTAIN.sub(other, text)


def replaced(text, pattern, new, file):
    result, count = re.subn(pattern, new, text, flags=re.MULTILINE | re.DOTALL)
    if count != 1:
        raise SystemExit(f"{file}: '{pattern}' found {count} times; allowed: once")
    return result


def case_at(case, folder, pose, loads, change=lambda text: text):
    """A copy of the case whose programs settle and then run at this pose, with the time scheme of measured machines.

    Its workspace is the pose alone.

    @param pose      axis key: position, as of [workspace]: {"Z_mm": 0}
    @param change    of the text of machine.toml
    """
    case, folder = Path(case), Path(folder)
    (folder / "loads").mkdir(parents=True, exist_ok=True)
    if not (folder / "cad").exists():
        os.symlink((case / "cad").resolve(), folder / "cad")
    text = change((case / "machine.toml").read_text())
    grid = "".join(f"{key} = [{value}]\n" for key, value in pose.items())
    text = replaced(text, r"^\[workspace\]\n.*\Z", f"[workspace]\n{grid}", case / "machine.toml")
    (folder / "machine.toml").write_text(text)
    names = ", ".join(f'"{load}"' for load in loads)
    (folder / "case.toml").write_text(f'schema = 1\nsize = "coarse"\ntrain = [{names}]\n{TIME}')
    at = ", ".join(f"{key} = {value}" for key, value in pose.items())
    for load in loads:
        file = case / "loads" / f"{load}.toml"
        program = replaced(file.read_text(), r"^position = \{[^}]*\}", f"position = {{ {at} }}", file)
        head, first, phases = program.partition("\n[[phase]]\n")
        (folder / "loads" / f"{load}.toml").write_text(head + SETTLING + first + phases)
    return folder


def rows_of(path):
    try:
        with open(path, newline="") as file:
            return list(csv.DictReader(file))
    except OSError as error:
        raise SystemExit(f"{path}: cannot be read ({error.strerror}); allowed: what `thermotwin campaign` wrote")


def kind_of(name):
    return next(((kind, unit) for end, kind, unit in ENDS if name.endswith(end)), None)


def toml_of(channels, load, last_s, machine):
    text = f"[record]\nmachine = {json.dumps(machine)}\n"
    for name, kind, unit, deviation, what in channels:
        text += f'[[channel]]\nid = "{name}"\nkind = "{kind}"\nunit = "{unit}"\nuncertainty = {deviation}\n{what}\n'
    return text + f'[[program]]\nname = "{load}"\nfrom_s = 0.0\nto_s = {last_s + 1.0!r}\n'


def record(campaign, load, folder, seed, machine, quantities=("dx", "dy", "dz")):
    """Measurement folder of one program of a campaign at one pose, with noise; rows as `programs_measurement --held`.

    truth.csv beside it has the errors without noise.
    @param machine  its name, which the record states
    @return the errors without noise at the times of the rows: quantity -> list, um or um/m
    """
    source, folder = Path(campaign) / load, Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    tcp, sensors, inputs = (rows_of(source / f"{name}.csv") for name in ("tcp", "sensors", "inputs"))
    noise = random.Random(f"noise {seed} {load}")
    known = [name for name in inputs[0] if name != "time_s" and kind_of(name)]
    # A row of inputs.csv is the mean since the row before it; a row of data.csv holds until the next one.
    held = dict(zip((row["time_s"] for row in sensors), inputs[1:] + inputs[-1:]))
    read = {row["time_s"]: row for row in sensors}
    ids = [name[:-2] for name in sensors[0] if name != "time_s"]
    columns = [name for name in tcp[0] if name.startswith(("d", "r"))]
    units = {name.split("_", 1)[0]: name for name in columns if not name.endswith(("_tool", "_table"))}
    axes = [name for name in tcp[0] if name.endswith(("_mm", "_deg"))]
    pose = "pose = {" + ", ".join(f"{axis} = {float(tcp[0][axis]):g}" for axis in axes) + "}"
    channels = [(name, *kind_of(name), 0.05, f'input = "{name}"') for name in known]
    channels += [(name, "temperature", "degC", SENSOR_K, f'sensor = "{name}"') for name in ids]
    channels += [(f"{q}@1", "displacement", "um", PROBE_UM, f'quantity = "{q}"\n{pose}') for q in quantities]
    with open(folder / "data.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s"] + [channel[0] for channel in channels])
        for row in tcp:
            at = row["time_s"]
            cells = [held[at][name] for name in known]
            cells += [f"{float(read[at][name + '_C']) + noise.gauss(0.0, SENSOR_K):.6g}" for name in ids]
            cells += [f"{float(row[units[q]]) + noise.gauss(0.0, PROBE_UM):.6g}" for q in quantities]
            writer.writerow([at] + ["" if cell == "nan" else cell for cell in cells])
    (folder / "channels.toml").write_text(toml_of(channels, load, float(tcp[-1]["time_s"]), machine))
    with open(folder / "truth.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([f"{quantity}@1" for quantity in units])
        writer.writerows([row[name] for name in units.values()] for row in tcp)
    return {quantity: [float(row[name]) for row in tcp] for quantity, name in units.items()}


def settled(whole, folder, hours=SETTLING_H):
    """The test alone: rows from these hours on, their times and displacements counted from there.

    The record as a whole gets a program that begins there: a reduced model has to know what was before.
    """
    whole, own = Path(whole), Record(whole)
    start_s, program = 3600.0 * hours, own.programs[0]["name"]
    truth = rows_of(whole / "truth.csv")
    kept = [i for i, row in enumerate(own.rows) if float(row["time_s"]) >= start_s - 1e-6]
    zero = {name: float(value) for name, value in truth[kept[0]].items()}
    own.write(whole, program, hours)
    own.rows = [own.rows[i] for i in kept]
    for row in own.rows:
        row["time_s"] = f"{float(row['time_s']) - start_s:.9g}"
        for channel in own.channels:
            if channel["kind"] == "displacement":
                row[channel["id"]] = f"{float(row[channel['id']]) - zero[channel['id']]:.6g}"
    own.write(folder, program)
    with open(Path(folder) / "truth.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(zero)
        writer.writerows([f"{float(truth[i][name]) - zero[name]:.9g}" for name in zero] for i in kept)
    return Path(folder)


def zeroed(values):
    """Against the first value that is known."""
    first = next((value for value in values if value is not None), 0.0)
    return [None if value is None else value - first for value in values]


def fit_percent(measured, predicted):
    """1 - |d - s| / |d - mean d|, % (Mares et al. 2020, eq. 4), of the rows that have both."""
    pairs = [(m, p) for m, p in zip(measured, predicted) if m is not None and p is not None]
    mean = sum(m for m, _ in pairs) / len(pairs)
    left = math.sqrt(sum((m - p) ** 2 for m, p in pairs))
    return 100.0 * (1.0 - left / math.sqrt(sum((m - mean) ** 2 for m, _ in pairs)))


def rms_removed_percent(measured, predicted):
    pairs = [(m, p) for m, p in zip(measured, predicted) if m is not None and p is not None]
    left = math.sqrt(sum((m - p) ** 2 for m, p in pairs))
    return 100.0 * (1.0 - left / math.sqrt(sum(m * m for m, _ in pairs)))


def factor_of(measured, predicted):
    """The factor on a prediction that leaves the least squares."""
    pairs = [(m, p) for m, p in zip(measured, predicted) if m is not None and p is not None]
    return sum(m * p for m, p in pairs) / sum(p * p for _, p in pairs)


def two_factors(measured, first, second):
    """The factors on two predictions whose sum leaves the least squares."""
    rows = [row for row in zip(measured, first, second) if None not in row]
    aa, bb, ab = (sum(row[i] * row[j] for row in rows) for i, j in ((1, 1), (2, 2), (1, 2)))
    am, bm = (sum(row[0] * row[i] for row in rows) for i in (1, 2))
    determinant = aa * bb - ab * ab
    return (am * bb - bm * ab) / determinant, (bm * aa - am * ab) / determinant


def column(folder, name, file="data.csv"):
    """@param file  truth.csv: the errors without noise"""
    return [value_of(row[name]) for row in rows_of(Path(folder) / file)]
