"""Arrays of a graph as files beside its graph file."""

from __future__ import annotations

import os

import numpy as np

from . import _core
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
        write = _writers.get(value.type)
        if write is None:
            _not_savable(name, f"no node reads {value.type} from a file")
        os.makedirs(folder, exist_ok=True)
        kind, port, parameters = write(value, os.path.join(folder, name))
        read = Graph(cache=False)._add(kind, dict(parameters)).output(port).value()
        if not _same(read, value):
            _not_savable(name, f"{parameters.get('path', kind)} does not give the same value when it is read again")
        out[name] = kind, port, parameters
    return out


def _not_savable(node, why):
    _core.raise_error("not-savable", f"the arrays of the node {node} cannot be saved: {why}",
                      "write the value with a node of your graph, and load it", node, "")


def _same(read, value):
    if value.type != "Shapes":
        return read == value
    # A mesh is moved to its centroid, which differs in the last digits.
    one, other = read[0].mesh, value[0].mesh
    return (len(read) == 1 and np.array_equal(one.triangles, other.triangles) and
            np.allclose(one.vertices, other.vertices, rtol=1e-12, atol=1e-12 * value[0].size))


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


def _mesh(value, stem):
    if len(value) != 1 or len(value[0].color) or len(value[0].uv):
        _not_savable(os.path.basename(stem), "only a single shape without colors can be")
    if value[0].name in ("", ".", "..") or "/" in value[0].name:
        _not_savable(os.path.basename(stem), f"the shape's name {value[0].name!r} cannot be the name of a file")
    folder = stem if os.path.basename(stem) != value[0].name else os.path.dirname(stem)
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, value[0].name + ".ply")  # LoadMesh names the shape after its file
    value.save(path)
    return "LoadMesh", "shapes", {"path": path}


def _volume(value, stem):
    graph = Graph(cache=False)
    graph.Export(volume=value, path=os.path.basename(stem) + ".vdb", id_type="int32")
    graph.start(out=os.path.dirname(stem)).wait(False)._settled(report=False)
    return "LoadVolume", "volume", {"path": stem + ".vdb"}


def _profiles(value, stem):
    value.save(stem + ".json")
    return "LoadProfiles", "profiles", {"path": stem + ".json"}


def _particles(value, stem):
    value.save(stem + ".json")
    return "LoadParticles", "particles", {"path": stem + ".json"}


def _sizes(value, stem):
    entry = value.entries[0]
    parameters = {"kind": "classes", "class_edges": value.class_edges.tolist(), "N_V": entry.N_V.tolist()}
    for name in ("low", "high"):
        ends = getattr(entry, name)
        if not np.array_equal(ends, entry.N_V):
            parameters[name] = ends.tolist()
    return "Distribution", "distribution", parameters


_writers = {"Image": _image, "Labels": _labels, "Shapes": _mesh, "Volume": _volume, "Profiles": _profiles,
            "Particles": _particles, "SizeDistribution": _sizes}
