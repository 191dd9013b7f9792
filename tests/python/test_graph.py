"""Building, checking, editing and saving graphs."""

import inspect
import os
import pathlib
import re

import pytest

import terrazzo as t
from conftest import SOURCE


def small():
    g = t.Graph("Small", cache=False)
    dots = g.Pattern(kind="fat", width=64, height=64)
    seg = g.Segment(image=dots.image, method="clusters")
    return g, dots, seg


def test_a_built_graph_is_what_a_person_would_write():
    g = t.Graph("Granite", cache=False)
    photo = g.LoadImage(path="granite.jpg", pixel_size=0.05, name="photo")
    seg = g.Segment(split=0.3, image=photo.image)
    shape = g.ShapeEstimate(profiles=seg.profiles, method="auto")
    g.KMatrix(shapes=shape)
    g.ContactSheet(images=[photo.image, photo.image], captions=["one: two", "#3"])
    g.output("profiles", seg.profiles)
    assert g.to_yaml() == """\
terrazzo: 1
name: Granite
nodes:
  photo:
    type: LoadImage
    params: {path: granite.jpg, pixel_size: 0.05}
  segment:
    type: Segment
    inputs: {image: photo.image}
    params: {split: 0.3}
  shape_estimate:
    type: ShapeEstimate
    inputs: {profiles: segment.profiles}
    params: {method: auto}
  kmatrix:
    type: KMatrix
    inputs: {shapes: shape_estimate.shapes}
  contact_sheet:
    type: ContactSheet
    inputs: {images: [photo.image, photo.image]}
    params: {captions: ["one: two", "#3"]}
outputs:
  profiles: segment.profiles
"""


def test_a_saved_graph_loads_as_the_same_graph(tmp_path):
    g, dots, seg = small()
    scale = g.parameter("scale", "number", 2.5, doc="Size: of dots", unit="pixels", min=0.1)
    dots["scale"] = scale
    g.output("labels", seg.labels)
    g.save(tmp_path / "small.yaml")
    again = t.load(tmp_path / "small.yaml", cache=False)
    assert again.to_yaml(tmp_path) == g.to_yaml(tmp_path)
    assert again["pattern"]["scale"] == "${scale}"
    assert again.labels.value() == seg.labels.value()
    assert t.load(tmp_path / "small.yaml", cache=False, scale=4).parameters["scale"] == "4"


@pytest.mark.parametrize("file", sorted((SOURCE / "graphs").glob("*/*.yaml")), ids=lambda f: f.stem)
def test_a_graph_that_nothing_changed_keeps_its_text(file):
    g = t.Graph(cache=False)
    g._open(str(file))
    assert g.to_yaml(file.parent) == file.read_text()


def test_an_edit_keeps_the_rest_of_the_text(tmp_path):
    file = SOURCE / "graphs" / "library" / "aggregate.yaml"
    g = t.load(file, cache=False)
    g["segment"]["split"] = 0.25
    g.parameters["pixel_size"] = 0.05
    colors = g.Colorize(particles=g["pack"].particles, name="gray")
    g.output("gray", colors.particles)
    before, after = file.read_text().splitlines(), g.to_yaml(file.parent).splitlines()
    removed = [line for line in before if line not in after]
    added = [line for line in after if line not in before]
    assert [line.strip()[:20] for line in removed] == ["pixel_size: {type: n", "params: {binder: \"${"]
    assert removed[1].replace('"${split}"', "0.25") in added
    assert "  gray:" in added and "  gray: gray.particles" in added
    assert len(added) == 5  # one line of the new node is in the file already
    assert "  voxels_2004:  # with one residual for everything, as in the paper" in after


def test_paths_follow_the_file(tmp_path):
    file = SOURCE / "graphs" / "library" / "aggregate.yaml"
    g = t.load(file, cache=False)
    g.save(tmp_path / "here.yaml")
    assert "/graphs/samples/section.png" in (tmp_path / "here.yaml").read_text()
    t.load(tmp_path / "here.yaml", cache=False).explain()  # finds the file
    nested = t.load(SOURCE / "graphs" / "samples" / "section.yaml", cache=False)
    nested.save(tmp_path / "nested.yaml")
    assert t.load(tmp_path / "nested.yaml", cache=False)["truth"].outputs == ["distribution", "shapes"]


def test_errors_name_node_parameter_line_and_hint():
    g = t.Graph(cache=False)
    with pytest.raises(t.Error) as e:
        g.Pattern(kind="fatt")
    line = inspect.currentframe().f_lineno - 1
    assert e.value.code == "bad-value" and e.value.parameter == "kind" and e.value.node == "pattern"
    assert (e.value.file, e.value.line) == (__file__, line)
    assert "did you mean 'fat'" in e.value.message
    assert len(g) == 0
    with pytest.raises(t.Error, match="has no input or parameter 'knd'; did you mean 'kind'"):
        g.Pattern(knd="fat")
    with pytest.raises(t.Error, match="there is no node type 'Patern'; did you mean 'Pattern'"):
        g.Patern()
    dots = g.Pattern()
    with pytest.raises(t.Error) as e:
        g.Segment(image=g.Distribution())
    assert e.value.code == "wrong-type"
    with pytest.raises(AttributeError, match="has no output 'imag'; did you mean 'image'"):
        dots.imag
    with pytest.raises(AttributeError, match="cannot be assigned"):
        dots.kind = "fat"
    with pytest.raises(t.Error, match="there is no node 'patern'; did you mean 'pattern'"):
        g["patern"]


def test_check_finds_everything_that_is_wrong():
    g = t.Graph(cache=False)
    g.Segment()
    line = inspect.currentframe().f_lineno - 1
    g.Distribution(kind="uniform", min=5, max=4)
    with pytest.raises(t.Error) as e:
        g.check()
    codes = {d.code for d in e.value.diagnostics}
    assert len(e.value.diagnostics) == 2 and "bad-range" in codes
    assert {d.node for d in e.value.diagnostics} == {"segment", "distribution"}
    assert line in {d.line for d in e.value.diagnostics}
    assert {d.file for d in e.value.diagnostics} == {__file__}


def test_errors_in_files_have_their_place(tmp_path):
    file = tmp_path / "wrong.yaml"
    file.write_text("terrazzo: 1\nnodes:\n  a: {type: Pattern, params: {kind: fatt}}\n  b: {type: Nope}\n")
    with pytest.raises(t.Error) as e:
        t.load(file, cache=False)
    assert [(d.code, d.line) for d in e.value.diagnostics] == [("bad-value", 3), ("unknown-type", 4)]
    assert e.value.file == str(file) and e.value.column == 37
    with pytest.raises(t.Error) as e:
        t.load(tmp_path / "none.yaml")
    assert e.value.code == "no-file"
    file.write_text("terrazzo: 1\nnodes: [")
    with pytest.raises(t.Error) as e:
        t.load(file)
    assert e.value.code == "yaml"


def test_a_node_fails_with_its_error(tmp_path):
    g = t.Graph(cache=False)
    photo = g.LoadImage(path=tmp_path / "none.png")
    line = inspect.currentframe().f_lineno - 1
    seg = g.Segment(image=photo.image)
    with pytest.raises(t.Error) as e:
        seg.profiles.value()
    assert (e.value.code, e.value.node, e.value.parameter) == ("no-file", "load_image", "path")
    assert (e.value.file, e.value.line) == (__file__, line) and e.value.hint


def test_edits():
    g, dots, seg = small()
    first = seg.labels.value()
    dots["seed"] = 7
    second = seg.labels.value()
    assert second != first
    assert dots["seed"] == 7 and dots["kind"] == "fat"
    dots.set(seed=None)
    assert dots["seed"] == 1 and seg.labels.value() == first
    other = g.Pattern(kind="bone", width=64, height=64, name="other")
    seg.set(image=other.image, split=0.1)
    with pytest.raises(t.Error):
        seg.set(split=0.2, min_area=-5)  # all or nothing
    assert seg["split"] == 0.1
    with pytest.raises(t.Error) as e:
        del g["other"]
    assert e.value.code == "in-use"
    seg.set(image=dots.image)
    del g["other"]
    assert "other" not in g and len(g) == 2
    with pytest.raises(t.Error):
        other.image.value()
    g.rename(dots, "pattern_of_dots")
    assert "inputs: {image: pattern_of_dots.image}" in g.to_yaml()
    with pytest.raises(t.Error) as e:
        g.rename("segment", "a.b")
    assert e.value.code == "bad-name"


def test_a_cycle_is_an_error_of_the_check():
    g = t.Graph(cache=False)
    a = g.Grain(image=t.image([[0.5]]), name="a")
    b = g.Grain(image=a.image, name="b")
    a.set(image=b.image)
    with pytest.raises(t.Error) as e:
        g.check()
    assert e.value.code == "cycle"


def test_nodes_of_subgraphs_can_be_changed_but_not_saved():
    g = t.load(SOURCE / "graphs" / "samples" / "section.yaml", cache=False)
    assert g["truth/sizes"]["kind"] == "classes"
    g["truth/chips"]["count"] = 2
    assert len(g["truth"].shapes.value()) == 2
    with pytest.raises(t.Error):
        g["truth/chips"]["count"] = -2
    assert len(g["truth/chips"].shapes.value()) == 2
    with pytest.raises(t.Error) as e:
        g.to_yaml()
    assert e.value.code == "not-savable" and "flat=True" in e.value.hint
    g.save("flat.yaml", flat=True)
    flat = t.load("flat.yaml", cache=False)
    assert flat["truth/chips"]["count"] == 2 and len(flat["truth/chips"].shapes.value()) == 2
    assert flat.to_yaml() == g.to_yaml(flat=True) and set(flat.outputs) == set(g.outputs)
    g["truth/chips"].set(count=None)
    assert "truth" in g.to_yaml()


def test_nodes_of_other_graphs_are_refused():
    g, dots, seg = small()
    h = t.Graph(cache=False)
    with pytest.raises(t.Error) as e:
        h.Segment(image=dots.image)
    assert e.value.code == "other-graph"


def test_values_of_parameters_are_checked():
    import numpy as np
    g = t.Graph(cache=False)
    d = g.Distribution(kind="classes", class_edges=np.array([1.5, 3, 4.5]), N_V=(np.float32(0.5), 0.25))
    assert d["class_edges"] == [1.5, 3.0, 4.5] and d["N_V"] == [0.5, 0.25]
    for value in (float("nan"), float("inf"), "x", [1, 2], {}, object(), -1):
        with pytest.raises(t.Error) as e:
            d["mean"] = value
        assert e.value.code == "bad-value", value
    d["classes"] = np.int64(5)
    assert d["classes"] == 5
    for value in (2.5, True, 10**30):
        with pytest.raises(t.Error):
            d["classes"] = value


def test_code_of_the_users_classes_may_edit_the_graph():
    import enum

    import numpy as np
    g = t.Graph(cache=False)
    g.parameter("photo", "path", "a.jpg")

    class Path:
        def __init__(self, edit):
            self.edit = edit

        def __fspath__(self):
            for k in range(100):
                self.edit(k)
            return "b.jpg"

    g.parameters["photo"] = Path(lambda k: g.parameter(f"p{len(g.parameters)}", "int", k))
    assert g.parameters["photo"].endswith("b.jpg") and len(g.parameters) == 101
    photo = g.LoadImage(path=Path(lambda k: g.Pattern(name=f"n{k}")))
    with pytest.raises(t.Error):  # what __fspath__ added stays
        g.LoadImage(path=Path(lambda k: g.Pattern(name=f"m{k}")), pixel_size=-1)
    assert len(g) == 201
    with pytest.raises(t.Error) as e:
        photo.set(path=Path(lambda k: g.__delitem__("load_image") if "load_image" in g else None))
    assert e.value.code == "unknown-node"

    class Wrong:
        def __fspath__(self):
            return 3

    loop = []
    loop.append(loop)
    d = g.Distribution(kind="classes", class_edges=[1, 2], N_V=0.1)
    for value in (Wrong(), loop, {"a": loop}, [loop], np.zeros((2, 2)), [None], Ellipsis):
        with pytest.raises(t.Error) as e:
            d["N_V"] = value
        assert e.value.code == "bad-value"

    class Number(enum.IntEnum):
        FIVE = 5

    class Real(float):
        pass

    d.set(classes=Number.FIVE, mean=Real(2.5), sd=np.float32(0.5), N_V=np.array(0.25))
    assert (d["classes"], d["mean"], d["sd"], d["N_V"]) == (5, 2.5, 0.5, [0.25])
    d["N_V"] = (np.int8(1),)
    assert d["N_V"] == [1] and "N_V: [1]" in g.to_yaml()


def test_explain_and_run():
    g, dots, seg = small()
    plan = g.explain()
    assert [(s.node, s.step) for s in plan] == [("pattern", "runs"), ("segment", "runs")]
    run = g.run()
    assert [n["status"] for n in run.nodes] == ["computed", "computed"]
    assert run.metrics["segment"]["profiles"] > 0
    assert [s.step for s in g.explain()] == ["cached", "cached"]
    assert re.search(r"2 cached, 0 to run", str(g.explain()))
    assert [n["status"] for n in g.run(seg).nodes] == ["memory", "memory"]


def test_an_input_and_a_parameter_of_one_name():
    g, dots, seg = small()
    shape = g.ShapeEstimate(profiles=seg.profiles)
    shape["profiles"] = 50
    shape.set(profiles=60)
    assert shape["profiles"] == [60] and "inputs: {profiles: segment.profiles}" in g.to_yaml()
    shape.set(profiles=None, class_=1)
    assert shape["class"] == 1
    assert shape["profiles"] != [60] and "inputs: {profiles: segment.profiles}" in g.to_yaml()


def test_texts_that_are_not_utf8():
    g = t.Graph(cache=False)
    bad = "caf\udce9.png"  # as Python reads names of files that are not UTF-8
    for call in (lambda: g.LoadImage(path=bad), lambda: g.LoadImage(path=pathlib.Path(bad)), lambda: t.load(bad), lambda: g.save(bad),
                 lambda: g.run(out=bad), lambda: t.Graph(cache=bad), lambda: g._add("Pattern", {bad: 1}), lambda: t.reproduce(bad),
                 lambda: g.Pattern(name=bad), lambda: t.cache.stats(bad), lambda: t.read_sweep(bad), lambda: g.subgraph(bad)):
        with pytest.raises(t.Error, match="is not UTF-8") as e:
            call()
        assert e.value.code == "bad-value" and e.value.hint
    assert not os.listdir(".")


def test_wrong_options():
    for options in ({"threads": -1}, {"threads": 2000}, {"memory": -1}, {"file_memory": 2**70}):
        with pytest.raises(ValueError, match=f"{next(iter(options))} must be from 0 to"):
            t.Graph(**options)
    with pytest.raises(TypeError):
        t.Graph(threads="4")


def test_a_device_is_not_replaced():
    os.mkfifo("pipe")
    g = t.Graph(cache=False)
    sweep = g.sweep({"pattern.seed": [1]}, g.Pattern().image)
    for save in (g.save, sweep.save):
        with pytest.raises(t.Error, match="a device or a pipe") as e:
            save("pipe")
        assert e.value.code == "write-failed"
    assert os.listdir(".") == ["pipe"] and pathlib.Path("pipe").is_fifo()


def test_the_disk_cache_is_the_programs():
    def graph():
        g = t.Graph()
        return g.Pattern(kind="fat", width=48, height=48).image

    first = graph().value()
    run = graph().graph.run()
    assert [n["status"] for n in run.nodes] == ["disk"]
    stats = t.cache.stats()
    assert stats["types"]["Image"][0] == 1 and stats["records"] == 1
    assert t.cache.collect()["values"] == 0
    found = t.cache.verify(sample=5)
    assert (found["values"], found["records"], found["recomputed"]) == (1, 1, 1)
    assert found["damaged"] == [] and found["differing"] == []
    values = [f for f in pathlib.Path(t.cache.folder()).rglob("*") if f.is_file() and f.stat().st_size > 20_000]
    damaged = bytearray(values[0].read_bytes())
    damaged[-100] ^= 1
    values[0].chmod(0o644)
    values[0].write_bytes(damaged)
    assert len(t.cache.verify()["damaged"]) == 1 and not values[0].exists()
    t.cache.clear()
    assert t.cache.stats()["records"] == 0
    assert graph().value() == first


def test_an_input_file_that_changes_is_seen(tmp_path):
    import numpy as np
    t.image(np.zeros((4, 4, 3), np.uint8)).save(tmp_path / "a.png")
    g = t.Graph(cache=False)
    out = g.LoadImage(path=tmp_path / "a.png").image
    assert out.value().pixels.max() == 0
    t.image(np.full((4, 4, 3), 255, np.uint8)).save(tmp_path / "a.png")
    assert out.value().pixels.min() == 1


def test_former_names_are_notes(tmp_path):
    file = tmp_path / "old.yaml"
    file.write_text("terrazzo: 1\nnodes:\n  a: {type: Pattern}\n  b: {type: Segment, inputs: {image: a.image}, "
                    "params: {method: regions}}\n")
    g = t.load(file, cache=False)
    assert [d.severity for d in g.check()] == ["note"]


def test_every_type_can_be_called():
    for name in t.nodes:
        info = t._core.node_type(name)
        ports = {p["name"] for p in info["inputs"]}
        parameters = {p["name"] for p in info["parameters"]}
        assert "name" not in ports | parameters, name
        assert not hasattr(t._core.Graph, name)
        signature = inspect.signature(t.nodes.__getattr__(name))
        assert ports | parameters - {"source_hash"} <= {p.rstrip("_") for p in signature.parameters}
