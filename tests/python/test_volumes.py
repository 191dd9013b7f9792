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
    labels = t.volume(np.asfortranarray(ids)[::-1], (0.1, 0.1, 0.1), name="id")
    assert np.array_equal(labels.dense("id"), ids[::-1]) and labels.dense("id").dtype == np.int32
    g = t.Graph(cache=False)
    assert g.RenderVolume(volume=t.volume(density, 0.5), width=32, height=32).image.value().pixels.max() > 0


@pytest.mark.parametrize("array, size", [
    (np.zeros((2, 2)), 1), (np.zeros((2, 2, 2)), 0), (np.zeros((2, 2, 2)), (1, 2)), (np.zeros((2, 2, 2)), float("nan")),
    (np.full((2, 2, 2), np.nan), 1), (np.zeros((0, 2, 2)), 1), (np.zeros((2, 2, 2), complex), 1),
])
def test_wrong_arrays(array, size):
    with pytest.raises(t.Error):
        t.volume(array, size)


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
    again = t.volume(list(grids.values()))
    assert set(again.grids) == set(volume.grids) and np.array_equal(again.dense("density"), volume.dense("density"))
    assert again.resolution == (0, 0, 0)  # grids alone do not say that they tile

    ball = vdb.createLevelSetSphere(radius=4.0, voxelSize=0.5)
    ball.name = "surface"
    v = t.volume(ball)
    assert v.grids == ["surface"] and v.voxel_size == 0.5
    dense = np.zeros(v.dense("surface").shape, np.float32)
    ball.copyToArray(dense, ijk=v.origin("surface"))
    assert np.array_equal(dense, v.dense("surface"))
