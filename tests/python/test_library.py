"""Library graphs, sweeps and reproduction."""

import gc
import os
import pickle
import subprocess
import json

import numpy as np
import pytest

import terrazzo as t
from conftest import SOURCE, needs_plain_memory, resident


def test_a_library_graph_is_a_function(section):
    g = t.library.aggregate(photo=section, pixel_size=0.2)
    assert isinstance(g, t.Graph) and g.parameters["pixel_size"] == "0.2"
    assert g.image.value().pixel_size == 0.2
    with pytest.raises(t.Error) as e:
        t.library.aggregate(pixl_size=1)
    assert e.value.code == "unknown-parameter" and "did you mean 'pixel_size'" in e.value.message
    with pytest.raises(AttributeError, match="there are aggregate"):
        t.library.agregate
    assert "aggregate" in dir(t.library) and "granite" in dir(t.materials)


def test_a_library_graph_inside_of_another_one():
    g = t.Graph(cache=False)
    dots = g.Pattern(kind="fat", width=64, height=64)
    inner = t.library.aggregate(photo=dots.image, pixel_size=0.5)
    assert inner.graph is g and inner.type and "profiles" in inner.outputs
    # The input replaces the photograph that the library's graph loads.
    assert inner.image.value() == dots.image.value()
    assert "inputs: {photo: pattern.image}" in g.to_yaml() and "graph: " in g.to_yaml()
    # Asking for an inner output does not make it a target of the whole.
    assert all("figure" not in name for name, _ in g._ports(True))
    with_array = t.library.aggregate(photo=t.image(np.full((8, 8, 3), 0.25)))
    assert with_array.image.value().pixels.max() == 0.25


def test_outputs_of_nested_subgraphs(tmp_path):
    (tmp_path / "inner.yaml").write_text("terrazzo: 1\nnodes:\n  p: {type: Pattern, params: {width: 16, height: 16}}\n"
                                         "outputs: {picture: p.image}\n")
    (tmp_path / "outer.yaml").write_text("terrazzo: 1\nnodes:\n  in: {graph: inner.yaml}\n"
                                         "outputs: {picture: in.picture}\n")
    g = t.Graph(cache=False)
    node = g.subgraph(tmp_path / "outer.yaml")
    assert node.picture.value().width == 16
    assert g["outer/in/p"].image.value().width == 16
    assert [n["name"] for n in g.run(node).nodes] == ["outer/in/p"]
    assert g.run().nodes == [] or [n["name"] for n in g.run().nodes] == ["outer/in/p"]
    with pytest.raises(t.Error) as e:
        g.subgraph(tmp_path / "none.yaml")
    assert e.value.code == "no-file"


def test_sweeps():
    g = t.Graph(cache=False)
    base = g.Pattern(kind="fat", width=32, height=32)
    grain = g.Grain(image=base.image)
    sweep = g.sweep({"grain.seed": [1, 2, 3], "pattern.width": [16, 32]}, grain.image)
    assert [(p["grain.seed"], p["pattern.width"]) for p in sweep.points] == [(s, w) for s in (1, 2, 3) for w in (16, 32)]
    assert [values[0].width for values in sweep.values] == [16, 32] * 3
    assert sweep["status"] == ["done"] * 6 and len({v[0].content for v in sweep.values}) == 6
    assert grain["seed"] == 1 and base["width"] == 32  # as before
    assert "seed" not in g.to_yaml()
    with pytest.raises(t.Error):
        g.sweep({"grain.seed": [1, -1]}, grain.image)
    with pytest.raises(ValueError):
        g.sweep({})
    with pytest.raises(ValueError):
        g.sweep({"grain.seed": []})
    assert grain["seed"] == 1


@needs_plain_memory
def test_a_sweep_keeps_no_values_in_memory():
    g = t.Graph(cache=False, memory=1)  # the store keeps only values in use
    base = g.Pattern(kind="fat", width=256, height=256)
    sweep = g.sweep({"pattern.seed": range(1, 41)}, base.image)
    gc.collect()
    before = resident()
    assert len(sweep.values) == 40 and [len(values) for values in sweep.values] == [1] * 40
    base["seed"] = 7
    assert sweep.values[6][0] == base.image.value()  # computed again
    base["kind"] = "wood"
    assert sweep.values[6][0] != base.image.value() and sweep.values[39][0].width == 256  # of the graph as it was
    assert sweep.values[6][:] == [sweep.values[6][-1]] and repr(sweep.values[6]) == "<1 values>"
    for (image,) in sweep.values:
        assert image.width == 256
    assert resident() - before < 16e6  # 40 images would take 31 MB
    with pytest.raises(IndexError):
        sweep.values[0][1]


def test_sweeps_survive_pickling():
    g = t.Graph(cache=False)
    base = g.Pattern(kind="fat", width=16, height=16)
    sweep = g.sweep({"pattern.seed": [1, 2]}, base.image)
    again = pickle.loads(pickle.dumps(sweep))
    assert again.points == sweep.points and again.values == sweep.values and again.values[0] != again.values[1]


@pytest.mark.parametrize("jobs", [1, 3, 50])
def test_sweeps_of_several_points_at_a_time(jobs):
    g = t.Graph(cache=False)
    base = g.Pattern(kind="fat", width=48, height=48)
    grain = g.Grain(image=base.image)
    sweep = g.sweep({"pattern.seed": range(1, 9)}, grain.image, jobs=jobs)
    for seed, (image,) in zip(range(1, 9), sweep.values):
        base["seed"] = seed
        assert grain.image.value() == image
    base.set(seed=None)
    assert sweep["pattern.seed"] == list(range(1, 9)) and set(sweep["status"]) == {"done"}
    with pytest.raises(ValueError, match="jobs must be at least 1"):
        g.sweep({"pattern.seed": [1]}, grain.image, jobs=0)


def test_an_interrupt_stops_all_points_of_a_sweep(script):
    done = script("""
import os, signal, threading, time
import terrazzo as t
g = t.Graph(cache=False)
solid = g.SolidOptimize(exemplar=g.Pattern(kind="marble", width=128, height=128).image, size=512)
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
start = time.monotonic()
try:
    g.sweep({"pattern.seed": [1, 2, 3]}, solid.volume, jobs=2)
except KeyboardInterrupt:
    print("interrupted", time.monotonic() - start < 30, g["pattern"]["seed"])
""")
    assert done.stdout == "interrupted True 1\n", done.stderr


def test_sweeps_are_tables(tmp_path):
    g = t.Graph(cache=False)
    g.Segment(image=g.Pattern(kind="fat", width=48, height=48).image, method="clusters")
    sweep = g.sweep({"segment.split": [0.2, 0.4], "pattern.kind": ["fat", "bone"]})
    sweep.save(tmp_path / "sweep.csv")
    again = t.read_sweep(tmp_path)
    assert again.varied == sweep.varied and again.points == sweep.points and again.errors == [None] * 4
    assert (tmp_path / "sweep.csv").read_text().startswith("point,segment.split,pattern.kind,status,seconds,")
    assert t.read_sweep(tmp_path / "sweep.csv")["pattern.kind"] == ["fat", "bone"] * 2


def test_tables_of_the_program_are_read(tmp_path):
    program = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(t.__file__))), "terrazzo")
    if not os.path.exists(program):
        pytest.skip("the program was not built beside the module")
    (tmp_path / "g.yaml").write_text("terrazzo: 1\nnodes:\n  a: {type: Pattern, params: {width: 32, height: 32}}\n"
                                     "  s: {type: Segment, inputs: {image: a.image}, params: {method: clusters}}\n")
    subprocess.run([program, "sweep", tmp_path / "g.yaml", "--vary", "a.seed=1,2", "--out", tmp_path / "o", "--no-cache",
                    "--quiet"], check=True, timeout=120, capture_output=True)
    sweep = t.read_sweep(tmp_path / "o")
    assert sweep["a.seed"] == [1, 2] and sweep["status"] == ["done", "done"]
    g = t.load(tmp_path / "g.yaml", cache=False)
    ours = g.sweep({"a.seed": [1, 2]})
    assert sweep["s.profiles"] == ours["s.profiles"] and sweep.columns == ours.columns


@pytest.mark.parametrize("text", ["", "a,b\n", "point,status\n", "point,x,status,seconds\npoint-001,1,done\n", "\0", "\xff\xfe"])
def test_other_tables_are_refused(tmp_path, text):
    (tmp_path / "sweep.csv").write_bytes(text.encode("latin-1"))
    with pytest.raises(t.Error) as e:
        t.read_sweep(tmp_path)
    assert e.value.code == "sweep-file" and "sweep.csv" in e.value.message


def test_sweeps_write_files_and_keep_going(tmp_path):
    g = t.Graph(cache=False)
    size = g.parameter("size", "int", 16)
    picture = g.Pattern(width=size, height=16)
    g.Export(image=picture.image, path="a.png")
    sweep = g.sweep({"size": [8, 16]}, out=tmp_path / "out")
    for number, width in ((1, 8), (2, 16)):
        folder = tmp_path / "out" / f"point-00{number}"
        assert t.Graph(cache=False).LoadImage(path=folder / "a.png").image.value().width == width
        report = json.loads((folder / "report.json").read_text())
        assert {n["name"] for n in report["nodes"]} == {"pattern", "export"}
    assert g.parameters["size"] == "16" and sweep.errors == [None, None]
    h = t.Graph(cache=False)
    h.LoadImage(path=tmp_path / "out" / "point-001" / "a.png", name="photo")
    files = [tmp_path / "none.png", tmp_path / "out" / "point-002" / "a.png"]
    failing = h.sweep({"photo.path": files}, h["photo"].image)
    assert failing["status"] == ["failed", "done"] and failing.errors[0].code == "no-file"
    assert failing.values[0] == [None] and failing.values[1][0].width == 16


def test_reproduce(tmp_path):
    t.image(np.random.default_rng(1).random((16, 16, 3))).save(tmp_path / "in.png")
    g = t.Graph(cache=False)
    photo = g.LoadImage(path=tmp_path / "in.png")
    g.Export(image=g.Grain(image=photo.image, seed=5).image, path="out.png")
    first = g.run(out=tmp_path / "out")
    assert first.files == ["out.png"]
    again = t.reproduce(tmp_path / "out" / "out.png", cache=False)
    assert again["grain"]["seed"] == 5 and again.made_from == [str(tmp_path / "in.png")]
    assert {n["name"]: n["key"] for n in first.nodes} == again.made_keys or "grain" in again.made_keys
    run = again.run(out=tmp_path / "reproduced")
    keys = {n["name"]: n["key"] for n in run.nodes}
    assert keys["grain"] == again.made_keys["grain"]
    values = [t.Graph(cache=False).LoadImage(path=tmp_path / f / "out.png").image.value() for f in ("out", "reproduced")]
    assert values[0] == values[1]
    # A table has no room for provenance: the report beside it has.
    seg = g.Segment(image=g.Pattern(kind="fat", width=48, height=48).image, method="clusters", name="seg")
    g.Export(profiles=seg.profiles, path="p.csv", name="profiles")
    g.run("profiles", out=tmp_path / "table")
    assert sorted(os.listdir(tmp_path / "table")) == ["p.csv", "report.json"]
    assert t.reproduce(tmp_path / "table" / "p.csv", cache=False)["seg"]["method"] == "clusters"
    # The provenance may be a stranger's: other content is not read.
    t.image(np.zeros((16, 16, 3))).save(tmp_path / "in.png")
    with pytest.raises(t.Error, match="is not the file it was made from"):
        t.reproduce(tmp_path / "out" / "out.png")
    assert t.reproduce(tmp_path / "out" / "out.png", allow_read=[tmp_path])
    with pytest.raises(t.Error, match="contains no provenance"):
        t.reproduce(SOURCE / "graphs" / "samples" / "truth.yaml")


def test_sweeps_have_a_limit():
    g = t.Graph(cache=False)
    grain = g.Grain(image=g.Pattern().image, name="grain")
    for vary in ({"grain.seed": range(10**12)}, {"grain.seed": range(1000), "grain.noise": (k / 1000 for k in range(1000))}):
        with pytest.raises(ValueError, match="more than 100,000 points"):
            g.sweep(vary, grain)
