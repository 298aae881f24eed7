# SPDX-License-Identifier: GPL-3.0-or-later
"""One time step from model.rom.h5 by its format in docs/reference/result_files.md, without the program.

usage: read_model.py model.rom.h5 step.json
step.json has p, q, initial_K and step_s; the answer goes to standard output as JSON."""
import json
import sys

import h5py
import numpy as np

with open(sys.argv[2]) as file:
    step = json.load(file)
p, q, h = np.array(step["p"]), np.array(step["q"]), step["step_s"]

with h5py.File(sys.argv[1], "r") as model:
    head = {key: (value.decode() if isinstance(value, bytes) else value) for key, value in model.attrs.items()}
    E = model["system/capacity"][:]
    K = model["system/conduction"][:] + np.tensordot(p, model["system/terms"][:], 1)
    S = model["system/inputs"][:]
    sensors = model["system/sensors"][:]
    x = model["system/one_kelvin"][:] * step["initial_K"]
    tool = model["outputs/tool"][:]
    checksums = all(model[name].fletcher32 for name in ("system/capacity", "system/terms", "outputs/tool"))

# SDIRK2 (Alexander 1977): E x' + K x = S q
gamma = 1 - 1 / np.sqrt(2)
implicit = E + gamma * h * K
heat = gamma * h * (S @ q)
first = np.linalg.solve(implicit, E @ x + heat)
start = x + (1 - gamma) / gamma * (first - x)
x = np.linalg.solve(implicit, E @ start + heat)

print(json.dumps({"format": str(head["format"]), "version": int(head["version"]), "order": int(head["order"]),
                  "checksums": bool(checksums),
                  "sensors_K": (sensors @ x).tolist(), "tool_um": (1e6 * tool @ x).tolist()}))
