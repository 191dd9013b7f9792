"""Terrazzo: from a photograph of an aggregate to particle sizes and a 3D material.

    import terrazzo as t
    g = t.Graph()                                       # or t.load("aggregate.yaml", photo="granite.jpg")
    photo = g.LoadImage(path="granite.jpg", pixel_size=0.05)
    seg = g.Segment(image=photo.image)
    profiles = seg.profiles.value()                     # evaluates; Ctrl-C stops
    profiles.area                                       # numpy, read-only, without a copy
    g.save("granite.yaml")

help(t.nodes.Segment) describes a node type; docs/python.md is the manual.
"""

import atexit as _atexit
import os as _os
import warnings as _warnings

from ._errors import Canceled, Diagnostic, Error, NodeWarning
from . import _core
from ._core import (Detail, Image, KMatrix, Labels, Node, Output, Particles, Profiles, Shapes, SizeDistribution,
                    Strokes, Table, Value, Volume, metric, progress, warn)
from ._graph import Graph, load
from ._run import Run, end_all_runs as _end_all_runs
from ._nodes import nodes
from ._values import image, labels, mesh, sizes, table
from ._volumes import volume
from ._define import Range, node
from ._library import library, materials
from ._sweep import Sweep, read_sweep
from ._reproduce import reproduce
from . import cache

__version__ = _core.version

_atexit.register(_end_all_runs)
_os.register_at_fork(after_in_child=_core.leave_without_exit_handlers)
for _problem in _core.plugin_problems():
    _warnings.warn(str(_problem), NodeWarning)

__all__ = [
    "Canceled", "Detail", "Diagnostic", "Error", "Graph", "Image", "KMatrix", "Labels", "Node", "NodeWarning", "Output",
    "Particles", "Profiles", "Range", "Run", "Shapes", "SizeDistribution", "Strokes", "Sweep", "Table", "Value", "Volume",
    "cache", "image", "labels", "library", "load", "materials", "mesh", "metric", "node", "nodes", "progress",
    "read_sweep", "reproduce", "sizes", "table", "volume", "warn",
]
