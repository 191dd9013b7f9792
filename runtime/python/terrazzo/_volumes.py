"""Volumes of arrays and of OpenVDB's own Python module."""

from __future__ import annotations

import os
import tempfile

import numpy as np

from . import _core
from ._graph import Graph


def _pyopenvdb():
    try:
        import pyopenvdb
    except ImportError as e:
        raise ImportError("OpenVDB's Python module is missing; Debian's package is python3-openvdb") from e
    return pyopenvdb


def _loaded(write, extension, **parameters):
    """The volume that LoadVolume reads from a file that `write` makes."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "volume" + extension)
        write(file)
        return Graph(cache=False).LoadVolume(path=file, **parameters).volume.value()


def volume(grids, voxel_size=None, *, name="density"):
    """A Volume of an array (nx, ny, nz) of numbers, or of one or more grids of pyopenvdb.

    An array needs voxel_size, the edge of a voxel in mm; one number, or one for each axis. All of its voxels are
    active. name: of its grid; "id" for the numbers of particles, of which -1 is binder. Whole numbers stay
    whole. Grids of pyopenvdb keep their names, transforms (in mm) and inactive voxels. The volume does not tile, since
    neither says that it does. Copied.
    """
    if isinstance(grids, np.ndarray):
        if voxel_size is None:
            raise TypeError("an array needs voxel_size, the edge of a voxel in mm")
        spacing = [float(v) for v in np.atleast_1d(voxel_size)] * (3 if np.ndim(voxel_size) == 0 else 1)
        return _loaded(lambda file: np.save(file, np.asarray(grids), allow_pickle=False), ".npy", spacing=spacing,
                       grid=name, slope=1, intercept=0)
    several = list(grids) if isinstance(grids, (list, tuple)) else [grids]
    for grid in several:
        if not hasattr(grid, "valueTypeName"):
            raise TypeError(f"expected an array or grids of pyopenvdb, not {type(grid).__name__}")
    return _loaded(lambda file: _pyopenvdb().write(file, several), ".vdb")


def to_pyopenvdb(self):
    """The grids as a list of pyopenvdb grids, in mm. Copied. Needs Debian's package python3-openvdb.

    Whole numbers become floats, since that module reads no grids of whole numbers; those beyond 2²⁴ are an
    Error. The grids do not say that the volume tiles: `resolution` does.
    """
    read = _pyopenvdb().readAll
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "volume.vdb")
        self.save(file)
        return list(read(file)[0])


_core.Volume.to_pyopenvdb = to_pyopenvdb
