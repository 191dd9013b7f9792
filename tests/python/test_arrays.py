"""Arrays of the user as values: correct results or errors, never a crash."""

import numpy as np
import pytest

import terrazzo as t


def code(call, *arguments, **options):
    with pytest.raises(t.Error) as e:
        call(*arguments, **options)
    assert e.value.message
    return e.value.code


def test_images_keep_their_pixels():
    rng = np.random.default_rng(1)
    a = rng.random((5, 7, 3), dtype=np.float32)
    image = t.image(a, 0.5)
    assert np.array_equal(image.pixels, a)
    assert (image.width, image.height, image.sections, image.pixel_size) == (7, 5, 1, 0.5)
    a[:] = 0
    assert image.pixels.max() > 0  # a copy
    stack = rng.random((2, 5, 7, 3)).astype(np.float32)
    assert np.array_equal(t.image(stack).pixels, stack)


def test_images_of_other_kinds():
    gray = np.linspace(0, 1, 12, dtype=np.float32).reshape(3, 4)
    assert np.array_equal(t.image(gray).pixels, np.repeat(gray[..., None], 3, axis=-1))
    assert np.array_equal(t.image(np.dstack([gray] * 4)).pixels[..., 0], gray)
    srgb = np.arange(256, dtype=np.uint8).reshape(16, 16)
    linear = t.image(srgb).pixels[..., 0]
    v = srgb / 255
    assert np.allclose(linear, np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4), atol=1e-6)
    assert np.allclose(t.image(srgb, srgb=False).pixels[..., 0], v, atol=1e-6)
    assert np.allclose(t.image(srgb.astype(np.uint16) * 257).pixels, t.image(srgb).pixels, atol=1e-6)
    assert t.image(srgb > 100).pixels.max() == 1
    assert t.image([[0.5, 0.25]]).pixels.shape == (1, 2, 3)


@pytest.mark.parametrize("make", [
    lambda a: a[::2, ::-1], lambda a: np.asfortranarray(a), lambda a: a.transpose(1, 0, 2), lambda a: a.astype(">f4"),
    lambda a: a.astype(np.float16), lambda a: a.astype(np.longdouble), lambda a: np.broadcast_to(a[:1], a.shape)])
def test_arrays_with_any_layout(make):
    a = make(np.random.default_rng(2).random((6, 8, 3), dtype=np.float32))
    assert np.allclose(t.image(a).pixels, a.astype(np.float32))


def test_read_only_arrays():
    a = np.ones((3, 3, 3), np.float32)
    a.flags.writeable = False
    assert t.image(a).pixels.min() == 1
    ids = np.array([[0, 1]])
    ids.flags.writeable = False
    assert t.labels(ids).count == 1


@pytest.mark.filterwarnings("ignore:overflow encountered in cast")
def test_wrong_images():
    assert code(t.image, np.full((2, 2, 3), np.nan)) == "bad-pixels"
    assert code(t.image, np.full((2, 2, 3), np.inf)) == "bad-pixels"
    assert code(t.image, np.full((2, 2, 3), 1e300)) == "bad-pixels"  # beyond float32
    assert code(t.image, np.zeros((2,))) == "wrong-shape"
    assert code(t.image, np.zeros((2, 2, 5))) == "wrong-shape"
    assert code(t.image, np.zeros((1, 1, 2, 2, 3))) == "wrong-shape"
    assert code(t.image, np.zeros((0, 4, 3))) == "empty-image"
    assert code(t.image, np.zeros((2, 2), complex)) == "wrong-type"
    assert code(t.image, np.zeros((2, 2), np.int64)) == "wrong-type"
    assert code(t.image, np.array([["a", "b"]])) == "wrong-type"
    assert code(t.image, np.array([[object()]])) == "wrong-type"
    assert code(t.image, object()) in ("wrong-type", "wrong-shape")
    assert code(t.image, None) in ("wrong-type", "wrong-shape")
    for size in (0, -1, np.nan, np.inf, 1e300, 5e-324):
        assert code(t.image, np.zeros((2, 2, 3)), size) == "bad-value"


def test_numbers_have_limits():
    tetrahedron = [[0, 0, 0], [1e300, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    assert code(t.mesh, *tetrahedron) == "bad-mesh"
    assert code(t.sizes, [1, 1e300], [1]) == code(t.sizes, [1, 2], [1e300]) == "bad-value"
    assert code(t.volume, np.zeros((2, 2, 2)), 1e300) == code(t.volume, np.zeros((2, 2, 2)), 5e-324) == "bad-value"


def test_masked_arrays_are_refused():
    mask = [[True, False]]
    assert code(t.image, np.ma.array([[0.5, 0.5]], mask=mask)) == "wrong-type"
    assert code(t.labels, np.ma.array([[1, 2]], mask=mask)) == "wrong-type"
    assert t.labels(np.ma.array([[1, 2]], mask=mask).filled(0)).count == 1


def test_huge_arrays_are_refused_before_they_are_copied():
    huge = np.broadcast_to(np.float32(0), (1 << 20, 1 << 20, 3))
    assert code(t.image, huge) == "too-large"
    assert code(t.image, np.broadcast_to(np.float32(0), (60000, 60000, 3))) == "too-large"
    assert code(t.labels, np.broadcast_to(np.int32(0), (1 << 20, 1 << 20))) == "too-large"
    assert code(t.labels, np.broadcast_to(np.int8(0), (60000, 60000))) == "too-large"
    assert code(t.mesh, np.broadcast_to(0.0, (1 << 40, 3)), [[0, 1, 2]]) == "too-large"
    assert code(t.sizes, np.broadcast_to(0.0, (1 << 45,)), [1]) == "too-large"


def test_labels_are_numbered_anew():
    labels = t.labels(np.array([[0, 7, 7], [3, 0, 900]]), 0.1)
    assert np.array_equal(labels.ids, [[0, 2, 2], [1, 0, 3]]) and labels.count == 3
    assert labels.pixel_size == 0.1 and np.array_equal(labels.classes, [0, 0, 0])
    stack = t.labels(np.array([[[0, 5]], [[5, 6]]]), classes=[2, 0, 1])
    assert np.array_equal(stack.ids, [[[0, 1]], [[2, 3]]]) and np.array_equal(stack.classes, [2, 0, 1])
    assert t.labels(np.array([[True, False]])).count == 1
    big = t.labels(np.array([[0, 2**62]], np.uint64))
    assert np.array_equal(big.ids, [[0, 1]])


def test_wrong_labels():
    assert code(t.labels, np.array([[-1, 1]])) == "bad-labels"
    for too_large in (lambda a: t.labels(a), lambda a: t.labels([[1]], classes=a[0])):
        with pytest.raises(t.Error, match=str(2**63 + 1)):
            too_large(np.array([[2**63 + 1]], np.uint64))
    assert code(t.labels, np.array([[0, 2**64 - 1]], np.uint64)) == "bad-labels"
    assert code(t.labels, np.zeros((2, 2), int)) == "no-particles"
    assert code(t.labels, np.zeros((2, 2))) == "wrong-type"
    assert code(t.labels, np.zeros(3, int)) == "wrong-shape"
    assert code(t.labels, np.zeros((0, 3), int)) == "empty-image"
    assert code(t.labels, np.array([[1, 2]]), classes=[0]) == "wrong-shape"
    assert code(t.labels, np.array([[1, 2]]), classes=[0.5, 1]) == "wrong-shape"
    assert code(t.labels, np.array([[1, 2]]), classes=[0, -1]) == "bad-labels"
    assert code(t.labels, np.array([[1, 2]]), classes=[0, 10**12]) == "bad-labels"


TETRAHEDRON = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def test_meshes():
    shape = t.mesh(*TETRAHEDRON, name="corner")[0]
    assert np.isclose(shape.volume, 1 / 6) and shape.name == "corner"
    assert np.allclose(shape.mesh.vertices, np.array(TETRAHEDRON[0]) - 0.25)
    assert np.array_equal(shape.mesh.triangles, TETRAHEDRON[1])
    assert np.isclose(shape.surface_area, 1.5 + np.sqrt(3) / 2)


def test_wrong_meshes():
    vertices, triangles = (np.array(a) for a in TETRAHEDRON)
    assert code(t.mesh, vertices, triangles[:3]) == "open-mesh"
    assert code(t.mesh, vertices, triangles[:, ::-1]) in ("no-volume", "open-mesh")
    assert code(t.mesh, vertices * np.nan, triangles) == "bad-mesh"
    assert code(t.mesh, vertices, triangles + 1) == "bad-mesh"
    assert code(t.mesh, vertices, triangles - 1) == "bad-mesh"
    assert code(t.mesh, vertices, triangles.astype(float)) == "wrong-type"
    assert code(t.mesh, vertices[:, :2], triangles) == "wrong-shape"
    assert code(t.mesh, vertices, np.zeros((1, 4), int)) == "wrong-shape"
    assert code(t.mesh, vertices, np.zeros((0, 3), int)) == "bad-mesh"
    assert code(t.mesh, vertices * 0, triangles) in ("no-volume", "open-mesh")


def test_sizes():
    d = t.sizes([1, 2, 4], [0.005, 0.0025], low=[0.004, 0.002], high=[0.006, 0.003])
    assert np.array_equal(d.class_edges, [1, 2, 4]) and np.array_equal(d.N_V, [0.005, 0.0025]) and d.d_max == 4
    assert np.array_equal(d.entries[0].low, [0.004, 0.002]) and np.array_equal(d.entries[0].high, [0.006, 0.003])
    g = t.Graph(cache=False)
    same = g.Distribution(kind="classes", class_edges=[1, 2, 4], N_V=[0.001, 0.0005]).distribution.value()
    assert t.sizes([1, 2, 4], [0.001, 0.0005]) == same


def test_wrong_sizes():
    assert code(t.sizes, [1, 2], [1, 2]) == "bad-classes"
    assert code(t.sizes, [2, 1], [1]) == "bad-classes"
    assert code(t.sizes, [1], []) == "bad-classes"
    assert code(t.sizes, [1, np.nan], [1]) == "bad-value"
    assert code(t.sizes, [1, 2], [-1]) == "bad-value"
    assert code(t.sizes, [1, 2], [[1]]) == "wrong-shape"
    assert code(t.sizes, [1, 2], ["a"]) == "wrong-type"
    assert code(t.sizes, [1, 2], [0.001], low=[0, 0]) == "bad-classes"
    assert code(t.sizes, [1, 2], [0.001], low=[0.002]) == "bad-classes"
    assert code(t.sizes, [1, 2], [0.001], high=[0]) == "bad-classes"


def test_tables():
    table = t.table({"a": [1, 2.5], "b": ["x", "y"]})
    assert np.array_equal(table["a"], [1, 2.5]) and table["b"] == ["x", "y"] and table.rows == [(1, "x"), (2.5, "y")]
    assert code(t.table, {"a": [1], "b": [1, 2]}) == "wrong-count"
    assert code(t.table, {"a": [[1]]}) == "wrong-type"
    assert code(t.table, {"a": ["\udc80"]}) == code(t.table, {"\udc80": [1]}) == "bad-value"
    with pytest.raises(TypeError, match="must be a list of cells"):
        t.table({"a": "text"})
    with pytest.raises(ValueError, match="two columns have the name '1'"):
        t.table({1: [1], "1": [2]})


def test_arrays_are_inputs_of_nodes():
    g = t.Graph(cache=False)
    ids = np.zeros((40, 40), int)
    for k in range(9):
        ids[4 + 12 * (k // 3):10 + 12 * (k // 3), 4 + 12 * (k % 3):10 + 12 * (k % 3)] = 5 * k + 1
    picture = np.where(ids[..., None] > 0, 0.8, 0.1).repeat(3, -1)
    seg = g.Segment(image=t.image(picture, 0.5), labels=t.labels(ids, 0.5))
    profiles = seg.profiles.value()
    assert len(profiles) == 9 and np.allclose(profiles.area, 9, rtol=0.06)
    assert [n.type for n in g.nodes] == ["GivenImage", "GivenLabels", "Segment"]
    with pytest.raises(t.Error) as e:
        g.save("arrays.yaml")
    assert e.value.code == "not-savable" and "image, labels" in e.value.message and "arrays=" in e.value.hint
    # An array that replaces another one does not keep it.
    for k in range(3):
        seg.set(image=t.image(picture * (1 - 0.1 * k), 0.5))
    assert len(g) == 3 and len(seg.profiles.value()) == 9
    with pytest.raises(t.Error) as e:
        seg.set(image=t.labels(ids))
    assert e.value.code == "wrong-type"
    with pytest.raises(t.Error) as e:
        seg.set(image=picture)
    assert e.value.code == "wrong-type" and "terrazzo.image" in e.value.hint


def test_equal_arrays_are_computed_once():
    def mean(array):
        g = t.Graph()
        return g.Grain(image=t.image(array), name="grain").image.graph.run().nodes[-1]["status"]

    a = np.random.default_rng(3).random((16, 16, 3))
    assert mean(a) == "computed"
    assert mean(a.copy()) == "disk"
    assert mean(a * 0.5) == "computed"
