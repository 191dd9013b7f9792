"""Files from public bug reports, which lie beside the checkout, with the right answer for each."""

import dataclasses
import functools
from typing import Callable, Union

import numpy as np
import pytest

import terrazzo as t
from foreign.sample import (output, read_areas, read_labels, read_map, read_mesh, read_picture,
                            read_volume)


@dataclasses.dataclass(frozen=True)
class Report:
    name: str
    what: str  # for the table
    read: Callable[..., dict]
    right: Union[dict, str, Callable[..., dict]]  # as in Sample; a function reads the file in another way
    parameters: dict = dataclasses.field(default_factory=dict)
    tolerance: float = 1e-6


def grain_sizes(path):
    grains = read_map(path)["grains"]
    return {"sizes": np.bincount(grains.ravel())[1:]}


def slices(path, **parameters):
    """The commonest value of each slice along z."""
    voxels = read_volume(path, **parameters)["voxels"]
    commonest = [np.unique(voxels[:, :, z], return_counts=True) for z in range(voxels.shape[2])]
    return {"slices": [values[counts.argmax()] for values, counts in commonest]}


def solid_fraction(path):
    graph = t.Graph(cache=False)
    table = graph.Measure3D(volume=graph.LoadVolume(path=path)).table.value()
    return {"fraction": dict((row[0], row[1]) for row in table.rows)["volume fraction, voxels"]}


def profile_counts(path, **parameters):
    found = read_labels(path, **parameters)
    return {"profiles": found["ids"].max(), "classes": sorted(set(found["classes"]))}


def with_classes(path):
    return profile_counts(path.with_name("plain.png"), classes=path)


def corner_and_center(path):
    pixels = read_picture(path)["srgb"]
    return {"corner": pixels[0, 0], "center": pixels[pixels.shape[0] // 2, pixels.shape[1] // 2]}


def picture_size(path, **parameters):
    return {"size": read_picture(path, **parameters)["srgb"].shape[:2]}


def second_channel(path):
    series = pytest.importorskip("tifffile").TiffFile(path).series[0]
    pages = np.take(series.asarray(), 1, series.axes.index("C"))
    return {"voxels": np.transpose(pages, (2, 1, 0))[:, ::-1]}


def third_page(path):
    page = pytest.importorskip("tifffile").imread(path, key=2)
    return {"srgb": np.repeat(page[..., None], 3, axis=2) if page.ndim == 2 else page}


def half_floats(path):
    return {"voxels": np.load(path)}


def tail_of_nrrd(path):
    return {"voxels": np.frombuffer(path.read_bytes()[-6400:], "<u2").reshape(10, 16, 20).T}


def arrays_of_dream3d(path):
    file = pytest.importorskip("h5py").File(path)
    return {"voxels": file["DataContainers/Img/CellData/Conf"][..., 0].T, "grid": "Conf"}


def lines_of_table(path, column=0, factor=1.0, encoding="utf-8"):
    rows = [line.split(",") for line in path.read_text(encoding).split("\n")[1:] if line]
    return {"mm2": [float(row[column]) * factor for row in rows[:400]]}


def distribution(path):
    return {"total": output("LoadDistribution", "distribution", path=path).N_V.sum()}


def shapes(path):
    return {"shapes": len(output("LoadShapes", "shapes", path=path))}


RAMP = np.fromfunction(lambda x, y, z: x + 10 * y + 100 * z, (4, 3, 2))
FOUR = {"sizes": [48, 144, 48, 144]}
CUBE = {"volumes": [1000]}
TWELVE = {"profiles": 12, "classes": [0]}
ONE_MM = {"spacing": 1}
CHANNEL_2 = {"spacing": 1, "channel": 2}
TENS = {"slices": np.arange(0, 100, 10)}

REPORTS = [
    Report("oim8_header.ang", "OIM 8 map with notes in its header", grain_sizes, FOUR),
    Report("column_major.ang", "map stored column by column", grain_sizes, FOUR),
    Report("column_major.ctf", "map stored column by column", grain_sizes, FOUR),
    Report("enh_descending.dcm", "enhanced CT with descending slices", slices,
           {"slices": np.arange(-1000, -899, 20)}),
    Report("enh_gap.dcm", "enhanced CT without some of its slices", slices, "missing-slices"),
    Report("unpadded_slices/*", "slices slice_1 to slice_12", slices, {"slices": np.arange(1, 13)}, ONE_MM),
    Report("ij_2channels.tif", "ImageJ hyperstack of 2 channels", slices, "several-channels", ONE_MM),
    Report("ij_2channels.tif", "the same with `channel: 2`", read_volume, second_channel, CHANNEL_2),
    Report("ome_2channels.ome.tif", "OME-TIFF of 2 channels", slices, "several-channels", ONE_MM),
    Report("ome_2channels.ome.tif", "the same with `channel: 2`", read_volume, second_channel, CHANNEL_2),
    Report("miniswhite8.tif", "stack with WhiteIsZero", slices, TENS, ONE_MM),
    Report("separate_header.vti", "VTK image data whose header is encoded by itself", read_volume,
           {"voxels": RAMP}),
    Report("d3d_latest.dream3d", "DREAM3D file in the newest form of HDF5", read_volume,
           arrays_of_dream3d),
    Report("f16.npy", "NumPy array of half floats", read_volume, half_floats, ONE_MM),
    Report("a.nrrd", "NRRD volume", read_volume, tail_of_nrrd),
    Report("levelset.vdb", "OpenVDB level set of a sphere", solid_fraction, {"fraction": 0.268},
           tolerance=0.005),
    Report("binary_miniswhite.tif", "mask with WhiteIsZero", profile_counts, TWELVE, {"kind": "classes"}),
    Report("classes_voc_palette.png", "classes in a palette, for instances in plain.png", with_classes,
           {"profiles": 12, "classes": [0, 1, 2]}),
    Report("ids_palette_repeats.png", "ids whose palette repeats a color", profile_counts, TWELVE),
    Report("mask_jpeg.jpg", "mask stored as JPEG", profile_counts, "lossy-mask"),
    Report("adobergb.jpg", "photograph in Adobe RGB", corner_and_center,
           {"corner": (0, 35, 225), "center": (224, 121, 53)}, tolerance=2),
    Report("photo.dng", "raw photograph with a thumbnail", picture_size, "unreadable-image"),
    Report("pages.tif", "TIFF file of 5 pages", picture_size, "several-pages"),
    Report("pages.tif", "the same with `page: 3`", read_picture, third_page, {"page": 3}, 0.1),
    Report("sem_strip.jpg", "micrograph with a caption, only loaded", picture_size, {"size": (720, 900)}),
    Report("Solid_unity.stl", "ASCII STL with other capitals", read_mesh, CUBE),
    Report("solid_binary_trailing.stl", "binary STL that begins with solid, and bytes behind it", read_mesh,
           CUBE),
    Report("tristrips.ply", "PLY with triangle strips", read_mesh, CUBE),
    Report("overlapping_bodies.stl", "two cubes that overlap", read_mesh, {"volumes": [1000, 1000]}),
    Report("utm_sphere_r0.3m.obj", "sphere in UTM coordinates", read_mesh, {"volumes": [0.1099]},
           tolerance=1e-5),
    Report("header_um2_one_column.csv", "areas in µm², one column", read_areas,
           functools.partial(lines_of_table, factor=1e-6)),
    Report("imagej_summarize.csv", "table of ImageJ with rows of statistics", read_areas,
           functools.partial(lines_of_table, column=1)),
    Report("utf16.csv", "table in UTF-16", read_areas, functools.partial(lines_of_table, encoding="utf-16")),
    Report("breccia_sizes.json", "sizes for packing, only loaded", distribution, {}),
    Report("breccia_shapes.json", "shapes for packing, only loaded", shapes, {}),
]
