"""read_vdb.py FILE.vdb: reads all grids with Debian's pyopenvdb and prints names, types and some values as JSON."""
import json
import sys

import pyopenvdb

grids, metadata = pyopenvdb.readAll(sys.argv[1])
print(json.dumps({
    "metadata": sorted(metadata.keys()),
    "grids": {
        g.name: {
            "type": g.valueTypeName,
            "active": g.activeVoxelCount(),
            "background": g.background,
            "values": [g.getConstAccessor().getValue((i, i, i)) for i in range(16)],
        } for g in grids
    },
}))
