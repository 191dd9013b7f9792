"""read_inp.py FILE.inp: prints what meshio finds as JSON."""
import json
import sys

import meshio

mesh = meshio.read(sys.argv[1])
print(json.dumps({
    "points": mesh.points.tolist(),
    "cells": [[block.type, block.data.tolist()] for block in mesh.cells],
    "point_sets": {name: [int(i) for i in ids] for name, ids in mesh.point_sets.items()},
    # of sets that list elements, the number of elements in each block
    "cell_sets": {name: [len(part) for part in parts] for name, parts in mesh.cell_sets.items()},
}))
