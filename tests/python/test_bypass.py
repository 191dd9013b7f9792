"""Bypassed nodes of graph files."""

import numpy as np

import terrazzo as t

TEXT = """\
terrazzo: 1
nodes:
  dots: {type: Pattern, params: {kind: fat, width: 32, height: 32}}
  small:
    type: ContactSheet
    bypass: true
    inputs: {images: dots.image}
    params: {cell: 64}
  sheet: {type: ContactSheet, inputs: {images: small.image}}
"""


def test_readers_of_a_bypassed_node_read_its_input(tmp_path):
    (tmp_path / "g.yaml").write_text(TEXT)
    g = t.load(tmp_path / "g.yaml", cache=False)
    run = g.run(out=tmp_path)
    assert [n["name"] for n in run.nodes] == ["dots", "sheet"]
    assert np.array_equal(g["small"].image.value(), g["dots"].image.value())
    g["dots"]["width"] = 40
    assert g["small"].image.value().width == 40


def test_saving_keeps_it_and_a_flat_graph_has_no_such_node(tmp_path):
    (tmp_path / "g.yaml").write_text(TEXT)
    g = t.load(tmp_path / "g.yaml", cache=False)
    g["small"]["cell"] = 80
    assert g.to_yaml(tmp_path) == TEXT.replace("cell: 64", "cell: 80")
    flat = g.to_yaml(tmp_path, flat=True)
    assert "small" not in flat
    assert "images: dots.image" in flat
