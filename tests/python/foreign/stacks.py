"""Stacks of pictures: TIFF files of ImageJ, OME and tifffile, and folders of slices."""

import struct

import numpy as np
import pytest

from foreign.sample import Sample, read_volume

# Ten pages of 6 rows and 7 columns, different in each pixel.
PAGES = np.fromfunction(lambda page, row, column: column + 7 * row + 42 * page, (10, 6, 7))


def voxels(pages):
    """x goes to the right, y up, z through the pages."""
    return {"voxels": np.transpose(pages, (2, 1, 0))[:, ::-1]}


def tiff(pages, dtype=np.uint16, **options):
    def write(path):
        tifffile = pytest.importorskip("tifffile")
        tifffile.imwrite(path, np.asarray(pages).astype(dtype), **options)
    return write


def one_directory(path):
    """A stack of ImageJ beyond 4 GB has one directory; the other pages follow its pixels."""
    text = b"ImageJ=1.53t\nimages=10\nslices=10\nloop=false\n\0"
    text += bytes(len(text) % 2)
    pixels = PAGES.astype(">u2").tobytes()
    entries = [(256, 3, 1, 7), (257, 3, 1, 6), (258, 3, 1, 16), (259, 3, 1, 1), (262, 3, 1, 1),
               (270, 2, len(text), 134), (273, 4, 1, 134 + len(text)), (277, 3, 1, 1), (278, 3, 1, 6),
               (279, 4, 1, 84)]
    directory = struct.pack(">H", len(entries))
    for tag, kind, count, value in entries:
        number = struct.pack(">HH", value, 0) if kind == 3 else struct.pack(">I", value)
        directory += struct.pack(">HHI", tag, kind, count) + number
    path.write_bytes(struct.pack(">2sHI", b"MM", 42, 8) + directory + bytes(4) + text + pixels)


def slices(path):
    image = pytest.importorskip("PIL.Image")
    for k, page in enumerate(PAGES.astype(np.uint16) // 2):
        image.fromarray(page.astype(np.uint8)).save(path.with_name(f"slice_{k + 1}.png"))


def sample(name, content, right, **parameters):
    return Sample("picture stack", name, content, right, read_volume, {"spacing": 1, **parameters})


HYPER = PAGES.reshape(5, 2, 6, 7)
GRAY = {"photometric": "minisblack"}
IMAGEJ = tiff(HYPER, imagej=True, metadata={"axes": "ZCYX"})
OME = tiff(HYPER, metadata={"axes": "ZCYX"})
TIMES = tiff(PAGES.reshape(2, 5, 6, 7), metadata={"axes": "TZYX"})
TILED = np.fromfunction(lambda page, row, column: column + 40 * row + 1200 * page, (3, 30, 40))

SAMPLES = [
    sample("slices.tif", tiff(PAGES, imagej=True, metadata={"axes": "ZYX"}), voxels(PAGES)),
    sample("one_directory.tif", one_directory, voxels(PAGES)),
    sample("channels.tif", tiff(PAGES, imagej=True, metadata={"axes": "CYX"}), "several-channels"),
    sample("hyperstack.tif", IMAGEJ, "several-channels"),
    sample("hyperstack_1.tif", IMAGEJ, voxels(HYPER[:, 0]), channel=1),
    sample("hyperstack_2.tif", IMAGEJ, voxels(HYPER[:, 1]), channel=2),
    sample("channels.ome.tif", OME, "several-channels"),
    sample("channels_2.ome.tif", OME, voxels(HYPER[:, 1]), channel=2),
    sample("times.ome.tif", TIMES, "several-pages"),
    sample("times_2.ome.tif", TIMES, voxels(PAGES[5:]), page=2),
    sample("white_is_zero.tif", tiff(PAGES, photometric="miniswhite"), voxels(PAGES)),
    sample("bigtiff.tif", tiff(PAGES, bigtiff=True, **GRAY), voxels(PAGES)),
    sample("big_endian.tif", tiff(PAGES, byteorder=">", **GRAY), voxels(PAGES)),
    sample("float32.tif", tiff(PAGES / 3, np.float32, **GRAY), voxels(PAGES / 3)),
    sample("float64.tif", tiff(PAGES / 3, np.float64, **GRAY), voxels(PAGES / 3)),
    sample("float16.tif", tiff(PAGES, np.float16, **GRAY), voxels(PAGES)),
    sample("signed.tif", tiff(PAGES - 200, np.int16, **GRAY), voxels(PAGES - 200)),
    sample("tiles.tif", tiff(TILED, tile=(16, 16), **GRAY), voxels(TILED)),
    sample("tiles_predictor.tif", tiff(TILED, tile=(16, 16), compression="zlib", predictor=True, **GRAY),
           voxels(TILED)),
    sample("strips.tif", tiff(TILED, rowsperstrip=7, compression="zlib", **GRAY), voxels(TILED)),
    sample("planes.tif", tiff(PAGES[:3], photometric="rgb", planarconfig="separate"), "not-a-volume"),
    sample("plane_2.tif", tiff(PAGES[:3], photometric="rgb", planarconfig="separate"), voxels(PAGES[1:2]),
           channel=2),
    sample("slice_*.png", slices, voxels(PAGES // 2)),
]
