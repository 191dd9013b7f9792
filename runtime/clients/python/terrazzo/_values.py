"""Values: what the classes of the extension get in Python, and values of arrays."""

from __future__ import annotations

import os

from . import _core
from ._html import fields_html, table_html
from ._paths import path_text
from ._png import image_png, labels_png, volume_png


def image(array, pixel_size=1.0, *, srgb=None):
    """An Image of an array (height, width), (height, width, 3 or 4) or (sections, height, width, 3 or 4).

    uint8 and uint16 are scaled to 0 to 1 and decoded as sRGB; floats and booleans are taken as scene-linear.
    `srgb` says otherwise. A fourth channel is ignored. pixel_size: edge of a pixel in mm. The array is copied.
    """
    if srgb is None:
        kind = getattr(getattr(array, "dtype", None), "kind", "f")
        srgb = kind in "ui"
    return _core.image(array, float(pixel_size), bool(srgb))


def labels(array, pixel_size=1.0, *, classes=None):
    """Labels of an array of whole numbers (height, width) or (sections, height, width): 0 is binder.

    Each other value is one profile of its section, as skimage.measure.label gives them. Profiles are numbered
    anew by section, then by increasing value. classes: the class of each profile in that order, from 0.
    pixel_size: edge of a pixel in mm. The array is copied.
    """
    return _core.labels(array, float(pixel_size), classes)


def mesh(vertices, triangles, name="mesh"):
    """Shapes with one shape: vertices (n, 3) in mm, and triangles (m, 3), counterclockwise seen from outside.

    The mesh must be watertight. It is moved so that its centroid is the origin. The arrays are copied.
    """
    return _core.mesh(vertices, triangles, str(name))


def sizes(class_edges, N_V, *, low=None, high=None):
    """A SizeDistribution: n + 1 increasing sizes in mm, and the particles per mm³ in each of the n classes.

    low, high: ends of the intervals; by default N_V itself, for intervals that are unknown. The volume
    fraction is that of spheres.
    """
    return _core.sizes(class_edges, N_V, low, high)


def table(columns):
    """A Table of a dictionary: lists of numbers or text of equal length, by the names of the columns."""
    made = {}
    for name, cells in columns.items():
        if isinstance(cells, (str, bytes)):
            raise TypeError(f"the column '{name}' must be a list of cells, not a {type(cells).__name__}")
        if str(name) in made:
            raise ValueError(f"two columns have the name '{name}'")
        made[str(name)] = list(cells)
    return _core.table(made)


def _restore(kind, encoded):
    return _core.decoded(kind, encoded)


def _reduce(self):
    return _restore, (self.type, self._encoded())


def _no_reduce(self):
    raise TypeError(f"a {type(self).__name__} cannot be pickled or copied; values can")


def _save(self, file):
    """Writes the value to a file, with the Export node. The extension gives the format."""
    from ._graph import Graph
    file = os.path.abspath(path_text(file))
    graph = Graph(cache=False)
    port = _export_ports.get(self.type)
    if port is None:
        raise TypeError(f"no node writes values of type {self.type} to files")
    folder, name = os.path.split(file)
    if _core.is_reserved_output(name):  # in an output folder, but this is any folder
        folder, inner = os.path.split(os.path.realpath(folder))
        name = os.path.join(inner, name)
    graph.Export(**{port: self}, path=name)
    graph.start(out=folder).wait(False)._settled(report=False)


def _ports_of_export():
    out = {}
    for port in _core.node_type("Export")["inputs"]:
        for kind in port["types"]:
            out.setdefault(kind, port["name"])
    return out


def _array_of(field):
    def as_array(self, dtype=None, copy=None):
        array = getattr(self, field)
        if dtype is not None and dtype != array.dtype:
            return array.astype(dtype)
        return array.copy() if copy else array

    as_array.__name__ = "__array__"
    return as_array


def _repr(self):
    facts = []
    for name in ("width", "height", "sections", "pixel_size", "count", "observed_area", "area_fraction", "d_max",
                 "volume_fraction", "grids", "resolution", "columns", "box"):
        if hasattr(type(self), name):
            facts.append(f"{name}={getattr(self, name)!r}")
    if hasattr(type(self), "__len__"):
        facts.insert(0, f"{len(self)}")
    return f"<{type(self).__name__} {', '.join(facts)}>"


def _to_pandas(self):
    """The table as a pandas.DataFrame. Needs pandas."""
    import pandas
    return pandas.DataFrame({name: self[name] for name in self.columns})


def _to_dict(self):
    """The columns by name, as arrays or lists."""
    return {name: self[name] for name in self.columns}


def _to_numpy(self):
    """A new array (rows, columns), such as the tensor of Homogenize. TypeError if a column contains text."""
    import numpy
    columns = [self[name] for name in self.columns]
    for name, column in zip(self.columns, columns):
        if isinstance(column, list):
            raise TypeError(f"column {name!r} contains text")
    return numpy.stack(columns, axis=1)


def _sizes_html(self):
    rows = []
    for entry in self.entries:
        for i in range(len(entry.N_V)):
            rows.append((entry.shape, entry.cls, self.class_edges[i], self.class_edges[i + 1], entry.N_V[i],
                         entry.low[i], entry.high[i]))
    # Without a volume fraction, densities are relative.
    density = "N_V mm⁻³" if self.volume_fraction > 0 else "N_V relative"
    return table_html(("shape", "class", "from mm", "to mm", density, "low", "high"), rows)


def _numbers(values):
    return " ".join(f"{float(v):.4g}" for v in values)


def _profiles_html(self):
    return fields_html(("section", "class", "area mm²", "centroid mm", "weight", "confidence", "color"), len(self), lambda i: (
        self.section[i], self.cls[i], float(self.area[i]), _numbers(self.centroid[i]), float(self.weight[i]),
        float(self.confidence[i]), _numbers(self.color[i])))


def _particles_html(self):
    return fields_html(("shape", "class", "position mm", "size mm", "scale", "color"), len(self), lambda i: (
        self.shape[i], self.cls[i], _numbers(self.position[i]), float(self.size[i]), float(self.scale[i]),
        _numbers(self.color[i])))


def _shapes_html(self):
    def row(i):
        shape = self[i]
        return (shape.name, shape.cls, shape.probability, shape.volume, shape.surface_area, shape.mean_caliper, shape.size,
                len(shape.mesh.triangles))

    return fields_html(("name", "class", "probability", "volume mm³", "surface mm²", "mean caliper mm", "size mm", "triangles"),
                       len(self), row)


_export_ports = _ports_of_export()
_core.Value.__repr__ = _repr
_core.Value.__reduce__ = _reduce
_core.Value.save = _save
_save.__name__ = "save"
for _class in [c for c in vars(_core).values() if isinstance(c, type)]:
    if _class.__reduce__ is object.__reduce__:  # which ends the process in protocols 0 and 1, since pybind11 throws there
        _class.__reduce__ = _no_reduce
_core.Image.__array__ = _array_of("pixels")
_core.Labels.__array__ = _array_of("ids")
_core.Image._repr_png_ = image_png
_core.Labels._repr_png_ = labels_png
_core.Volume._repr_png_ = volume_png
_core.Particles._repr_html_ = _particles_html
_core.Profiles._repr_html_ = _profiles_html
_core.Shapes._repr_html_ = _shapes_html
_core.Table._repr_html_ = lambda self: table_html(self.columns, self.rows)
_core.Table.to_pandas = _to_pandas
_core.Table.to_dict = _to_dict
_core.Table.to_numpy = _to_numpy
_core.SizeDistribution._repr_html_ = _sizes_html
