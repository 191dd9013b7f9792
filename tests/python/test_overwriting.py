"""What a graph reads is not overwritten by what Python saves."""

import os
import shutil

import numpy as np
import pytest

import terrazzo as t


def code_of(call):
    with pytest.raises(t.Error) as e:
        call()
    return e.value.code


def test_a_graph_is_not_saved_over_what_it_reads(section):
    shutil.copy(section, "photo.png")
    os.link("photo.png", "second.png")
    g = t.Graph()
    g.LoadImage(path="photo.png")
    before = open("photo.png", "rb").read()
    for name in ("photo.png", "./photo.png", "second.png"):
        assert code_of(lambda: g.save(name)) == "overwrites-input"
    assert open("photo.png", "rb").read() == before
    g.save("g.yaml")
    again = t.load("g.yaml")
    again.save("g.yaml")  # its own file


def test_arrays_do_not_replace_what_the_graph_reads():
    g = t.Graph()
    g.Grain(image=t.image(np.ones((4, 4, 3), np.float32)))
    name = next(n for n in g._names() if g[n].type.startswith("Given")) + ".exr"
    t.image(np.zeros((4, 4, 3), np.float32)).save(name)
    g.LoadImage(path=name)
    before = open(name, "rb").read()
    assert code_of(lambda: g.save("g.yaml", arrays=".")) == "overwrites-input"
    assert open(name, "rb").read() == before
    g.save("g.yaml", arrays="arrays")


def test_a_value_may_have_any_name():
    table = t.table({"a": [1.0, 2.0]})
    for name in ("report.json", "sweep.csv", "sub/report.json"):
        os.makedirs("sub", exist_ok=True)
        table.save(name)
        assert os.path.getsize(name) > 0
