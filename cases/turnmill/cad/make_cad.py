#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the bodies of the turnmill machine (Debian: python3-gmsh); shapes and writing are in cases/five_axis_cad.py.

Machine coordinates in mm: x along the main spindle to the counter spindle, y to the rear, z up. The origin is the
centre of the main spindle's chuck face. At home the milling head stands vertically over the spindle axis, with the
mandrel's tip at (300, 0, 0).
Run: python3 make_cad.py [FOLDER]
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from five_axis_cad import (CAST_IRON, POLYMER_CONCRETE, STEEL, around, box, cut, fuse, occ, rod, turned,  # noqa: E402
                           write)

HEAD_X, PIVOT_Z = 300, 450       # B axis: parallel to y through these
X_SCREW = (10, 460)              # x, y of a vertical screw
Y_SCREW = (HEAD_X, 605)          # x, z
Z_SCREW = (750, -205)            # y, z


def bed():
    """Front with the seats of both headstocks, rear shoulder with the rails of Z and the screw's seats."""
    parts = [box((-950, 3000), (-450, 1000), (-1050, -650)), box((-950, 3000), (500, 1000), (-700, -250))]
    parts += [box((-500, 2900), around(y, 40), (-260, -200)) for y in (560, 890)]
    parts += [box(x, around(Z_SCREW[0], 45), (-260, -155)) for x in ((-500, -440), (2840, 2900))]
    parts += [box((-620, -500), around(Z_SCREW[0], 70), (-260, -130))]  # motor
    parts += [box(around(x, 100), around(y, 100), (-1100, -1050)) for x in (-800, 1025, 2850) for y in (-350, 900)]
    return cut(fuse(*parts), rod("x", Z_SCREW, (-495, 2910), 21))


def headstock(x, half, top, bores):
    """Box with a cavity in its foot and the bores of a spindle: ((low, high) in x, radius) each."""
    low, high = x
    body = box(x, (-half, half), (-650, top))
    cavity = box((low + 50, high - 50), (50 - half, half - 50), (-600, -260))
    return cut(body, cavity, *[rod("x", (0, 0), span, radius) for span, radius in bores])


def main_headstock():
    return headstock((-850, -150), 325, 325, [((-860, -140), 111), ((-300, -140), 131), ((-650, -350), 165)])


def counter_headstock():
    return headstock((2250, 2800), 300, 300, [((2240, 2810), 91), ((2240, 2350), 111), ((2420, 2640), 140)])


def main_spindle():
    """Hollow spindle with its rotor and a chuck of 630 mm."""
    return cut(fuse(rod("x", (0, 0), (-840, -140), 110), rod("x", (0, 0), (-290, -160), 130),
                    rod("x", (0, 0), (-640, -360), 155), rod("x", (0, 0), (-145, 0), 315)),
               rod("x", (0, 0), (-850, 10), 45))


def counter_spindle():
    """Hollow spindle with its rotor and a chuck of 400 mm."""
    return cut(fuse(rod("x", (0, 0), (2240, 2790), 90), rod("x", (0, 0), (2262, 2345), 110),
                    rod("x", (0, 0), (2430, 2630), 130), rod("x", (0, 0), (2100, 2245), 200)),
               rod("x", (0, 0), (2090, 2800), 35))


def column():
    """Portal on four carriages: two hollow posts with the X rails in front, a slot for the sleeve, a hollow bridge."""
    parts = [box(around(HEAD_X, 450), (500, 950), (-160, 1350))]
    parts += [box(around(HEAD_X + side * 350, 70), around(y, 35), (-200, -155)) for side in (-1, 1)
              for y in (560, 890)]
    parts += [box(around(HEAD_X + side * 400, 25), (460, 505), (-150, 1300)) for side in (-1, 1)]
    parts += [box(around(X_SCREW[0], 45), (415, 505), z) for z in ((-150, -95), (1250, 1310))]
    parts += [box(around(X_SCREW[0], 60), (400, 505), (1310, 1430))]    # motor
    parts += [box(around(HEAD_X, 60), around(Z_SCREW[0], 45), (-245, -155))]  # nut of the Z screw
    cavities = [box(around(HEAD_X + side * 332, 77), (540, 910), (-20, 1310)) for side in (-1, 1)]
    return cut(fuse(*parts), box(around(HEAD_X, 215), (490, 960), (-60, 950)),
               box(around(HEAD_X, 200), (540, 910), (990, 1310)), *cavities,
               rod("z", X_SCREW, (-160, 1310), 21), rod("x", Z_SCREW, (230, 370), 21))


def x_slide():
    """Plate with carriages behind, and the sleeve that the ram slides in."""
    parts = [box(around(HEAD_X, 430), (300, 420), around(PIVOT_Z, 260)),
             box(around(HEAD_X, 205), (300, 880), around(PIVOT_Z, 210))]
    parts += [box(around(HEAD_X + side * 400, 30), (415, 460), around(PIVOT_Z + up * 190, 60)) for side in (-1, 1)
              for up in (-1, 1)]
    parts += [box(around(X_SCREW[0], 45), (415, 498), around(PIVOT_Z, 60))]   # nut of the X screw
    inner = box(around(HEAD_X, 180), (290, 890), around(PIVOT_Z, 190))
    seats = [box(around(HEAD_X, 40), y, (575, 645)) for y in ((320, 360), (830, 870))]
    return cut(fuse(cut(fuse(*parts), inner), *seats), rod("z", X_SCREW, (380, 520), 21),
               rod("y", Y_SCREW, (310, 880), 17))


def ram():
    """Hollow ram of Y: carriages at its sides, nut on top, bore of the B axis in front."""
    parts = [box(around(HEAD_X, 150), (180, 1000), around(PIVOT_Z, 120))]
    parts += [box(span, y, around(PIVOT_Z, 40)) for span in ((HEAD_X + 145, HEAD_X + 180), (HEAD_X - 180, HEAD_X - 145))
              for y in ((400, 500), (720, 820))]
    parts += [box(around(HEAD_X, 40), (560, 640), (565, 632))]
    return cut(fuse(*parts), box(around(HEAD_X, 120), (320, 970), around(PIVOT_Z, 90)),
               rod("y", (HEAD_X, PIVOT_Z), (170, 330), 91), rod("y", Y_SCREW, (550, 650), 17))


def head():
    """Milling head on the B axis with the bores of the motor spindle."""
    body = fuse(box(around(HEAD_X, 140), (-140, 160), (200, 700)), rod("y", (HEAD_X, PIVOT_Z), (150, 300), 90))
    return cut(body, rod("y", (HEAD_X, PIVOT_Z), (200, 310), 55), rod("z", (HEAD_X, 0), (190, 310), 51),
               rod("z", (HEAD_X, 0), (300, 560), 66), rod("z", (HEAD_X, 0), (550, 670), 46))


def milling_spindle():
    """Shaft with holder and the mandrel of 125 mm length and 40 mm diameter."""
    shaft = turned([(0, 0), (20, 0), (20, 125), (32, 125), (32, 195), (50, 195), (50, 305), (58, 305), (58, 555),
                    (45, 555), (45, 655), (0, 655)])
    occ.translate(shaft, HEAD_X, 0, 0)
    return shaft


write([("bed", bed, POLYMER_CONCRETE, "bed.step", ()),
       ("main_headstock", main_headstock, CAST_IRON, "main_headstock.step", ()),
       ("counter_headstock", counter_headstock, CAST_IRON, "counter_headstock.step", ()),
       ("main_spindle", main_spindle, STEEL, "main_spindle.step", ()),
       ("counter_spindle", counter_spindle, STEEL, "counter_spindle.step", ()),
       ("column", column, CAST_IRON, "column.step", ()),
       ("x_slide", x_slide, CAST_IRON, "x_slide.step", ()),
       ("ram", ram, CAST_IRON, "ram.step", ()),
       ("head", head, CAST_IRON, "head.step", ()),
       ("milling_spindle", milling_spindle, STEEL, "milling_spindle.step", ()),
       ("x_screw", lambda: rod("z", X_SCREW, (-145, 1305), 20), STEEL, "x_screw.step", ()),
       ("y_screw", lambda: rod("y", Y_SCREW, (322, 868), 16), STEEL, "y_screw.step", ()),
       ("z_screw", lambda: rod("x", Z_SCREW, (-490, 2895), 20), STEEL, "z_screw.step", ())])
