"""write_dream3d.py FILE.dream3d MODE: writes with h5py what DREAM3D 6 writes: FeatureIds = 1 + x + 4 y + 12 z on 4 x 3 x 2 voxels of
250 micrometers, EulerAngles = (x, y, z), Quats with four components, Mask (uint8). MODE: plain, chunked (zlib, shuffle,
checksum), big (FeatureIds as big-endian int64), latest (the newest form of HDF5) or two (a second, empty geometry before it)."""
import sys

import h5py
import numpy

path, mode = sys.argv[1:]
z, y, x = numpy.indices((2, 3, 4))
options = {"chunks": (1, 2, 3, 1), "compression": "gzip", "shuffle": True, "fletcher32": True} if mode == "chunked" else {}
with h5py.File(path, "w", libver="latest" if mode == "latest" else "earliest") as f:
    f.attrs["FileVersion"] = numpy.bytes_("7.0")
    if mode == "two":
        f["DataContainers/A/_SIMPL_GEOMETRY/DIMENSIONS"] = numpy.array([5, 5, 5], numpy.int64)
        f["DataContainers/A/_SIMPL_GEOMETRY/SPACING"] = numpy.ones(3, numpy.float32)
    base = "DataContainers/SyntheticVolumeDataContainer"
    f[base + "/_SIMPL_GEOMETRY/DIMENSIONS"] = numpy.array([4, 3, 2], numpy.int64)
    f[base + "/_SIMPL_GEOMETRY/ORIGIN"] = numpy.zeros(3, numpy.float32)
    f[base + "/_SIMPL_GEOMETRY/SPACING"] = numpy.full(3, 250, numpy.float32)
    ids = (1 + x + 4 * y + 12 * z)[..., None]
    cells = base + "/CellData/"
    f.create_dataset(cells + "FeatureIds", data=ids.astype(">i8" if mode == "big" else numpy.int32), **options)
    f[cells + "EulerAngles"] = numpy.stack([x, y, z], axis=-1).astype(numpy.float32)
    f[cells + "Quats"] = numpy.zeros((2, 3, 4, 4), numpy.float32)
    f[cells + "Mask"] = (x % 2).astype(numpy.uint8)[..., None]
    f[base + "/CellFeatureData/Phases"] = numpy.ones((25, 1), numpy.int32)
print("true")
