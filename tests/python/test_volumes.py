"""Volumes as arrays and as grids of OpenVDB's own Python module."""

import numpy as np
import pytest

import terrazzo as t


def solid():
    g = t.Graph(cache=False)
    balls = g.Anneal(distribution=g.Distribution(mean=2, sd=0.2), shapes=g.Shape(kind="sphere"), size=8)
    return g.Voxelize(particles=balls.particles, shapes=g["shape"].shapes, resolution=24).volume.value()


def test_arrays_become_volumes():
    rng = np.random.default_rng(1)
    density = rng.random((3, 4, 5), np.float32)
    v = t.volume(density, 0.5)
    assert np.array_equal(v.dense("density"), density) and v.voxel_size == 0.5
    ids = rng.integers(-1, 7, (4, 3, 2)).astype(np.int32)
    colors = rng.random((3, 4, 5, 3)).astype(">f8")
    assert np.array_equal(t.volume(colors, (1, 2, 3), name="Cd").dense("Cd"), colors.astype(np.float32))
    assert v.resolution == (0, 0, 0)
    labels = t.volume(np.asfortranarray(ids)[::-1], (0.1, 0.1, 0.1), name="id")
    assert np.array_equal(labels.dense("id"), ids[::-1]) and labels.dense("id").dtype == np.int32
    g = t.Graph(cache=False)
    assert g.RenderVolume(volume=t.volume(density, 0.5), width=32, height=32).image.value().pixels.max() > 0


@pytest.mark.parametrize("array, size", [
    (np.zeros((2, 2)), 1), (np.zeros((2, 2, 2)), 0), (np.zeros((2, 2, 2)), (1, 2)), (np.zeros((2, 2, 2)), float("nan")),
    (np.full((2, 2, 2), np.nan), 1), (np.zeros((0, 2, 2)), 1), (np.zeros((2, 2, 2), complex), 1), (np.zeros((2, 2, 2)), ()),
    (np.zeros((2, 2, 2, 2)), 1), (np.full((2, 2, 2, 3), np.inf), 1), (np.zeros((2, 2, 2)), -1), (np.zeros((2, 2, 2)), 1e-10),
    (np.broadcast_to(np.float32(0), (1 << 20, 1 << 20, 1 << 20)), 1), (np.broadcast_to(np.int8(0), (1 << 30, 1, 1)), 1),
    (np.ma.masked_less(np.zeros((2, 2, 2)), 1), 1),
])
def test_wrong_arrays(array, size):
    with pytest.raises(t.Error):
        t.volume(array, size)


def test_wrong_ids():
    for ids in (np.zeros((2, 2, 2)), np.zeros((2, 2, 2, 3), int), np.full((2, 2, 2), 2**31), np.full((2, 2, 2), 2**64 - 1, np.uint64)):
        with pytest.raises(t.Error):
            t.volume(ids, 1, name="id")
    big = t.volume(np.array([[[2**31 - 1, -5]]]), 1, name="id").dense("id")
    assert big.max() == 2**31 - 1


def test_arrays_that_tile():
    density = np.random.default_rng(2).random((4, 6, 8), np.float32)
    tiling = t.volume(density, 0.5, period=True)
    assert tiling.resolution == (4, 6, 8) and np.array_equal(tiling.dense("density"), density)
    assert t.volume(density, 0.5, period=(4, 6, 10)).resolution == (4, 6, 10)
    assert t.volume(density, 0.5, period=False).resolution == (0, 0, 0)
    assert tiling != t.volume(density, 0.5)
    # At its border, Section continues a volume that tiles, and fades the other one into the background.
    g = t.Graph(cache=False)
    least = [g.Section(volume=t.volume(np.ones((4, 6, 8)), 0.5, period=tiles), axis="z", offsets=[0], pixel_size=0.5).image
             .value().pixels.min() for tiles in (True, False)]
    assert least[0] > 0.999 and least[1] < 0.999
    for period in ((4, 6), (0, 6, 8), (4, 6, 7), (4, 6, 1 << 30), (-4, 6, 8)):
        with pytest.raises(t.Error) as e:
            t.volume(density, 0.5, period=period)
        assert e.value.parameter == "period"


def test_wrong_objects():
    with pytest.raises(TypeError, match="voxel_size"):
        t.volume(np.zeros((2, 2, 2)))
    with pytest.raises(TypeError, match="pyopenvdb"):
        t.volume([np.zeros((2, 2, 2))])
    with pytest.raises((ValueError, t.Error)):
        t.volume(np.full((2, 2, 2), object()), 1)


def test_grids_of_pyopenvdb():
    vdb = pytest.importorskip("pyopenvdb")
    volume = solid()
    grids = {grid.name: grid for grid in volume.to_pyopenvdb()}
    assert sorted(grids) == sorted(volume.grids)
    dense = np.zeros(volume.resolution, np.float32)
    grids["density"].copyToArray(dense)
    assert np.array_equal(dense, volume.dense("density"))
    grids["id"].copyToArray(dense)
    assert np.array_equal(dense, volume.dense("id"))
    assert np.isclose(grids["density"].transform.voxelSize()[0], volume.voxel_size)
    assert volume.resolution == (24, 24, 24) and grids["density"]["period"] == (24, 24, 24)
    again = t.volume(list(grids.values()))
    assert again.grids == volume.grids and np.array_equal(again.dense("density"), volume.dense("density"))
    assert again.resolution == (24, 24, 24) and grids["density"]["period"] == (24, 24, 24)
    assert all(np.array_equal(again.dense(name), volume.dense(name)) for name in volume.grids)
    assert t.volume(list(grids.values()), period=False).resolution == (0, 0, 0)
    assert t.volume(grids["density"], period=(24, 24, 48)).resolution == (24, 24, 48)
    far = vdb.FloatGrid()
    for x in (-2**31, 2**31 - 1):
        far.getAccessor().setValueOn((x, 0, 0), 1.0)
    with pytest.raises(t.Error) as e:
        t.volume(far).dense("")
    assert e.value.code
    del grids["density"]["period"]
    with pytest.raises(ValueError, match="different periods"):
        t.volume(list(grids.values()))
    with pytest.raises(TypeError, match="period"):
        t.volume(grids["density"], period=True)

    ball = vdb.createLevelSetSphere(radius=4.0, voxelSize=0.5)
    ball.name = "surface"
    v = t.volume(ball)
    assert v.grids == ["surface"] and v.voxel_size == 0.5
    dense = np.zeros(v.dense("surface").shape, np.float32)
    ball.copyToArray(dense, ijk=v.origin("surface"))
    assert np.array_equal(dense, v.dense("surface"))


def test_a_given_array_is_the_whole_volume():
    n = 24
    x, y, z = np.indices((n, n, n)) - 8
    ids = np.where(x**2 + y**2 + z**2 < 36, 3, -1)
    given = t.volume(ids, 0.5, name="id")
    assert given.extent == (n, n, n) and given.origin("id") == (0, 0, 0)
    assert np.array_equal(given.dense("id"), ids)
    g = t.Graph(cache=False)
    measured = g.Measure3D(volume=given).table.value()
    rows = {row[0]: row[1] for row in measured.rows}
    assert np.isclose(rows["volume fraction, voxels"], (ids >= 0).mean())
    assert t.volume(ids, 0.5, name="id", period=True).extent == (0, 0, 0)


def test_whole_numbers_keep_their_digits():
    for whole in (np.full((2, 2, 2), 2**24 + 1), np.full((2, 2, 2), 2**53 + 1, np.uint64), np.full((2, 2, 2), 2**64 - 1, np.uint64)):
        with pytest.raises(t.Error) as e:
            t.volume(whole, 1)
        assert e.value.code == "bad-values"
    assert t.volume(np.full((2, 2, 2), 2**24), 1).dense("density").max() == 2**24


def test_the_extent_survives_pyopenvdb():
    pytest.importorskip("pyopenvdb")
    ids = np.full((8, 9, 10), -1)
    ids[2, 3, 4] = 5
    given = t.volume(ids, 0.5, name="id")
    grids = given.to_pyopenvdb()
    assert grids[0]["extent_max"] == (7, 8, 9)
    again = t.volume(grids)
    assert again.extent == (8, 9, 10) and np.array_equal(again.dense("id"), ids)
