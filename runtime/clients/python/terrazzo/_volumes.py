"""Volumes of arrays and of OpenVDB's own Python module."""

from __future__ import annotations

import os
import tempfile

import numpy as np

from . import _core
from ._graph import Graph

_period = "period"  # metadata of grids: what Volume.resolution says
_extent = ("extent_min", "extent_max")  # and the first and last voxel of a volume that does not tile


def _pyopenvdb():
    try:
        import pyopenvdb
    except ImportError as e:
        raise ImportError("OpenVDB's Python module is missing; Debian's package is python3-openvdb") from e
    return pyopenvdb


def volume(grids, voxel_size=None, *, name="density", period=None):
    """A Volume of an array (nx, ny, nz) of numbers or (nx, ny, nz, 3) of vectors, or of grids of pyopenvdb.

    An array needs voxel_size, the edge of a voxel in mm; one number, or one for each axis. The volume is the whole
    array: element [i, j, k] is the voxel (i, j, k), with x to the right, y to the front and z up, and its center at
    (i + ½, j + ½, k + ½) · voxel_size. Pictures are arrays [row, column] with the first row at the top; turn a stack
    of them with np.transpose(stack[:, ::-1], (2, 1, 0)). name: of its grid; "Cd" for colors; "id" for the numbers of particles, whole numbers, of which negative
    ones are binder. The other numbers become float32; whole numbers that float32 cannot hold are an Error. Grids of pyopenvdb, one or several, keep their names,
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
    extents = [tuple(tuple(grid[name]) for name in _extent if name in grid.metadata) for grid in grids]
    if len(set(extents)) > 1:
        raise ValueError("the grids have different extents; delete their metadata extent_min and extent_max")
    plain = []
    for grid in grids:
        noted = [name for name in (_period, *_extent) if name in grid.metadata]
        if noted:
            grid = grid.copy()  # shares the voxels
            for name in noted:
                del grid[name]
        plain.append(grid)
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "volume.vdb")
        # LoadVolume reads the extent from the file's metadata.
        _pyopenvdb().write(file, plain, metadata=dict(zip(_extent, extents[0])) if extents else {})
        return Graph(cache=False).LoadVolume(path=file).volume.value(), periods.pop() if periods else None


def to_pyopenvdb(self):
    """The grids as a list of pyopenvdb grids, in mm. Copied. Needs Debian's package python3-openvdb.

    Whole numbers become floats, since that module reads no grids of whole numbers; those beyond 2²⁴ are an
    Error. If the volume tiles, each grid has the metadata `period`, (nx, ny, nz) voxels. If it does not, and its
    extent is known, `extent_min` and `extent_max` are its first and last voxel.
    """
    read = _pyopenvdb().readAll
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "volume.vdb")
        self.save(file)
        found, about = read(file)
        by_name = {grid.name: grid for grid in found}
    grids = [by_name[name] for name in self.grids]
    for grid in grids:
        if all(self.resolution):
            grid[_period] = self.resolution
        for name in _extent:
            if name in about:
                grid[name] = about[name]
    return grids


_core.Volume.to_pyopenvdb = to_pyopenvdb
