"""What notebooks and help() show."""

import inspect
import io
import pydoc
import struct
import zlib

import numpy as np
import pytest

import terrazzo as t


def pixels_of(png):
    """Decodes a PNG file of one IDAT chunk without filters."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    at, data, header = 8, b"", None
    while at < len(png):
        size, kind = struct.unpack(">I4s", png[at:at + 8])
        body = png[at + 8:at + 8 + size]
        assert zlib.crc32(kind + body) == struct.unpack(">I", png[at + 8 + size:at + 12 + size])[0]
        header = struct.unpack(">2I5B", body) if kind == b"IHDR" else header
        data += body if kind == b"IDAT" else b""
        at += 12 + size
    width, height = header[:2]
    assert header[2:] == (8, 2, 0, 0, 0)
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + 3 * width)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, 3)


def test_images_are_pictures(tmp_path):
    bytes_in = np.arange(4 * 16 * 3, dtype=np.uint8).reshape(4, 16, 3)
    image = t.image(bytes_in)
    shown = pixels_of(image._repr_png_())
    assert np.array_equal(shown, bytes_in)
    # The file that Export writes has the same pixels.
    image.save(tmp_path / "a.png")
    g = t.Graph(cache=False)
    assert np.allclose(g.LoadImage(path=tmp_path / "a.png").image.value().pixels, image.pixels, atol=1e-6)
    assert pixels_of(t.image(np.zeros((3, 5, 6, 3)))._repr_png_()).shape[2] == 3
    assert max(pixels_of(t.image(np.zeros((5000, 100, 3)))._repr_png_()).shape) <= 2048


def test_labels_are_pictures():
    ids = np.array([[0, 1], [2, 3]])
    shown = pixels_of(t.labels(ids)._repr_png_()).reshape(-1, 3)
    assert shown[0].tolist() == [0, 0, 0] and len({tuple(c) for c in shown.tolist()}) == 4
    assert shown[1:].min() >= 64


def test_volumes_are_pictures():
    colors = np.zeros((4, 6, 3, 3), np.float32)
    colors[3, :, 1], colors[:, 5, 1, 1] = (1, 0, 0), 1
    shown = pixels_of(t.volume(colors, 1, name="Cd")._repr_png_())
    assert shown.shape == (6, 4, 3)  # x to the right
    assert np.array_equal(shown[0], [[0, 255, 0]] * 3 + [[255, 255, 0]])  # y up
    assert np.array_equal(shown[5], [[0, 0, 0]] * 3 + [[255, 0, 0]])
    gray = pixels_of(t.volume(np.arange(24).reshape(4, 6, 1) - 5.0, 1)._repr_png_())
    assert gray[5, 0].tolist() == [0, 0, 0] and gray[0, 3].tolist() == [255] * 3
    assert not pixels_of(t.volume(np.ones((2, 2, 2)), 1)._repr_png_()).any()
    assert pixels_of(t.volume(np.ones((2, 3000, 2)), 1, period=True)._repr_png_()).shape == (1500, 1, 3)


def test_html_is_escaped():
    html = t.table({"<b>": [1.5, "<script>"]})._repr_html_()
    assert "<script>" not in html and "&lt;script&gt;" in html and "&lt;b&gt;" in html and "1.5" in html
    assert "40 more rows" in t.table({"a": list(range(100))})._repr_html_()
    g = t.Graph(cache=False)
    g.Pattern(name="picture")
    assert g._repr_html_().startswith("<svg") and "picture" in g._repr_html_()
    g.Segment(name="lonely")
    assert "lonely" in g._repr_html_() and "error" in g._repr_html_()
    with pytest.raises(t.Error) as e:
        g._add("<i>", {})
    assert "&lt;i&gt;" in e.value._repr_html_() and "<i>" not in e.value._repr_html_() and e.value.code in e.value._repr_html_()
    d = t.sizes([1, 2], [0.01])
    assert "N_V" in d._repr_html_()
    assert "<table>" in t.Graph(cache=False).run()._repr_html_()


def test_values_of_many_elements_are_tables():
    g = t.Graph(cache=False)
    shapes = g.Shape(kind="rock", count=2, size=5).shapes
    sizes = g.Distribution(shapes=shapes, mean=5, sd=1, volume_fraction=0.2)
    pack = g.Anneal(distribution=sizes, shapes=shapes, size=40).particles
    profiles = g.Section(particles=pack, shapes=shapes, pixel_size=0.5).profiles
    for output, head in ((shapes, "volume mm³"), (pack, "position mm"), (profiles, "area mm²")):
        value = output.value()
        html = value._repr_html_()
        assert f"<th>{head}</th>" in html and html.count("<tr>") == 1 + min(len(value), 60)
        assert (f"<p>{len(value) - 60} more rows</p>" in html) == (len(value) > 60)
    assert len(pack.value()) > 60 and f"<td>{profiles.value().area[0]:.5g}</td>" in profiles.value()._repr_html_()
    assert "<td>&lt;b&gt;</td>" in t.mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
                                          name="<b>")._repr_html_()


def test_help_reads_like_the_reference():
    text = pydoc.render_doc(t.nodes.Anneal, renderer=pydoc.plaintext)
    info = t._core.node_type("Anneal")
    assert "Anneal(graph: 'Graph', /, *, distribution: 'SizeDistribution'" in text
    flat = " ".join(text.split())
    for item in info["inputs"] + info["outputs"] + info["parameters"]:
        assert item["name"] in text and " ".join(item["doc"].split()) in flat, item["name"]
    assert "Jagnow" in text and "seed: int; default 1; 0 to 9007199254740991" in text
    method = pydoc.render_doc(t.Graph(cache=False).Anneal, renderer=pydoc.plaintext)  # what notebooks show while one types
    assert "Anneal(*, distribution: 'SizeDistribution'" in method and "Jagnow" in method
    for name in ("metric", "warn", "progress"):
        assert "arg0" not in pydoc.render_doc(getattr(t, name), renderer=pydoc.plaintext) and getattr(t, name).__doc__.count("\n") > 1
    for name in t.nodes:
        assert pydoc.render_doc(getattr(t.nodes, name), renderer=pydoc.plaintext)


def test_signatures_list_parameters_with_defaults():
    signature = inspect.signature(t.nodes.Pattern)
    info = t._core.node_type("Pattern")
    for p in info["parameters"]:
        if p["kind"] != "color":
            assert repr(signature.parameters[p["name"]].default) == repr(p["default"]), p["name"]
    assert signature.parameters["name"].default is None
    assert "photo" in inspect.signature(t.library.aggregate).parameters
    text = io.StringIO()
    pydoc.Helper(output=text).help(t.library.aggregate)
    assert "Particle" in text.getvalue() or "particle" in text.getvalue()


def test_names_are_completed():
    g = t.Graph(cache=False)
    dots = g.Pattern()
    g.output("picture", dots.image)
    assert "image" in dir(dots) and "picture" in dir(g) and "Segment" in dir(g) and "Segment" in dir(t.nodes)
    assert not [name for name in dir(t.nodes) if name.startswith("Given")]


@pytest.mark.parametrize("value", [t.image([[0.5]]), t.labels([[1]]), t.sizes([1, 2], [0.01]), t.table({"a": [1]})])
def test_representations(value):
    assert repr(value).startswith(f"<{value.type} ")
    assert value.describe()


def test_drawings():
    g = t.Graph(cache=False)
    g.Grain(image=g.Pattern().image)
    assert g.draw("dot").startswith("digraph") and g.draw("mermaid").startswith("flowchart")
    with pytest.raises(t.Error):
        g.draw("png")
