"""Values from and for scikit-image and pandas."""

import numpy as np
import pytest

import terrazzo as t


def test_labels_of_scikit_image(section):
    color, filters, measure = (pytest.importorskip(f"skimage.{name}") for name in ("color", "filters", "measure"))
    g = t.Graph()
    photo = g.LoadImage(path=section, pixel_size=0.1)
    lightness = color.rgb2lab(photo.image.value().pixels ** (1 / 2.2))[..., 0]
    bright = lightness > filters.threshold_otsu(lightness)
    if bright[[0, -1]].mean() > 0.5:  # particles are the smaller part
        bright = ~bright
    found = measure.label(filters.median(bright))
    profiles = g.Segment(image=photo.image, labels=t.labels(found, 0.1)).profiles
    # The same areas as scikit-image measures, in mm².
    areas = np.sort([p.area for p in measure.regionprops(found)]) * 0.1**2
    assert len(profiles.value()) == found.max() and np.allclose(np.sort(profiles.value().area), areas, rtol=0.3, atol=0.1)
    spheres = g.KMatrix(shapes=g.Shape(kind="sphere").shapes, method="analytic")
    sizes = g.Unfold(profiles=profiles, kmatrix=spheres.kmatrix).distribution.value()
    assert sizes.N_V.sum() > 0 and np.isfinite(sizes.N_V).all()
    # Other types of whole numbers are labels too.
    assert t.labels(found.astype(np.uint8)).count == len(np.unique(found.astype(np.uint8))) - 1


def test_tables_for_pandas():
    pandas = pytest.importorskip("pandas")
    frame = t.table({"size": [1, 2.5], "name": ["a", "b"]}).to_pandas()
    assert list(frame.columns) == ["size", "name"] and frame["size"].dtype == float
    assert t.table(dict(frame)) == t.table({"size": [1, 2.5], "name": ["a", "b"]})
    # Columns are arrays too, with gaps between their elements.
    image = t.image(pandas.DataFrame(np.random.default_rng(1).random((4, 6))).iloc[::2])
    assert image.height == 2
