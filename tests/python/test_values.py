"""Values as numpy arrays."""

import gc
import json
import pickle

import numpy as np
import pytest

import terrazzo as t
from conftest import SOURCE


def address(array):
    return array.__array_interface__["data"][0]


@pytest.fixture(scope="module")
def graph():
    g = t.Graph(cache=False)
    shapes = g.Shape(kind="sphere", count=1, size=5, name="ball").shapes
    sizes = g.Distribution(shapes=shapes, kind="lognormal", mean=5, sd=1, volume_fraction=0.2, name="sizes")
    pack = g.Anneal(distribution=sizes.distribution, shapes=shapes, size=30, name="pack")
    g.Section(particles=pack.particles, shapes=shapes, axis="z", pixel_size=0.25, name="section")
    g.KMatrix(shapes=shapes, method="analytic", name="kmatrix")
    g.Unfold(profiles=g["section"].profiles, kmatrix=g["kmatrix"].kmatrix, bootstrap=10, name="unfold")
    g.Voxelize(particles=pack.particles, shapes=shapes, resolution=32, name="voxels")
    return g


def arrays_of(value):
    """Every view of a value, by name."""
    fields = {"Image": ["pixels"], "Labels": ["ids", "classes"], "SizeDistribution": ["class_edges"],
              "Profiles": ["section", "cls", "area", "centroid", "touches_border", "weight", "confidence", "color"],
              "Particles": ["shape", "cls", "position", "orientation", "scale", "size", "color"]}
    out = {name: getattr(value, name) for name in fields.get(value.type, [])}
    if value.type == "Shapes":
        out = {"vertices": value[0].mesh.vertices, "triangles": value[0].mesh.triangles}
    if value.type == "SizeDistribution":
        out.update(N_V=value.entries[0].N_V, low=value.entries[0].low, high=value.entries[0].high)
    if value.type == "KMatrix":
        out = {"K": value.entries[0].K, "cdf": value.entries[0].cdf}
    return out


OUTPUTS = ["ball.shapes", "sizes.distribution", "pack.particles", "section.image", "section.labels",
           "section.profiles", "kmatrix.kmatrix", "unfold.distribution"]


@pytest.mark.parametrize("output", OUTPUTS)
def test_arrays_are_views_of_the_values_memory(graph, output):
    value = graph._output_at(output).value()
    again = graph._output_at(output).value()
    views = arrays_of(value)
    assert views
    for name, array in views.items():
        assert not array.flags.owndata and not array.flags.writeable, name
        # Asked again, and from the store again: the same memory, so nothing was copied.
        assert address(array) == address(arrays_of(value)[name]) == address(arrays_of(again)[name]), name
        with pytest.raises(ValueError):
            array[...] = 0
        with pytest.raises(ValueError):
            array.flags.writeable = True


@pytest.mark.parametrize("output", OUTPUTS)
def test_views_keep_the_value_alive(output):
    def views():
        g = t.Graph(cache=False)
        shapes = g.Shape(kind="sphere", size=5, name="ball").shapes
        sizes = g.Distribution(shapes=shapes, mean=5, sd=1, volume_fraction=0.15, name="sizes")
        pack = g.Anneal(distribution=sizes, shapes=shapes, size=24, name="pack")
        g.Section(particles=pack.particles, shapes=shapes, pixel_size=0.4, name="section")
        g.KMatrix(shapes=shapes, method="analytic", name="kmatrix")
        g.Unfold(profiles=g["section"].profiles, kmatrix=g["kmatrix"], bootstrap=5, name="unfold")
        kept = arrays_of(g._output_at(output).value())
        return kept, {name: array.copy() for name, array in kept.items()}

    kept, copies = views()
    gc.collect()
    rubbish = [np.full(100_000, 255, np.uint8) for _ in range(50)]  # reuses memory that was freed
    for name in kept:
        assert np.array_equal(kept[name], copies[name]), name
    del rubbish


def test_fields_agree_with_the_json_of_the_value(graph):
    p = graph["section"].profiles.value()
    listed = p.describe(full=True)["profiles"]
    assert len(p) == len(listed) > 3
    for field, key in (("area", "area"), ("weight", "weight"), ("centroid", "centroid"), ("color", "color"),
                       ("cls", "class"), ("section", "section"), ("touches_border", "touches_border")):
        assert np.allclose(getattr(p, field), [row[key] for row in listed]), field
    assert p.area.dtype == np.float64 and p.color.shape == (len(p), 3) and p.touches_border.dtype == bool
    assert np.allclose(p.contour(0), listed[0]["contour"]) and p.contour(-1).shape[1] == 2
    with pytest.raises(IndexError):
        p.contour(len(p))
    d = graph["unfold"].distribution.value()
    assert np.allclose(d.entries[0].N_V, d.describe(full=True)["shapes"][0]["N_V"])
    assert np.allclose(d.N_V, sum(e.N_V for e in d.entries))
    assert len(d.class_edges) == len(d.N_V) + 1


def test_labels_agree_with_profiles(graph):
    labels, profiles = graph["section"].labels.value(), graph["section"].profiles.value()
    assert labels.ids.max() == labels.count == len(profiles) == len(labels.classes)
    pixels = np.bincount(labels.ids.ravel(), minlength=labels.count + 1)[1:]
    assert np.allclose(pixels * labels.pixel_size**2, profiles.area, rtol=0.2, atol=0.5)
    assert np.asarray(labels).base is not None and np.asarray(labels, dtype=float).dtype == float


def test_particles_are_inside_of_the_box(graph):
    p = graph["pack"].particles.value()
    assert p.position.shape == (len(p), 3) and (p.position >= 0).all() and (p.position < p.box).all()
    assert np.allclose(np.linalg.norm(p.orientation, axis=1), 1)
    assert p.voids.shape == (len(p),) and not p.voids.any()


def test_the_mesh_is_closed(graph):
    shape = graph["ball"].shapes.value()[0]
    a, b, c = np.moveaxis(shape.mesh.vertices[shape.mesh.triangles], 1, 0)
    assert np.isclose(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6, shape.volume)
    with pytest.raises(IndexError):
        graph["ball"].shapes.value()[1]


def test_kmatrix_is_by_row(graph):
    k = graph["kmatrix"].kmatrix.value().entries[0]
    assert k.K.shape == (len(k.K), len(k.K))
    assert np.allclose(np.tril(k.K, -1), 0)  # no profile is larger than its particle
    assert np.allclose(k.K, graph["kmatrix"].kmatrix.value().describe(full=True)["shapes"][0]["K"])


def test_table(graph):
    table = graph["unfold"].table.value()
    assert table["N_V mm⁻³"].dtype == np.float64 and len(table["N_V mm⁻³"]) == len(table) == len(table.rows)
    with pytest.raises(t.Error) as e:
        table["volume shar"]
    assert e.value.code == "no-column" and "did you mean" in e.value.message
    assert list(table.to_dict()) == table.columns
    numbers = t.table({"a": [1, 2, 3], "b": [4, float("nan"), 6]}).to_numpy()
    assert numbers.shape == (3, 2) and numbers.dtype == np.float64 and numbers[2, 1] == 6 and np.isnan(numbers[1, 1])
    with pytest.raises(TypeError, match="'name' contains text"):
        t.table({"size": [1, 2.5], "name": ["a", "b"]}).to_numpy()


def test_effective_tensor_is_an_array():
    layers = np.zeros((8, 8, 8), np.int32)
    layers[4:] = 1
    g = t.Graph(cache=False)
    tensor = g.Homogenize(volume=t.volume(layers, 0.5, name="id", period=True), values=[1, 3]).tensor.value().to_numpy()
    assert np.allclose(tensor, np.diag([1.5, 2, 2]), atol=1e-4)


def test_grids_are_dense_on_request(graph):
    v = graph["voxels"].volume.value()
    assert v.resolution == (32, 32, 32)
    density = v.dense("density")
    assert density.shape == (32, 32, 32) and density.flags.owndata and density.flags.writeable
    assert 0.1 < density.mean() < 0.3
    ids, colors = v.dense("id"), v.dense("Cd")
    assert ids.shape == (32, 32, 32) and colors.shape == (32, 32, 32, 3)
    # The first axis is x: the voxel that contains a particle's center has the particle's number.
    p = graph["pack"].particles.value()
    at = np.floor(p.position / v.voxel_size).astype(int) % 32
    found = ids[at[:, 0], at[:, 1], at[:, 2]]
    assert len(np.unique(found)) == len(p)
    with pytest.raises(t.Error, match="has no grid 'densty'; did you mean 'density'"):
        v.dense("densty")


def test_values_survive_pickling(graph):
    for output in OUTPUTS + ["voxels.volume", "unfold.table"]:
        value = graph._output_at(output).value()
        again = pickle.loads(pickle.dumps(value))
        assert again == value and again.content == value.content and type(again) is type(value)
    with pytest.raises(t.Error):
        t._core.decoded("Image", b"rubbish")
    shapes = graph["ball"].shapes
    for other in (graph, graph["ball"], shapes, shapes.value()[0], shapes.value()[0].mesh, graph.start(shapes)):
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            with pytest.raises(TypeError, match="cannot be pickled"):
                pickle.dumps(other, protocol)


def test_equal_values_are_equal(graph):
    a = t.image(np.ones((2, 2, 3)))
    assert a == t.image(np.ones((2, 2, 3))) and hash(a) == hash(t.image(np.ones((2, 2, 3))))
    assert a != t.image(np.zeros((2, 2, 3))) and a != 3


def test_saved_files(tmp_path, graph):
    graph["section"].image.value().save(tmp_path / "s.png")
    graph["unfold"].table.value().save(tmp_path / "t.csv")
    graph["pack"].particles.value().save(tmp_path / "p.json")
    assert (tmp_path / "s.png").read_bytes()[:4] == b"\x89PNG"
    assert (tmp_path / "t.csv").read_text().startswith("class")
    with pytest.raises(t.Error):
        graph["section"].image.value().save(tmp_path / "s.nope")


def test_every_documented_unit(graph):
    for cls, names in {t.Image: ["pixel_size", "pixels"], t.Profiles: ["area", "centroid"],
                       t.SizeDistribution: ["class_edges", "N_V"], t.Particles: ["position", "size"]}.items():
        for name in names:
            assert "mm" in getattr(cls, name).__doc__ or "linear" in getattr(cls, name).__doc__


def test_relative_densities_have_no_unit(graph, tmp_path):
    sizes = graph["sizes"].distribution.value()
    assert "N_V mm⁻³" in sizes._repr_html_()
    file = tmp_path / "sizes.json"
    file.write_text(json.dumps({"class_edges": [1, 2], "volume_fraction": 0, "d_max": 2, "goodness_of_fit": 0, "shapes": [
        {"shape": -1, "class": 0, "N_V": [1], "low": [1], "high": [1]}]}))
    g = t.Graph(cache=False)
    html = g.LoadDistribution(path=str(file)).distribution.value()._repr_html_()
    assert "N_V relative" in html and "mm⁻³" not in html


def test_descriptions_are_short(graph):
    mesh = graph["ball"].shapes.value()
    ids = np.arange(40_000).reshape(200, 200) + 1
    labels = t.labels(ids, 0.5)
    text = t.table({"name": ["x" * 5000] * 3000, "value": range(3000)})
    for value in (mesh, labels, text, graph["section"].profiles.value(), graph["pack"].particles.value()):
        assert len(json.dumps(value.describe())) < 25_000, value
    short = text.describe()["rows"]
    assert short["of"] == 3000 and len(short["shown"]) < 100
    assert len(text.describe(full=True)["rows"]) == 3000

