"""Arrays of a graph as files beside its graph file."""

from __future__ import annotations

import os

import numpy as np

from . import _core
from ._errors import Error
from ._graph import Graph


def write_arrays(graph, folder):
    """Writes the values that were given to the graph, and returns for each node what stands in for it in the file:
    (type, output, parameters). Each file is read again, so that nothing is lost unnoticed."""
    out = {}
    for name in graph._names():
        node = graph[name]
        if not node.type.startswith("Given"):
            continue
        value = graph._given_value(name)
        if value.type not in _writers:
            _not_savable(name, f"no node reads {value.type} from a file")
        _require_free(graph, folder, name)
        os.makedirs(folder, exist_ok=True)
        kind, port, parameters = _writers[value.type](value, os.path.join(folder, name))
        if Graph(cache=False)._add(kind, dict(parameters)).output(port).value() != value:
            _not_savable(name, f"{parameters.get('path', kind)} does not give the same value when it is read again")
        out[name] = kind, port, parameters
    return out


def _require_free(graph, folder, name):
    """Raises Error if a file that may be written for this node is one that the graph reads."""
    stem = os.path.join(folder, name)
    for ending in (".exr", ".tif", ".vdb", ".json", "_classes.exr"):
        graph._require_other_file(stem + ending)
    for sections in (stem, stem + "_classes"):
        if os.path.isdir(sections):
            for file in os.listdir(sections):
                graph._require_other_file(os.path.join(sections, file))


def _not_savable(node, why):
    _core.raise_error("not-savable", f"the arrays of the node {node} cannot be saved: {why}",
                      "write the value with a node of your graph, and load it", node, "")


def _sections(value, stem, extension, count):
    """Writes an image or labels, and returns the path or the glob that reads it. Stacks have a folder of their own, so
    that the glob matches no other files."""
    if count == 1:
        value.save(stem + extension)
        return stem + extension
    os.makedirs(stem, exist_ok=True)
    value.save(os.path.join(stem, "section" + extension))
    return os.path.join(stem, "section_*" + extension)


def _image(value, stem):
    path = _sections(value, stem, ".exr", value.sections)
    return "LoadImage", "image", {"path": path, "pixel_size": value.pixel_size}


def _labels(value, stem):
    parameters = {"path": _sections(value, stem, ".tif", value.sections), "pixel_size": value.pixel_size}
    if value.classes.any():
        classes = np.concatenate([[0], value.classes + 1])[value.ids].astype(np.float32)  # exact: at most 1,000,001
        image = _core.image(np.repeat(classes[..., None], 3, -1), 1.0, False)
        parameters["classes"] = _sections(image, stem + "_classes", ".exr", value.sections)
    return "LoadLabels", "labels", parameters


def _volume(value, stem):
    graph = Graph(cache=False)
    graph.Export(volume=value, path=os.path.basename(stem) + ".vdb", id_type="int32")
    graph.start(out=os.path.dirname(stem)).wait(False)._settled(report=False)
    return "LoadVolume", "volume", {"path": stem + ".vdb"}


def _json(kind, port):
    """Writes what Export writes to .json, for the node of this type and its output."""
    def write(value, stem):
        value.save(stem + ".json")
        return kind, port, {"path": stem + ".json"}
    return write


def _sizes(value, stem):
    """What t.sizes makes is in the graph file itself, other distributions in a file."""
    write = _json("LoadDistribution", "distribution")
    if len(value.entries) != 1:
        return write(value, stem)
    entry, edges = value.entries[0], value.class_edges
    try:
        made = _core.sizes(edges, entry.N_V, entry.low, entry.high)
    except Error:  # such as classes that begin at 0, which Unfold makes
        return write(value, stem)
    if made != value:
        return write(value, stem)
    parameters = {"kind": "classes", "class_edges": edges.tolist(), "N_V": entry.N_V.tolist()}
    for name in ("low", "high"):
        ends = getattr(entry, name)
        if not np.array_equal(ends, entry.N_V):
            parameters[name] = ends.tolist()
    return "Distribution", "distribution", parameters


_writers = {"Image": _image, "Labels": _labels, "Volume": _volume, "SizeDistribution": _sizes,
            "Shapes": _json("LoadShapes", "shapes"), "KMatrix": _json("LoadKMatrix", "kmatrix"),
            "Table": _json("LoadTable", "table"), "Strokes": _json("LoadStrokes", "strokes"),
            "Profiles": _json("LoadProfiles", "profiles"), "Particles": _json("LoadParticles", "particles")}
