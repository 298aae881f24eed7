# SPDX-License-Identifier: GPL-3.0-or-later
"""Measurement folders as the authors' models see them: chosen inputs, differences, the power of a drive."""
import csv
import math
import tomllib
from pathlib import Path


class MissingColumn(Exception):
    """A record lacks a column that a model needs: file, column, and what needs it."""


def value_of(text):
    """@return the number of a cell, None where it is blank"""
    return float(text) if text not in ("", "nan") else None


def toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + "}"
    return f'"{value}"' if isinstance(value, str) else repr(value)


def mean_square_of_sine(low, high):
    """Mean of sin^2 over angles in rad."""
    if high - low < 1e-9:
        return math.sin(low) ** 2
    return 0.5 - (math.sin(2 * high) - math.sin(2 * low)) / (4 * (high - low))


def mean_sine(low, high):
    """Mean of sin over angles in rad."""
    return math.sin(low) if high - low < 1e-9 else (math.cos(low) - math.cos(high)) / (high - low)


def table_power(law, cells):
    value = abs(cells.get(law["input"]) or 0.0)  # as the program takes all inputs but temperatures
    at, power = law["at"], law["power_W"]
    value = min(max(value, at[0]), at[-1])
    (low,) = [i for i in range(len(at) - 1) if at[i] <= value and (value < at[i + 1] or i == len(at) - 2)]
    return power[low] + (power[low + 1] - power[low]) * (value - at[low]) / (at[low + 1] - at[low])


def holding_power(law, cells):
    """The law `holding` with full_power_W and linear_share = 0: copper losses.

    The mean over the angles of a range, and over the time after a motion in either direction.
    """
    axis = f"axis.{law['motion']}."
    low, high = cells.get(axis + "low_deg"), cells.get(axis + "high_deg")
    if low is None or high is None or not cells.get(axis + "feed_deg_min"):
        low = high = cells.get(axis + "position_deg") or 0.0
    angles = [math.radians(angle - law.get("balanced_at_deg", 0.0)) for angle in (low, high)]
    friction = law.get("friction_share", 0.0)
    positive = cells.get(axis + "positive.on")
    direction = 0.0 if positive is None else 2 * positive - 1   # mean of 1 and -1
    on = cells.get("machine.on")
    share = mean_square_of_sine(*angles) + 2 * friction * direction * mean_sine(*angles) + friction ** 2
    return (1.0 if on is None else on) * law["full_power_W"] * share


def law_power(machine, source, cells):
    """Heat of a source by its nominal laws, W. @param cells  the row's values by channel"""
    (spec,) = [item for item in machine["source"] if item["id"] == source]
    return sum(holding_power(law, cells) if law.get("kind") == "holding" else table_power(law, cells)
               for law in spec["law"])


class Record:
    """channels.toml and data.csv of one measurement."""

    def __init__(self, folder):
        self.folder = Path(folder)
        described = tomllib.loads((self.folder / "channels.toml").read_text())
        self.channels, self.programs = described["channel"], described.get("program", [])
        self.record = described.get("record", {})   # machine, time of day: kept by write()
        with open(self.folder / "data.csv", newline="") as file:
            self.rows = list(csv.DictReader(file))

    def input_name(self, channel):
        return channel.get("input") or channel["id"]

    def cells(self, row):
        """Values of a row by the names of the machine's channels."""
        return {self.input_name(c): value_of(row[c["id"]]) for c in self.channels if c["kind"] != "displacement"}

    def add_power(self, machine, source):
        """Power of a drive by its laws. @raises MissingColumn"""
        (spec,) = [item for item in machine["source"] if item["id"] == source]
        known = {self.input_name(channel) for channel in self.channels}
        for law in spec["law"]:
            axis = f"axis.{law.get('motion')}."
            names = [law["input"]] if "input" in law else [axis + "position_deg", axis + "low_deg"]
            if not known & set(names):
                raise MissingColumn(f"{self.folder}/data.csv: no column '{names[0]}'; the power of {source} needs it")
        for row in self.rows:
            row[source] = f"{law_power(machine, source, self.cells(row)):.1f}"
        self.channels.append({"id": source, "kind": "power", "unit": "W"})

    def add_difference(self, name, first, second):
        """A temperature against another: columns by id. @raises MissingColumn"""
        for column in (first, second):
            if column not in self.rows[0]:
                raise MissingColumn(f"{self.folder}/data.csv: no column '{column}'; {name} needs it")
        for row in self.rows:
            a, b = value_of(row[first]), value_of(row[second])
            row[name] = "" if a is None or b is None else f"{a - b:.6g}"
        self.channels.append({"id": name, "kind": "temperature", "unit": "degC", "uncertainty": 0.07})

    def rename_ambient(self, name):
        """The air as one temperature among others: no model takes differences against it of its own accord."""
        for channel in self.channels:
            if channel.get("input") == "air.T_C":
                for row in self.rows:
                    row[name] = row[channel["id"]]
                channel["id"] = name
                del channel["input"]

    def keep_inputs(self, names):
        """Displacements, and of the inputs these only."""
        missing = [n for n in names if n not in self.rows[0]]
        if missing:
            raise MissingColumn(f"{self.folder}/data.csv: no column '{missing[0]}', which the models need")
        self.channels = [c for c in self.channels if c["kind"] == "displacement" or c["id"] in names]

    def keep_displacements(self, wanted):
        """@param wanted  predicate of a channel"""
        self.channels = [c for c in self.channels if c["kind"] != "displacement" or wanted(c)]

    def rename_displacements(self, name):
        for channel in self.channels:
            if channel["kind"] != "displacement":
                continue
            new = name(channel["id"])
            for row in self.rows:
                row[new] = row[channel["id"]]
            channel["id"] = new

    def cut(self, start_h, hours):
        """Rows of these hours only; displacements then count from the first of them."""
        first, last = 3600.0 * start_h - 1e-6, 3600.0 * (start_h + hours) + 1e-6
        self.rows = [row for row in self.rows if first <= float(row["time_s"]) <= last]
        for channel in self.channels:
            if start_h > 0 and channel["kind"] == "displacement":
                channel["zero"] = "first"

    def until(self, hours):
        self.cut(0.0, hours)

    def write(self, folder, program=None, start_h=0.0):
        """As one program of this name, that begins at start_h; without a name with the programs that it has."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        names = ["time_s"] + [c["id"] for c in self.channels]
        with open(folder / "data.csv", "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows([row[name] for name in names] for row in self.rows)
        text = "[record]\n" if self.record else ""
        text += "".join(f"{key} = {toml_value(item)}\n" for key, item in self.record.items())
        for channel in self.channels:
            text += "[[channel]]\n" + "".join(f"{key} = {toml_value(item)}\n" for key, item in channel.items())
        programs = self.programs
        if program:
            first = max(float(self.rows[0]["time_s"]), 3600.0 * start_h)
            programs = [{"name": program, "from_s": first, "to_s": float(self.rows[-1]["time_s"]) + 1.0}]
        for part in programs:
            text += f'[[program]]\nname = "{part["name"]}"\nfrom_s = {part["from_s"]!r}\nto_s = {part["to_s"]!r}\n'
        (folder / "channels.toml").write_text(text)
        return folder
