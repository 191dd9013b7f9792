"""read_dream3d.py FILE.dream3d: prints as JSON what h5py finds. Groups are found by the rules of DAMASK's util.DREAM3D_base_group
and DREAM3D_cell_data_group: the group above _SIMPL_GEOMETRY/SPACING, and in it the group of a dataset of the geometry's size."""
import json
import sys

import h5py
import numpy


def plain(value):
    if isinstance(value, bytes):
        return value.decode()
    return value.tolist() if isinstance(value, (numpy.ndarray, numpy.generic)) else value


def described(dataset):
    values = dataset[()]
    texts = values.dtype.kind == "O"
    return {
        "type": "text" if texts else str(dataset.dtype),
        "shape": dataset.shape,
        "values": [v.decode() for v in values] if texts else values.ravel().tolist(),
        "attributes": {k: plain(v) for k, v in dataset.attrs.items()},
    }


with h5py.File(sys.argv[1], "r") as f:
    base = f.visit(lambda p: p.rsplit("/", 2)[0] if "_SIMPL_GEOMETRY/SPACING" in p else None)
    geometry = f[base + "/_SIMPL_GEOMETRY"]
    cells = tuple(geometry["DIMENSIONS"][()][::-1])
    cell_data = f[base].visititems(
        lambda p, o: p.split("/")[0] if isinstance(o, h5py.Dataset) and o.shape[:-1] == cells else None)
    out = {
        "root": {k: plain(v) for k, v in f.attrs.items()},
        "groups": sorted(f.keys()),
        "base": base,
        "cell_data": cell_data,
        "geometry": {k: described(v) for k, v in geometry.items()},
        "geometry_attributes": {k: plain(v) for k, v in geometry.attrs.items()},
        "matrices": {
            name: {
                "attributes": {k: plain(v) for k, v in group.attrs.items()},
                "arrays": {k: described(v) for k, v in group.items()},
            } for name, group in f[base].items() if name != "_SIMPL_GEOMETRY"
        },
    }
print(json.dumps(out))
