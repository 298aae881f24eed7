# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of rows of `evaluate`: a median over the measured places, then median and quartiles over the machines."""
import statistics

KEYS = {"rms": "rms_reduction_percent", "fit": "fit", "range": "peak_to_peak_reduction_percent"}
LEAST_UM = 4.0  # channels that move by less are the probe's noise


def measured_by(row, measure):
    """@param measure  of KEYS, or times: how many times smaller the range is  @return None where it has none"""
    if measure == "times":
        return row["peak_to_peak_before"] / row["peak_to_peak"] if row["peak_to_peak"] else None
    return row[KEYS[measure]]


def median(values):
    known = [value for value in values if value is not None]
    return statistics.median(known) if known else None


def of_machine(rows, model, quantity, measure):
    """Median over the places of one machine; None: no place moves enough, or the model predicts none."""
    return median([measured_by(row, measure) for row in rows
                   if row["model"] == model and row["channel"].partition("@")[0] == quantity
                   and row["peak_to_peak_before"] > LEAST_UM])


def quartiles(values):
    known = [value for value in values if value is not None]
    if len(known) < 2:
        return None
    return statistics.quantiles(known, n=4, method="inclusive")


def cell(values, digits=0):
    """"82 (79 to 85)": median and quartiles over machines; of one machine its figure."""
    known = [value for value in values if value is not None]
    if not known:
        return "-"
    text = f"{statistics.median(known):.{digits}f}"
    if len(known) > 1:
        low, _, high = quartiles(known)
        text += f" ({low:.{digits}f} to {high:.{digits}f})"
    return text
