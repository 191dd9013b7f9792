"""One file, and how each kind of file is read."""

import dataclasses
import pathlib
from typing import Callable, Union

import numpy as np

import terrazzo as t


@dataclasses.dataclass(frozen=True)
class Sample:
    kind: str
    name: str  # of the file, or a glob
    content: Union[bytes, str, Callable[[pathlib.Path], None]]  # a function writes the file itself
    right: Union[dict, str]  # what the reader gives, by name, or the code of its error
    read: Callable[..., dict]
    parameters: dict = dataclasses.field(default_factory=dict)
    tolerance: float = 1e-6

    def write(self, folder):
        path = folder / self.name
        if callable(self.content):
            self.content(path)
        else:
            path.write_bytes(self.content.encode() if isinstance(self.content, str) else self.content)
        return path


# Elements are x + 10 y + 100 z, so that exchanged or reversed axes are seen.
RAMP = np.fromfunction(lambda x, y, z: x + 10 * y + 100 * z, (4, 5, 6)).astype(np.float32)
RAMP_BYTES = RAMP.T.astype("<f4").tobytes()  # x is the fastest


def output(node, port, **parameters):
    graph = t.Graph(cache=False)
    return getattr(getattr(graph, node)(**parameters), port).value()


def read_volume(path, **parameters):
    volume = output("LoadVolume", "volume", path=path, **parameters)
    name = volume.grids[0]
    spacing = volume.describe()["grids"][0]["voxel_size"]
    return {"voxels": volume.dense(name), "spacing": spacing, "grid": name}


def partition(ids):
    """Ids in the order of their first elements, so that two ways to number the same parts are equal."""
    kept, first, place = np.unique(ids, return_index=True, return_inverse=True)
    rank = np.empty(len(kept), int)
    rank[np.argsort(np.where(kept == 0, -1, first))] = np.arange(len(kept))
    return (rank[place] + (0 if kept[0] == 0 else 1)).reshape(np.shape(ids))


def read_map(path, **parameters):
    labels = output("LoadEBSD", "labels", path=path, **parameters)
    return {"grains": partition(labels.ids), "pixel": labels.pixel_size}


def read_labels(path, **parameters):
    labels = output("LoadLabels", "labels", path=path, **parameters)
    return {"ids": partition(labels.ids), "classes": labels.classes}


def read_picture(path, **parameters):
    """The pixels in 8-bit sRGB."""
    linear = np.maximum(output("LoadImage", "image", path=path, **parameters).pixels, 0)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return {"srgb": srgb * 255}


def read_areas(path, **parameters):
    return {"mm2": output("LoadProfiles", "profiles", path=path, **parameters).area}


def read_mesh(path, **parameters):
    shapes = output("LoadMesh", "shapes", path=path, **parameters)
    return {"volumes": [shapes[i].volume for i in range(len(shapes))]}
