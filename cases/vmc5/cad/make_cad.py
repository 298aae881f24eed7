#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the bodies of the vmc5 machine (Debian: python3-gmsh); the tool side and the writing are in
cases/five_axis_cad.py.

Run: python3 make_cad.py [FOLDER]
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import five_axis_cad as shared  # noqa: E402
from five_axis_cad import CAST_IRON, POLYMER_CONCRETE, STEEL, around, box, cut, fuse, rod, write  # noqa: E402

HALF = 760                 # x of the side walls' inner faces
COLUMN_CELLS = ((-730, -390), (-360, -15), (15, 360), (390, 730))
BEAM_CELLS = ((-890, -612), (-588, -212), (-188, 188), (212, 588), (612, 890))


def bed():
    """Polymer concrete U: floor, side walls, rear shoulder with the seat of the B housing."""
    body = box((-960, 960), (-550, 1250), (-1000, -100))
    trough = box((-700, 700), (-600, 485), (-600, 0))
    seat = box((-370, 370), (400, 850), (-430, 0))
    chip_channel = box((-180, 180), (-600, 400), (-760, -500))
    body = cut(body, trough, seat, chip_channel)
    feet = [box(around(x, 90), around(y, 90), (-1040, -1000))
            for x in (-820, 820) for y in (-400, 350, 1100)]
    return fuse(body, *feet)


def b_housing():
    """Cast iron seat of the swivel axis: two bearing rings, the torque motor's stator between."""
    body = fuse(box((-320, 320), (490, 790), (-430, -50)), rod("y", (0, -50), (490, 790), 320))
    return cut(body, rod("y", (0, -50), (480, 800), 230), rod("y", (0, -50), (570, 700), 250))


def swivel():
    """Cantilever carrier of the table: hub in the B housing, bridge, drum with the C drive."""
    hub = fuse(rod("y", (0, -50), (425, 475), 290), rod("y", (0, -50), (470, 770), 205),
               rod("y", (0, -50), (500, 560), 229), rod("y", (0, -50), (710, 770), 229))
    body = fuse(hub, rod("z", (0, 0), (-400, -100), 270),
                box((-220, 220), (100, 475), (-400, -100)))
    return cut(body, rod("y", (0, -50), (520, 780), 150),
               box((-180, 180), (290, 425), (-360, -140)),
               rod("z", (0, 0), (-150, -90), 181), rod("z", (0, 0), (-300, -150), 200),
               rod("z", (0, 0), (-350, -290), 161), rod("z", (0, 0), (-410, -340), 90))


write([("bed", bed, POLYMER_CONCRETE, "bed.step", ()),
       ("column", lambda: shared.column(HALF, COLUMN_CELLS, 70), CAST_IRON, "column.step", ()),
       ("y_slide", lambda: shared.y_slide(HALF, BEAM_CELLS), CAST_IRON, "y_slide.step", ()),
       ("x_slide", shared.x_slide, CAST_IRON, "x_slide.step", ()),
       ("z_slide", shared.z_slide, CAST_IRON, "z_slide.step", ()),
       ("spindle_housing", shared.spindle_housing, STEEL, "spindle_housing.step", ()),
       ("spindle_shaft", shared.spindle_shaft, STEEL, "spindle_shaft.obj", (25, 24)),
       ("b_housing", b_housing, CAST_IRON, "b_housing.step", ()),
       ("swivel", swivel, CAST_IRON, "swivel.step", ()),
       ("table", lambda: shared.table(400), STEEL, "table.stl", (40, 32)),
       ("x_screw", lambda: shared.x_screw(HALF), STEEL, "x_screw.step", ()),
       ("y_screw_left", lambda: shared.y_screw(60 - HALF), STEEL, "y_screw_left.step", ()),
       ("y_screw_right", lambda: shared.y_screw(HALF - 60), STEEL, "y_screw_right.step", ()),
       ("z_screw", shared.z_screw, STEEL, "z_screw.step", ())])
