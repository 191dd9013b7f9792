"""Graphs from the provenance of files."""

from __future__ import annotations

from . import _core
from ._graph import Graph
from ._paths import path_text


def reproduce(file, *, allow_read=(), cache=True):
    """The graph that made a file which terrazzo wrote, or the report.json of a run. Nothing is run.

    Look at it, then graph.run(out="reproduced"). The file may come from a stranger: the graph may use built-in
    nodes only, and read only files whose content the provenance names, and those in the folders `allow_read`.
    graph.made_keys has the action keys of the nodes in the run that made the file; equal keys in run.nodes mean
    an equal computation. Arrays that the script gave are in the provenance if they are small.
    """
    graph = Graph(cache=cache)
    keys, reads = _core.open_made(graph, path_text(file), [path_text(f) for f in allow_read])
    graph.check()
    graph.made_keys, graph.made_from = keys, reads
    return graph
