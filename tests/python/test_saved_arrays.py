"""Graphs that contain arrays, saved with their arrays beside them."""

import json
import os
import subprocess

import numpy as np
import pytest

import terrazzo as t

TETRAHEDRON = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
RNG = np.random.default_rng(1)
IDS = RNG.integers(0, 4, (3, 12, 8))



def profiles():
    g = t.Graph(cache=False)
    ids = np.zeros((24, 32), int)
    ids[3:9, 4:9], ids[10:20, 12:30] = 1, 2
    return g.Segment(image=t.image(RNG.random((24, 32, 3)), 1 / 3), labels=t.labels(ids, 1 / 3)).profiles.value()

def of_a_graph(make, output):
    """The value of an output of the node that make(graph) adds."""
    return make(t.Graph(cache=False)).output(output).value()


def carved(g):
    """A node whose shape has colors and texture coordinates."""
    ball = g.Shape(kind="sphere", size=2)
    packing = g.Anneal(distribution=t.sizes([1, 2], [0.02]), shapes=ball, size=6)
    return g.Carve(particles=packing, shapes=ball, mode="cube", edge=1.5, texture=256)


# A value, a node and its input that takes it, and what stands in for the value in the file.
VALUES = {
    "image": (t.image(RNG.random((5, 7, 3)).astype(np.float32) * 3, 0.123456789), "Grain", "image", "LoadImage"),
    "stack": (t.image(RNG.random((12, 5, 7, 3)), 0.1), "Grain", "image", "LoadImage"),
    "labels": (t.labels(IDS[0], 1 / 3), "Export", "labels", "LoadLabels"),
    "classes": (t.labels(IDS[0], 0.5, classes=[0, 2, 999_999]), "Export", "labels", "LoadLabels"),
    "stack of classes": (t.labels(IDS, 0.5, classes=range(9)), "Export", "labels", "LoadLabels"),
    "mesh": (t.mesh(np.array(TETRAHEDRON[0]) / 3 + 0.1, TETRAHEDRON[1], name="corner"), "KMatrix", "shapes", "LoadShapes"),
    "shapes": (of_a_graph(lambda g: g.MixShapes(shapes=[t.mesh(*TETRAHEDRON, name="../é"), g.Shape(kind="rock", count=2)],
                                                shares=[1, 2]), "shapes"), "KMatrix", "shapes", "LoadShapes"),
    "colors": (of_a_graph(carved, "shapes"), "Export", "shapes", "LoadShapes"),
    "distribution": (of_a_graph(lambda g: g.MixDistributions(
        distributions=[t.sizes([1, 2], [0.01]), t.sizes([1, 4], [1 / 300])], shapes=[t.mesh(*TETRAHEDRON), t.mesh(*TETRAHEDRON)]),
                                "distribution"), "Export", "distribution", "LoadDistribution"),
    "kmatrix": (of_a_graph(lambda g: g.KMatrix(shapes=g.Shape(kind="rock", count=2), orientations=20, classes=3), "kmatrix"),
                "Export", "kmatrix", "LoadKMatrix"),
    "table": (t.table({"size mm": [1 / 3, -0.0, float("nan")], "name": ["1", "é, \"x\"\n", ""]}), "Export", "table", "LoadTable"),
    "no rows": (t.table({}), "Export", "table", "LoadTable"),
    "strokes": (of_a_graph(lambda g: g.Strokes(strokes=["1.7: 0.1 2, 3 4.3", "area: 0 0, 9 0, 9 9; 1 1, 2 1, 2 2"]), "strokes"), "Export", "strokes", "LoadStrokes"),
    "sizes": (t.sizes([0.1, 1 / 3, 4], [0.005, 0.0025]), "Export", "distribution", "Distribution"),
    "intervals": (t.sizes([1, 2, 4], [0.005, 0.0025], low=[0.004, 0.001], high=[0.005, 0.003]), "Export", "distribution",
                  "Distribution"),
    "profiles": (profiles(), "Export", "profiles", "LoadProfiles"),
    "volume": (t.volume(RNG.random((3, 4, 5)), 0.1), "Export", "volume", "LoadVolume"),
    "period": (t.volume(RNG.random((3, 4, 5, 3)), 0.1, name="Cd", period=True), "Export", "volume", "LoadVolume"),
    "ids": (t.volume(RNG.integers(-1, 2**25, (3, 4, 5)), 0.1, name="id"), "Export", "volume", "LoadVolume"),
}


@pytest.mark.parametrize("kind", VALUES)
def test_the_saved_graph_has_the_same_values(kind, tmp_path):
    value, node, port, stand_in = VALUES[kind]
    g = t.Graph("Given", cache=False)
    g._add(node, {port: value, **({"path": "out.json"} if node == "Export" else {})})
    given = g.nodes[0].name
    g.output("value", g[given])
    before = g._ports(True), [n.type for n in g.nodes]
    os.makedirs(tmp_path / "a")
    g.save(tmp_path / "g.yaml", arrays="values")
    assert (g._ports(True), [n.type for n in g.nodes]) == before  # the graph itself keeps the arrays
    text = (tmp_path / "g.yaml").read_text()
    assert str(tmp_path) not in text and f"type: {stand_in}" in text
    # The folder can be moved.
    for name in ("values", "g.yaml"):
        if (tmp_path / name).exists():
            os.rename(tmp_path / name, tmp_path / "a" / name)
    again = t.load(tmp_path / "a" / "g.yaml", cache=False)
    read = again.value.value()
    assert read.content == value.content
    assert f"inputs: {{{port}: {given}." in text


def test_several_arrays_and_changed_subgraphs(tmp_path, section):
    image, ids = t.image(RNG.random((40, 40, 3)), 0.5), np.zeros((40, 40), int)
    ids[4:10, 4:10], ids[20:30, 20:30] = 1, 2
    g = t.Graph(cache=False)
    segment = g.Segment(image=image, labels=t.labels(ids, 0.5))
    sheet = g.ContactSheet(images=[t.image(RNG.random((4, 4, 3))), t.image(RNG.random((2, 4, 4, 3))), segment.labels])
    inner = g.subgraph(t._library.graphs_folder() + "/library/fields.yaml", image=image)
    g.output("areas", segment.profiles)
    g.save(tmp_path / "g.yaml", arrays="arrays")
    assert sorted(os.listdir(tmp_path / "arrays")) == ["image.exr", "images.exr", "images_2", "labels.tif"]
    again = t.load(tmp_path / "g.yaml", cache=False)
    assert again.areas.value() == segment.profiles.value()
    assert again["contact_sheet"].image.value() == sheet.image.value()
    # A second save replaces the files, and a loaded graph needs none.
    g.save(tmp_path / "g.yaml", arrays=tmp_path / "arrays")
    again.save(tmp_path / "again.yaml")
    assert t.load(tmp_path / "again.yaml", cache=False).areas.value() == segment.profiles.value()
    # Changes inside of subgraphs need flat=True, with and without arrays.
    g[inner.name + "/small"]["seed"] = 3
    with pytest.raises(t.Error) as e:
        g.save(tmp_path / "inner.yaml", arrays="arrays")
    assert e.value.code == "not-savable" and "flat=True" in e.value.hint
    g.save(tmp_path / "flat.yaml", flat=True, arrays="arrays")
    assert "graph:" not in (tmp_path / "flat.yaml").read_text()
    flat = t.load(tmp_path / "flat.yaml", cache=False)
    assert flat.areas.value() == segment.profiles.value() and flat[inner.name + "/small"]["seed"] == 3


def test_the_program_runs_a_saved_graph(tmp_path):
    program = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(t.__file__))), "terrazzo")
    if not os.path.exists(program):
        pytest.skip("the program was not built beside the module")
    g = t.Graph(cache=False)
    g.Export(image=g.Grain(image=t.image(RNG.random((8, 8, 3)))).image, path="out.exr")
    g.save(tmp_path / "g.yaml", arrays="arrays")
    g.run(out=tmp_path / "ours")
    subprocess.run([program, "run", tmp_path / "g.yaml", "--out", tmp_path / "theirs", "--no-cache", "--quiet"], check=True,
                   timeout=120, capture_output=True)
    ours, theirs = (t.Graph(cache=False).LoadImage(path=tmp_path / f / "out.exr").image.value() for f in ("ours", "theirs"))
    assert ours == theirs


def test_what_cannot_be_saved(tmp_path):
    def refused(node, **values):
        g = t.Graph(cache=False)
        g._add(node, values)
        with pytest.raises(t.Error) as e:
            g.save(tmp_path / "g.yaml", arrays="arrays")
        assert e.value.code == "not-savable" and e.value.message and not (tmp_path / "g.yaml").exists()
        return e.value

    infinite = refused("Export", table=t.table({"a": [1, float("inf")]}), path="a.csv")
    assert infinite.node == "table" and "same value" in infinite.message
    ids = np.zeros((48, 48), int)
    ids[4:20, 4:20], ids[25:40, 10:40] = 1, 2
    detail = of_a_graph(lambda g: g.DetailSolid(image=t.image(RNG.random((48, 48, 3)), 0.1), labels=t.labels(ids, 0.1), size=16), "detail")
    assert "no node reads Detail" in refused("Section", detail=detail).message
    g = t.Graph(cache=False)
    g.Grain(image=t.image([[0.5]]))
    with pytest.raises(t.Error) as e:
        g.save(tmp_path / "g.yaml")
    assert e.value.code == "not-savable" and "arrays=" in e.value.hint
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError):
        g.save(tmp_path / "g.yaml", arrays="file")


def exported(folder, **arrays):
    """A picture made from arrays, written to a file."""
    ids = np.zeros((40, 60), int)
    ids[5:15, 8:30], ids[20:35, 30:50] = 1, 2
    image = arrays.get("image", np.where(ids > 0, 0.8, 0.2))
    g = t.Graph(cache=False)
    segment = g.Segment(image=t.image(image, 0.5), labels=t.labels(ids, 0.5))
    g.Export(labels=segment.labels, path="labels.png", name="picture")
    g.Export(profiles=segment.profiles, path="profiles.csv", name="numbers")
    return g.run(out=folder)


@pytest.mark.parametrize("made", ["labels.png", "profiles.csv", "report.json"])
def test_files_made_from_small_arrays_are_reproduced(made, tmp_path):
    first = exported(tmp_path / "out")
    again = t.reproduce(tmp_path / "out" / made, cache=False)
    assert sorted(n.type for n in again.nodes if n.type.startswith("Given")) == ["GivenImage", "GivenLabels"]
    run = again.run(out=tmp_path / "again")
    keys = {n["name"]: n["key"] for n in first.nodes}
    assert all(n["key"] == keys[n["name"]] for n in run.nodes)
    again.save(tmp_path / "graph.yaml", arrays="arrays")
    assert t.load(tmp_path / "graph.yaml", cache=False)
    # The program has never seen the arrays.
    build = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(t.__file__))))
    done = subprocess.run([os.path.join(build, "terrazzo"), "reproduce", tmp_path / "out" / made, "--yes", "--no-cache", "--out",
                           tmp_path / "program"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "different action key" not in done.stdout and "arrays that Python gave" in done.stdout
    for file in run.files:
        if file.endswith(".csv"):
            assert (tmp_path / "program" / file).read_bytes() == (tmp_path / "out" / file).read_bytes()


def test_large_arrays_are_named(tmp_path):
    exported(tmp_path / "out", image=RNG.random((40, 60, 3)))  # small enough
    assert t.reproduce(tmp_path / "out" / "labels.png", cache=False)
    g = t.Graph(cache=False)
    g.Export(image=g.Grain(image=t.image(RNG.random((200, 200, 3)))).image, path="large.png")
    g.run(out=tmp_path / "large")
    assert (tmp_path / "large" / "report.json").stat().st_size < 20_000
    del g
    with pytest.raises(t.Error) as e:
        t.reproduce(tmp_path / "large" / "large.png", cache=False)
    assert e.value.code == "given-array" and "'image' (Image)" in e.value.message and "arrays/image" in e.value.hint
    build = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(t.__file__))))
    done = subprocess.run([os.path.join(build, "terrazzo"), "reproduce", tmp_path / "large" / "large.png", "--yes", "--no-cache",
                           "--out", tmp_path / "program"], capture_output=True, text=True)
    assert done.returncode == 1 and "too large for its provenance" in done.stderr, done.stderr
    assert not (tmp_path / "program").exists()


def test_damaged_arrays_are_refused(tmp_path):
    exported(tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    content, value = next(iter(report["values"].items()))
    wrongs = [{"data": value["data"][:-8]}, {"data": "!"}, {"bytes": value["bytes"] + 1}, {"bytes": 1 << 60}, {"type": "Volume"},
              {"type": "None"}]
    for wrong in wrongs:
        report["values"] = {content: {**value, **wrong}}
        (tmp_path / "report.json").write_text(json.dumps(report))
        with pytest.raises(t.Error) as e:
            t.reproduce(tmp_path / "report.json", cache=False)
        assert e.value.code == "damaged", wrong
    report["values"] = {"0" * 32: value}
    (tmp_path / "report.json").write_text(json.dumps(report))
    with pytest.raises(t.Error, match="damaged array"):
        t.reproduce(tmp_path / "report.json", cache=False)


def test_reports_of_newer_versions_are_refused(tmp_path):
    exported(tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["format"] == 1
    report["format"] = 2
    (tmp_path / "report.json").write_text(json.dumps(report))
    with pytest.raises(t.Error, match="has the format 2, and this program reads up to 1"):
        t.reproduce(tmp_path / "report.json", cache=False)
    del report["format"]  # of version 0.2
    (tmp_path / "report.json").write_text(json.dumps(report))
    assert t.reproduce(tmp_path / "report.json", cache=False)
