"""Runs in a clean Debian with the packages: the module, and the program on a graph that the module saved."""

import os
import subprocess

import numpy as np
import terrazzo as t


@t.node
def darken(image: t.Image) -> t.Image:
    return t.image(image.pixels / 2, image.pixel_size)


solid = t.library.aggregate(cache=False)
print("python3-terrazzo:", t.__version__, solid.labels.value())
g = t.Graph("Check", cache=False)
picture = g.Grain(image=t.image(np.linspace(0, 1, 192).reshape(8, 8, 3))).image
assert np.array_equal(g.Darken(image=picture).image.value().pixels, picture.value().pixels / 2)
del g["darken"]
g.Export(image=picture, path="picture.exr")
g.save("check.yaml", arrays="arrays")
subprocess.run(["terrazzo", "run", "--quiet", "--out", "checked", "check.yaml"], check=True)
assert t.Graph(cache=False).LoadImage(path="checked/picture.exr", pixel_size=1).image.value() == picture.value()
assert "Parameters" in g.Segment.__doc__
for file in ("__init__.pyi", "py.typed"):
    assert os.path.exists(os.path.join(os.path.dirname(t.__file__), file)), file
