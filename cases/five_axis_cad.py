# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes, tool side and files that ac5 and vmc5 share, by Gmsh's OpenCASCADE kernel (Debian: python3-gmsh).

Machine coordinates in mm, all axes at home: X = Y = 0 in the middle of their travel, Z = 0 at the bottom of its travel;
the table top's centre is the origin and the tool tip stands at (0, 0, 100). x right, y to the rear, z up. Files: one
STEP a body, but the table as binary STL and the spindle shaft as OBJ, so that both ways of import are used.
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


# --- tool side -------------------------------------------------------------------------------

SCREW_RADIUS, NUT_RADIUS = 20, 21
Y_SCREW_Z = 600
X_SCREW = (343, 930)       # y, z
Z_SCREW = (0, 188)         # x, y
Y_CARRIAGES = (445, 825)   # y of the crossbeam's carriages
X_CARRIAGES, X_RAILS = (-200, 200), (740, 1120)    # x of the carriages, z of the rails
Z_CARRIAGES, Z_RAILS = (635, 985), (-120, 120)     # z of the carriages, x of the rails


def column(half, cells, frame):
    """Cast iron walls left, right and rear, with the Y rails on top and the Y screws' bearings.

    half: x of the side walls' inner faces; cells: (low, high) in x of the rear wall; frame: width between the end of a
    cell and its opening to the rear.
    """
    parts, cavities = [], []
    for side in (1, -1):
        def x(low, high):
            return (half + low, half + high) if side > 0 else (-half - high, -half - low)
        parts += [box(x(0, 180), (20, 1240), (-100, 600)),
                  box(x(55, 125), (40, 1220), (600, 635)),          # rail
                  box(x(-110, 0), (120, 180), (550, 650)),          # support bearing
                  box(x(-110, 0), (1050, 1110), (550, 650)),        # fixed bearing
                  box(x(-125, 0), (1110, 1220), (535, 665))]        # motor
        for low, high in ((50, 330), (360, 640), (670, 950), (980, 1210)):
            cavities += [box(x(30, 150), (low, high), (-60, 560)),
                         box(x(140, 190), (low + 50, high - 50), (80, 420))]
        cavities += [rod("y", (side * (half - 60), Y_SCREW_Z), (100, 1110), NUT_RADIUS)]
    parts += [box((-half, half), (1040, 1240), (-100, 480))]
    for low, high in cells:
        cavities += [box((low, high), (1070, 1210), (-60, 440)),
                     box((low + frame, high - frame), (1200, 1250), (60, 320))]
    return cut(fuse(*parts), *cavities)


def y_slide(half, cells):
    """Crossbeam: ribbed box on four carriages, X rails, screw bearings and motor in front.

    half: as of the column; cells: (low, high) in x.
    """
    parts = [box((-half - 160, half + 160), (385, 885), (680, 1180))]
    for x in (-half - 90, half + 90):
        parts += [box(around(x, 30), around(y, 60), (635, 690)) for y in Y_CARRIAGES]
    nuts = (60 - half, half - 60)
    for x in nuts:
        parts += [box(around(x, 45), (565, 685), (555, 680))]       # nut housing
    parts += [box((70 - half, half - 70), (350, 385), around(z, 35)) for z in X_RAILS]
    parts += [box((half - 70, half - 10), (300, 385), around(X_SCREW[1], 50)),
              box((10 - half, 70 - half), (300, 385), around(X_SCREW[1], 50)),
              box((half - 10, half + 120), (280, 405), around(X_SCREW[1], 65))]  # motor
    cavities = []
    for low, high in cells:
        cavities += [box((low, high), (425, 855), (710, 1150)),
                     box((low + 50, high - 50), (845, 900), (820, 1040))]
    cavities += [rod("x", X_SCREW, (10 - half, half - 10), NUT_RADIUS)]
    cavities += [rod("y", (x, Y_SCREW_Z), (560, 690), NUT_RADIUS) for x in nuts]
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


def table(radius):
    return turned([(0, 0), (radius, 0), (radius, -60), (180, -60), (180, -150), (160, -150),
                   (160, -350), (110, -350), (110, -80), (0, -80)])


def x_screw(half):
    return rod("x", X_SCREW, (10 - half, half - 10), SCREW_RADIUS)


def y_screw(x):
    return rod("y", (x, Y_SCREW_Z), (120, 1110), SCREW_RADIUS)


def z_screw():
    return rod("z", Z_SCREW, (560, 1610), SCREW_RADIUS)


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


def write(bodies):
    """Writes the bodies into the folder of the first argument, else beside the script that calls.

    bodies: name, function that makes it, density in kg/m3, file; of a surface file: longest edge in mm, edges on a full
    circle.
    """
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(sys.argv[0]))
    os.makedirs(folder, exist_ok=True)
    gmsh.initialize([sys.argv[0]])
    gmsh.option.setNumber("General.Terminal", 0)
    total = 0.0
    print("%-16s %9s %9s %6s" % ("body", "dm3", "kg", "faces"))
    for name, make, density, file, facets in bodies:
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
