#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the bodies of the ac5 machine (Debian: python3-gmsh); the tool side and the writing are in
cases/five_axis_cad.py.

Run: python3 make_cad.py [FOLDER]
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import five_axis_cad as shared  # noqa: E402
from five_axis_cad import CAST_IRON, POLYMER_CONCRETE, STEEL, around, box, cut, fuse, rod, write  # noqa: E402

HALF = 640                 # x of the side walls' inner faces
COLUMN_CELLS = ((-610, -330), (-300, -15), (15, 300), (330, 610))
BEAM_CELLS = ((-770, -512), (-488, -172), (-148, 148), (172, 488), (512, 770))
A_AXIS = (0, -50)          # y, z


def bed():
    """Polymer concrete U: floor, side walls, rear shoulder, seats of the two A housings."""
    body = box((-840, 840), (-550, 1250), (-1000, -100))
    trough = box((-600, 600), (-600, 485), (-600, 0))
    chip_channel = box((-180, 180), (-600, 400), (-760, -500))
    feet = [box(around(x, 90), around(y, 90), (-1040, -1000))
            for x in (-720, 720) for y in (-400, 350, 1100)]
    seats = [box(x, (-260, 260), (-650, -430)) for x in ((430, 650), (-650, -430))]
    return fuse(cut(body, trough, chip_channel), *feet, *seats)


def a_drive():
    """Right housing of the A axis: two bearing rings, the torque motor's stator between."""
    body = fuse(box((440, 590), (-230, 230), (-430, -50)), rod("x", A_AXIS, (440, 590), 230))
    return cut(body, rod("x", A_AXIS, (430, 600), 175), rod("x", A_AXIS, (475, 555), 190))


def a_support():
    """Left housing of the A axis: a bearing that floats along it."""
    body = fuse(box((-560, -440), (-190, 190), (-430, -50)), rod("x", A_AXIS, (-560, -440), 190))
    return cut(body, rod("x", A_AXIS, (-570, -430), 120))


def cradle():
    """Bridge between two discs with journals, drum with the C torque motor in the middle."""
    body = fuse(rod("z", (0, 0), (-400, -100), 270),
                box((-400, 400), (-200, 200), (-380, -100)),
                rod("x", A_AXIS, (380, 425), 230), rod("x", A_AXIS, (-425, -380), 230),
                rod("x", A_AXIS, (420, 585), 160), rod("x", A_AXIS, (445, 470), 174),
                rod("x", A_AXIS, (560, 585), 174), rod("x", A_AXIS, (-555, -420), 105),
                rod("x", A_AXIS, (-540, -460), 119))
    hollows = [box(x, (-150, 150), (-340, -140)) for x in ((290, 365), (-365, -290))]
    return cut(body, rod("x", A_AXIS, (470, 600), 110), rod("x", A_AXIS, (-600, -470), 60),
               *hollows,
               rod("z", (0, 0), (-150, -90), 181), rod("z", (0, 0), (-300, -150), 200),
               rod("z", (0, 0), (-350, -290), 161), rod("z", (0, 0), (-410, -340), 90))


write([("bed", bed, POLYMER_CONCRETE, "bed.step", ()),
       ("column", lambda: shared.column(HALF, COLUMN_CELLS, 50), CAST_IRON, "column.step", ()),
       ("y_slide", lambda: shared.y_slide(HALF, BEAM_CELLS), CAST_IRON, "y_slide.step", ()),
       ("x_slide", shared.x_slide, CAST_IRON, "x_slide.step", ()),
       ("z_slide", shared.z_slide, CAST_IRON, "z_slide.step", ()),
       ("spindle_housing", shared.spindle_housing, STEEL, "spindle_housing.step", ()),
       ("spindle_shaft", shared.spindle_shaft, STEEL, "spindle_shaft.obj", (25, 24)),
       ("a_drive", a_drive, CAST_IRON, "a_drive.step", ()),
       ("a_support", a_support, CAST_IRON, "a_support.step", ()),
       ("cradle", cradle, CAST_IRON, "cradle.step", ()),
       ("table", lambda: shared.table(300), STEEL, "table.stl", (40, 32)),
       ("x_screw", lambda: shared.x_screw(HALF), STEEL, "x_screw.step", ()),
       ("y_screw_left", lambda: shared.y_screw(60 - HALF), STEEL, "y_screw_left.step", ()),
       ("y_screw_right", lambda: shared.y_screw(HALF - 60), STEEL, "y_screw_right.step", ()),
       ("z_screw", shared.z_screw, STEEL, "z_screw.step", ())])
