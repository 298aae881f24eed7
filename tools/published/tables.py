# SPDX-License-Identifier: GPL-3.0-or-later
"""A document's tables in Markdown: a row for each test, quantity and model; and of ablations."""
from published.documents import MEASURES, TITLES
from published.statistics_of import cell, of_machine

TWIN = ("reduced_model", "reduced_model_sensors")


def row_cells(found, models, quantity, measure):
    """@param found  rows by seed"""
    digits = 1 if measure == "times" else 0
    return [cell([of_machine(rows, model, quantity, measure) for rows in found.values()], digits) for model in models]


def table(document, judged):
    """@param judged  tests with their rows by seed and models, or with the note of a column that is missing"""
    lines = [f"## {document}: {TITLES[document]}", "",
             "| test | measure | trained on | judged on | quantity | published | model | ours | static regression | "
             "reduced model | with sensors |", "|---" * 11 + "|"]
    notes = []
    for test, result in judged:
        if isinstance(result, str):
            found, static, own = {}, None, test.models
            notes.append(f"{test.name}: {result}")
        else:
            found, (static, *own) = result
        for model in own:
            for quantity in test.quantities:
                published = test.published.get(quantity, test.published.get("all", "-"))
                lines.append("| " + " | ".join([
                    test.name, MEASURES[test.measure], test.trained, test.judged, quantity, published, f"`{model}`",
                    *row_cells(found, (model, static, *TWIN), quantity, test.measure)]) + " |")
    lines += ["", *(f"- {note}" for note in notes)] if notes else []
    return "\n".join(lines) + "\n"


def ablation_table(found):
    """@param found  tests with their causes: (test, [(cause, (rows by seed, models))])"""
    lines = ["", "Ablation, one cause at a time.", "",
             "| test | change | quantity | published | model | ours | static regression | reduced model |",
             "|---" * 8 + "|"]
    for test, causes in found:
        for quantity in test.quantities:
            published = test.published.get(quantity, test.published.get("all", "-"))
            for model in test.models:
                for cause, (rows, (static, *_)) in causes:
                    lines.append("| " + " | ".join([
                        test.name, cause, quantity, published, f"`{model}`",
                        *row_cells(rows, (model, static, TWIN[0]), quantity, test.measure)]) + " |")
    return "\n".join(lines) + "\n"
