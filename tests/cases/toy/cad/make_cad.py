#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the bodies of the toy machine (mm, machine coordinates at home) beside this script:
boxes as .stl and .obj for the mesher, structured boxes with named surfaces as .inp and .msh."""
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
# Kuhn's division of a cell: tetrahedra that walk from corner 000 to 111, with positive volume.
WALKS = ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2))


def box_sides(low, high):
    """Two triangles a side, normals outward."""
    corner = [[(high if i >> a & 1 else low)[a] for a in range(3)] for i in range(8)]
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return corner, [t for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]


def prism(radius, low, high, sides):
    ring = [(radius * math.cos(2 * math.pi * i / sides), radius * math.sin(2 * math.pi * i / sides))
            for i in range(sides)]
    corner = [(x, y, low) for x, y in ring] + [(x, y, high) for x, y in ring]
    triangles = []
    for i in range(sides):
        j = (i + 1) % sides
        triangles += [(i, j, sides + j), (i, sides + j, sides + i)]
    for i in range(1, sides - 1):
        triangles += [(0, i + 1, i), (sides, sides + i, sides + i + 1)]
    return corner, triangles


def write_stl(name, corner, triangles):
    lines = [f"solid {name}"]
    for t in triangles:
        lines.append("facet normal 0 0 0\nouter loop")
        lines += ["vertex {:g} {:g} {:g}".format(*corner[i]) for i in t]
        lines.append("endloop\nendfacet")
    (HERE / f"{name}.stl").write_text("\n".join(lines) + f"\nendsolid {name}\n")


def write_obj(name, corner, triangles):
    lines = ["v {:.6g} {:.6g} {:.6g}".format(*c) for c in corner]
    lines += ["f {} {} {}".format(*(i + 1 for i in t)) for t in triangles]
    (HERE / f"{name}.obj").write_text("\n".join(lines) + "\n")


def structured(xs, ys, zs):
    """Nodes (1-based labels) and tetrahedra of a box with grid lines xs, ys, zs."""
    size = (len(xs), len(ys), len(zs))
    label = lambda i, j, k: 1 + (k * size[1] + j) * size[0] + i
    nodes = [(x, y, z) for z in zs for y in ys for x in xs]
    tets = []
    for k in range(size[2] - 1):
        for j in range(size[1] - 1):
            for i in range(size[0] - 1):
                for w, walk in enumerate(WALKS):
                    at, tet = [i, j, k], [label(i, j, k)]
                    for axis in walk:
                        at[axis] += 1
                        tet.append(label(*at))
                    if w >= 3:  # odd walks turn the other way
                        tet[1], tet[2] = tet[2], tet[1]
                    tets.append(tet)
    return nodes, tets


def write_inp(name, grid, groups):
    nodes, tets = structured(*grid)
    lines = ["*NODE"] + ["{}, {:g}, {:g}, {:g}".format(i + 1, *n) for i, n in enumerate(nodes)]
    lines += ["*ELEMENT, TYPE=C3D4, ELSET=BODY"]
    lines += ["{}, {}, {}, {}, {}".format(i + 1, *t) for i, t in enumerate(tets)]
    for group, holds in groups.items():
        lines.append(f"*NSET, NSET={group}")
        lines += [str(i + 1) for i, n in enumerate(nodes) if holds(*n)]
    (HERE / f"{name}.inp").write_text("\n".join(lines) + "\n")


def write_msh(name, grid, groups):
    """Format 2.2; a group is the boundary triangles whose corners all satisfy its condition."""
    nodes, tets = structured(*grid)
    count = {}
    for t in tets:
        for side in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
            triangle = tuple(t[i] for i in side)
            count.setdefault(frozenset(triangle), []).append(triangle)
    outside = [v[0] for v in count.values() if len(v) == 1]
    elements = []
    for tag, holds in enumerate(groups.values(), 1):
        elements += [(2, tag, t) for t in outside if all(holds(*nodes[i - 1]) for i in t)]
    body = len(groups) + 1
    elements += [(4, body, t) for t in tets]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(body)]
    lines += [f'2 {tag} "{group}"' for tag, group in enumerate(groups, 1)] + [f'3 {body} "{name}"']
    lines += ["$EndPhysicalNames", "$Nodes", str(len(nodes))]
    lines += ["{} {:g} {:g} {:g}".format(i + 1, *n) for i, n in enumerate(nodes)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    for i, (kind, tag, corners) in enumerate(elements, 1):
        lines.append(f"{i} {kind} 2 {tag} {tag} " + " ".join(map(str, corners)))
    lines.append("$EndElements")
    (HERE / f"{name}.msh").write_text("\n".join(lines) + "\n")


write_stl("bed", *box_sides((-250, -150, -350), (250, 500, -250)))
write_stl("column", *box_sides((-200, 330, -250), (200, 490, 250)))
write_stl("swivel", *box_sides((-80, -80, -110), (80, 150, -40)))
write_obj("post", *box_sides((-120, 150, -250), (120, 230, 70)))
write_obj("table", *prism(75, -40, 0, 16))
write_inp("y_slide", ((-200, -100, 0, 100, 200), (90, 180, 275, 370, 450), (250, 290, 330)), {
    "CARRIAGES": lambda x, y, z: z == 250 and y >= 370,
    "FRONT": lambda x, y, z: y == 90,
    "TOP": lambda x, y, z: z == 330})
write_inp("x_slide", ((-50, 0, 50), (30, 60, 90), (150, 200, 250, 290, 330, 350, 450)), {
    "CARRIAGES": lambda x, y, z: y == 90 and 250 <= z <= 330,
    "NUT": lambda x, y, z: y == 90 and 330 <= z <= 350,
    "RAILS": lambda x, y, z: y == 30})
write_inp("x_screw", ((-180, -120, -60, 0, 60, 120, 180), (90, 110), (330, 350)), {
    "THREAD": lambda x, y, z: y == 90,
    "SEATS": lambda x, y, z: z == 330})
write_msh("z_slide", ((-40, 0, 40), (-30, 0, 30), (120, 160, 200, 260, 320, 420)), {
    "carriages": lambda x, y, z: y == 30 and 200 <= z <= 320,
    "nose": lambda x, y, z: z == 120,
    "jacket": lambda x, y, z: abs(x) == 40 and z <= 320})
