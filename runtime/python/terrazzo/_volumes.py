"""Volumes of arrays and of OpenVDB's own Python module."""

from __future__ import annotations

import os
import tempfile

import numpy as np

from . import _core
from ._graph import Graph

_period = "period"  # metadata of grids: what Volume.resolution says


def _pyopenvdb():
    try:
        import pyopenvdb
    except ImportError as e:
        raise ImportError("OpenVDB's Python module is missing; Debian's package is python3-openvdb") from e
    return pyopenvdb


def volume(grids, voxel_size=None, *, name="density", period=None):
    """A Volume of an array (nx, ny, nz) of numbers or (nx, ny, nz, 3) of vectors, or of grids of pyopenvdb.

    An array needs voxel_size, the edge of a voxel in mm; one number, or one for each axis. All of its voxels are
    active. name: of its grid; "Cd" for colors; "id" for the numbers of particles, whole numbers, of which negative
    ones are binder. The other numbers become float32. Grids of pyopenvdb, one or several, keep their names,
    transforms (in mm) and inactive voxels.

    period: whether the volume tiles. True: the array is one period. (nx, ny, nz): the voxels (0, 0, 0) to
    (nx − 1, ny − 1, nz − 1) are. None: an array does not tile, and grids tile if they have the metadata `period`, as
    those of to_pyopenvdb() have. False: neither tiles. Copied.
    """
    if isinstance(grids, np.ndarray):
        if voxel_size is None:
            raise TypeError("an array needs voxel_size, the edge of a voxel in mm")
        made = _core.volume(grids, [float(v) for v in np.atleast_1d(voxel_size)], str(name))
        if period is True:
            period = grids.shape[:3]
    else:
        several = list(grids) if isinstance(grids, (list, tuple)) else [grids]
        for grid in several:
            if not hasattr(grid, "valueTypeName"):
                raise TypeError(f"expected an array or grids of pyopenvdb, not {type(grid).__name__}")
        if period is True:
            raise TypeError("the period of grids is (nx, ny, nz)")
        made, known = _of_pyopenvdb(several)
        if period is None:
            period = known
    return _core.with_period(made, [int(n) for n in period]) if period is not None and period is not False else made


def _of_pyopenvdb(grids):
    """The volume, and the period that the grids' metadata state, or None."""
    periods = {tuple(grid[_period]) if _period in grid.metadata else None for grid in grids}
    if len(periods) > 1:
        raise ValueError("the grids have different periods; pass period=(nx, ny, nz) or False")
    plain = []
    for grid in grids:
        if _period in grid.metadata:
            grid = grid.copy()  # shares the voxels
            del grid[_period]
        plain.append(grid)
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "volume.vdb")
        _pyopenvdb().write(file, plain)
        return Graph(cache=False).LoadVolume(path=file).volume.value(), periods.pop() if periods else None


def to_pyopenvdb(self):
    """The grids as a list of pyopenvdb grids, in mm. Copied. Needs Debian's package python3-openvdb.

    Whole numbers become floats, since that module reads no grids of whole numbers; those beyond 2²⁴ are an
    Error. If the volume tiles, each grid has the metadata `period`, (nx, ny, nz) voxels.
    """
    read = _pyopenvdb().readAll
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "volume.vdb")
        self.save(file)
        by_name = {grid.name: grid for grid in read(file)[0]}
    grids = [by_name[name] for name in self.grids]
    if all(self.resolution):
        for grid in grids:
            grid[_period] = self.resolution
    return grids


_core.Volume.to_pyopenvdb = to_pyopenvdb
