#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the bodies of the ac5 machine with Gmsh's OpenCASCADE kernel (Debian: python3-gmsh).

Machine coordinates in mm, all axes at home: X = Y = 0 in the middle of their travel, Z = 0 at the
bottom of its travel; the table top's centre is the origin and the tool tip stands at (0, 0, 100).
x right, y to the rear, z up. Written beside this script: one STEP a body, but the table as binary
STL and the spindle shaft as OBJ, so that both ways of import are used.
Run: python3 make_cad.py [FOLDER]
"""
import math
import os
import sys

import gmsh

occ = gmsh.model.occ
CAST_IRON, STEEL, POLYMER_CONCRETE = 7200.0, 7850.0, 2350.0

# --- shapes ---------------------------------------------------------------------------------


def box(x, y, z):
    """Box from three (low, high) pairs."""
    return [(3, occ.addBox(x[0], y[0], z[0], x[1] - x[0], y[1] - y[0], z[1] - z[0]))]


def rod(axis, centre, span, radius):
    """Cylinder along 'x', 'y' or 'z'; centre: the other two coordinates in the order x, y, z."""
    length = span[1] - span[0]
    start, step = {
        "x": ((span[0], centre[0], centre[1]), (length, 0, 0)),
        "y": ((centre[0], span[0], centre[1]), (0, length, 0)),
        "z": ((centre[0], centre[1], span[0]), (0, 0, length)),
    }[axis]
    return [(3, occ.addCylinder(*start, *step, radius))]


def turned(profile):
    """Solid of revolution about z from (radius, z) corners."""
    points = [occ.addPoint(r, 0, z) for r, z in profile]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    return [e for e in occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, 2 * math.pi) if e[0] == 3]


def fuse(*parts):
    first, others = parts[0], [e for p in parts[1:] for e in p]
    return occ.fuse(first, others)[0]


def cut(body, *tools):
    return occ.cut(body, [e for t in tools for e in t])[0]


def around(centre, half):
    return (centre - half, centre + half)


# --- bodies ---------------------------------------------------------------------------------

SCREW_RADIUS, NUT_RADIUS = 20, 21
Y_SCREW = (580, 600)       # x (both sides), z
X_SCREW = (343, 930)       # y, z
Z_SCREW = (0, 188)         # x, y
Y_CARRIAGES = (445, 825)   # y of the crossbeam's carriages
X_CARRIAGES, X_RAILS = (-200, 200), (740, 1120)    # x of the carriages, z of the rails
Z_CARRIAGES, Z_RAILS = (635, 985), (-120, 120)     # z of the carriages, x of the rails
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


def column():
    """Cast iron walls left, right and rear, with the Y rails on top and the Y screws' bearings."""
    parts, cavities = [], []
    for side in (1, -1):
        def x(low, high):
            return (low, high) if side > 0 else (-high, -low)
        parts += [box(x(640, 820), (20, 1240), (-100, 600)),
                  box(x(695, 765), (40, 1220), (600, 635)),         # rail
                  box(x(530, 640), (120, 180), (550, 650)),         # support bearing
                  box(x(530, 640), (1050, 1110), (550, 650)),       # fixed bearing
                  box(x(515, 640), (1110, 1220), (535, 665))]       # motor
        for low, high in ((50, 330), (360, 640), (670, 950), (980, 1210)):
            cavities += [box(x(670, 790), (low, high), (-60, 560)),
                         box(x(780, 830), (low + 50, high - 50), (80, 420))]
        cavities += [rod("y", (side * Y_SCREW[0], Y_SCREW[1]), (100, 1110), NUT_RADIUS)]
    parts += [box((-640, 640), (1040, 1240), (-100, 480))]
    for low, high in ((-610, -330), (-300, -15), (15, 300), (330, 610)):
        cavities += [box((low, high), (1070, 1210), (-60, 440)),
                     box((low + 50, high - 50), (1200, 1250), (60, 320))]
    return cut(fuse(*parts), *cavities)


def y_slide():
    """Crossbeam: ribbed box on four carriages, X rails, screw bearings and motor in front."""
    parts = [box((-800, 800), (385, 885), (680, 1180))]
    for x in (-730, 730):
        parts += [box(around(x, 30), around(y, 60), (635, 690)) for y in Y_CARRIAGES]
    for x in (-580, 580):
        parts += [box(around(x, 45), (565, 685), (555, 680))]       # nut housing
    parts += [box((-570, 570), (350, 385), around(z, 35)) for z in X_RAILS]
    parts += [box((570, 630), (300, 385), around(X_SCREW[1], 50)),
              box((-630, -570), (300, 385), around(X_SCREW[1], 50)),
              box((630, 760), (280, 405), around(X_SCREW[1], 65))]  # motor
    cavities = []
    for low, high in ((-770, -512), (-488, -172), (-148, 148), (172, 488), (512, 770)):
        cavities += [box((low, high), (425, 855), (710, 1150)),
                     box((low + 50, high - 50), (845, 900), (820, 1040))]
    cavities += [rod("x", X_SCREW, (-630, 630), NUT_RADIUS)]
    cavities += [rod("y", (x, Y_SCREW[1]), (560, 690), NUT_RADIUS) for x in (-580, 580)]
    return cut(fuse(*parts), *cavities)


def x_slide():
    """Saddle: tall plate, carriages behind, Z rails, screw bearings and motor."""
    parts = [box((-270, 270), (225, 305), (560, 1610))]
    parts += [box(around(x, 60), (295, 350), around(z, 30)) for x in X_CARRIAGES for z in X_RAILS]
    parts += [box((-60, 60), (300, 378), around(X_SCREW[1], 45))]   # nut of the X screw
    parts += [box(around(x, 35), (190, 225), (580, 1590)) for x in Z_RAILS]
    parts += [box((-50, 50), (155, 225), (560, 610)),
              box((-50, 50), (155, 225), (1550, 1610)),
              box((-60, 60), (225, 345), (1610, 1740))]             # motor, belt drive
    pockets = [box(x, (255, 320), z) for x in ((-240, -20), (20, 240))
               for z in ((1215, 1385), (1415, 1580))]
    return cut(fuse(*parts), rod("x", X_SCREW, (-70, 70), NUT_RADIUS),
               rod("z", Z_SCREW, (550, 1610), NUT_RADIUS), *pockets)


def z_slide():
    """Ram: box that holds the spindle housing, carriages behind."""
    parts = [box((-170, 170), (-150, 150), (520, 1100))]
    parts += [box(around(x, 30), (140, 190), around(z, 55)) for x in Z_RAILS for z in Z_CARRIAGES]
    parts += [box((-45, 45), (150, 222), (750, 870))]               # nut of the Z screw
    cavity = box((-140, 140), (-120, 120), (570, 1065))
    top = box((-80, 80), (-70, 70), (1050, 1110))
    return cut(fuse(*parts), cavity, top, rod("z", (0, 0), (500, 575), 110),
               rod("z", Z_SCREW, (740, 880), NUT_RADIUS))


def spindle_housing():
    return turned([(51, 255), (115, 255), (115, 480), (155, 480), (155, 520), (108, 520),
                   (108, 570), (96, 570), (96, 880), (46, 880), (46, 780), (66, 780),
                   (66, 350), (51, 350)])


def spindle_shaft():
    """Shaft with holder and a test mandrel as tool; tip at z = 100."""
    return turned([(0, 100), (20, 100), (20, 200), (32, 200), (32, 250), (50, 250), (50, 350),
                   (58, 350), (58, 760), (45, 760), (45, 870), (0, 870)])


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


def table():
    return turned([(0, 0), (300, 0), (300, -60), (180, -60), (180, -150), (160, -150),
                   (160, -350), (110, -350), (110, -80), (0, -80)])


def x_screw():
    return rod("x", X_SCREW, (-630, 630), SCREW_RADIUS)


def y_screw_left():
    return rod("y", (-Y_SCREW[0], Y_SCREW[1]), (120, 1110), SCREW_RADIUS)


def y_screw_right():
    return rod("y", Y_SCREW, (120, 1110), SCREW_RADIUS)


def z_screw():
    return rod("z", Z_SCREW, (560, 1610), SCREW_RADIUS)


# body, density in kg/m3, file; of a surface file: longest edge in mm, edges on a full circle
BODIES = [(bed, POLYMER_CONCRETE, "bed.step", ()), (column, CAST_IRON, "column.step", ()),
          (y_slide, CAST_IRON, "y_slide.step", ()), (x_slide, CAST_IRON, "x_slide.step", ()),
          (z_slide, CAST_IRON, "z_slide.step", ()),
          (spindle_housing, STEEL, "spindle_housing.step", ()),
          (spindle_shaft, STEEL, "spindle_shaft.obj", (25, 24)),
          (a_drive, CAST_IRON, "a_drive.step", ()), (a_support, CAST_IRON, "a_support.step", ()),
          (cradle, CAST_IRON, "cradle.step", ()), (table, STEEL, "table.stl", (40, 32)),
          (x_screw, STEEL, "x_screw.step", ()), (y_screw_left, STEEL, "y_screw_left.step", ()),
          (y_screw_right, STEEL, "y_screw_right.step", ()), (z_screw, STEEL, "z_screw.step", ())]

# --- files ----------------------------------------------------------------------------------


def write_obj(path, name):
    """Gmsh writes no OBJ: corners and triangles by hand."""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    number = {tag: i + 1 for i, tag in enumerate(tags)}
    with open(path, "w", encoding="ascii") as out:
        out.write(f"# {name}, mm\no {name}\n")
        for i in range(len(tags)):
            out.write("v %.6g %.6g %.6g\n" % tuple(xyz[3 * i:3 * i + 3]))
        for _, face in gmsh.model.getEntities(2):
            corners = gmsh.model.mesh.getElementsByType(2, face)[1]
            for i in range(0, len(corners), 3):
                out.write("f %d %d %d\n" % tuple(number[c] for c in corners[i:i + 3]))


def write_surface(path, name, size, per_turn):
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", per_turn)
    gmsh.model.mesh.generate(2)
    if path.endswith(".obj"):
        write_obj(path, name)
        return
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.write(path)


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    os.makedirs(folder, exist_ok=True)
    gmsh.initialize([sys.argv[0]])
    gmsh.option.setNumber("General.Terminal", 0)
    total = 0.0
    print("%-16s %9s %9s %6s" % ("body", "dm3", "kg", "faces"))
    for make, density, file, facets in BODIES:
        name = make.__name__
        gmsh.model.add(name)
        make()
        occ.synchronize()
        solids = gmsh.model.getEntities(3)
        if len(solids) != 1:
            raise SystemExit(f"{name}: {len(solids)} solids instead of one")
        # The profile of a turned solid would stay as a loose face.
        kept = {tag for _, tag in gmsh.model.getBoundary(solids, oriented=False)}
        occ.remove([e for e in gmsh.model.getEntities(2) if e[1] not in kept], recursive=True)
        occ.synchronize()
        volume = occ.getMass(*solids[0])
        mass = volume * 1e-9 * density
        total += mass
        print("%-16s %9.1f %9.0f %6d" % (name, volume * 1e-6, mass, len(kept)))
        path = os.path.join(folder, file)
        if facets:
            write_surface(path, name, *facets)
        else:
            gmsh.write(path)
        gmsh.model.remove()
    print("%-16s %9s %9.0f" % ("total", "", total))
    gmsh.finalize()


if __name__ == "__main__":
    main()
