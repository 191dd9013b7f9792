"""Masks: twelve squares, stored in the ways of other programs."""

import numpy as np
import pytest

from foreign.pictures import png, saved, tiff
from foreign.sample import Sample, partition, read_labels

SQUARES = np.zeros((60, 80), np.uint8)
for number in range(12):
    row, column = 5 + 18 * (number // 4), 5 + 18 * (number % 4)
    SQUARES[row:row + 10, column:column + 10] = number + 1
MASK = SQUARES > 0
ALL = {"ids": partition(SQUARES), "classes": [0] * 12}
ONE = {"ids": MASK.astype(int), "classes": [0]}
GRAY = np.where(MASK, 255, 0).astype(np.uint8)
COLORS = np.arange(39, dtype=np.uint8).reshape(13, 3) * 6
COLORS[0] = 0
REPEATED = bytes([0, 0, 0] + [10, 20, 30] * 12 + [255] * 729)  # as a palette


def palette(**options):
    def write(path):
        image = pytest.importorskip("PIL.Image").fromarray(SQUARES, "P")
        image.putpalette(REPEATED)
        image.save(path, **options)
    return write


def smoothed(path):
    image = pytest.importorskip("PIL.Image")
    image.fromarray(GRAY).resize((120, 90), image.BICUBIC).save(path)


def sample(name, content, right, **parameters):
    return Sample("labels", name, content, right, read_labels, {"pixel_size": 1, **parameters})


def numbers(factor, dtype, **options):
    return tiff((SQUARES.astype(np.uint64) * factor).astype(dtype), photometric="minisblack", **options)


FOUR_BITS = (SQUARES[:, ::2] << 4) | SQUARES[:, 1::2]
BEYOND = tiff(np.where(MASK, SQUARES + np.uint64(2**53), np.uint64(0)), photometric="minisblack")
NEGATIVE = tiff(np.where(MASK, SQUARES, -1).astype(np.int16), photometric="minisblack")
TURNED = tiff(SQUARES, photometric="minisblack", extratags=[(274, 3, 1, 3, True)])
CLASSES = {"kind": "classes"}

SAMPLES = [
    sample("one_bit.png", saved(MASK), ONE),
    sample("one_bit.tif", tiff(MASK, photometric="minisblack"), ONE),
    sample("one_bit_white.tif", tiff(MASK, photometric="miniswhite"), ONE),
    sample("palette.png", palette(), ALL),
    sample("palette_4_bits.png", palette(bits=4), ALL),
    sample("palette.bmp", palette(), ALL),
    sample("palette.gif", palette(), ALL),
    sample("palette.tif", palette(), ALL),
    sample("gray_4_bits.png", png(FOUR_BITS, 4, 0), ALL),
    sample("uint16.png", png((SQUARES * 1000).astype(">u2").view(np.uint8).reshape(60, 160), 16, 0), ALL),
    sample("uint32.tif", numbers(2**24 + 3, np.uint32), ALL),
    sample("int64.tif", numbers(1000, np.int64), ALL),
    sample("uint64.tif", numbers(1, np.uint64), ALL),
    sample("float32.tif", numbers(1, np.float32), ALL),
    sample("float64.tif", numbers(2**24 + 3, np.float64), ALL),
    sample("bigtiff_tiles.tif", numbers(1, np.uint16, bigtiff=True, tile=(16, 16)), ALL),
    sample("predictor.tif", numbers(1, np.uint16, compression="zlib", predictor=True), ALL),
    sample("white_is_zero.tif", tiff(SQUARES, photometric="miniswhite"), ALL),
    sample("turned.tif", TURNED, {"ids": partition(SQUARES[::-1, ::-1])}),
    sample("colors.png", saved(COLORS[SQUARES]), {"classes": list(range(12))}, **CLASSES),
    sample("colors.tif", tiff(COLORS[SQUARES], photometric="rgb"), {"classes": list(range(12))}, **CLASSES),
    sample("mask.png", saved(GRAY), {"ids": partition(SQUARES)}, **CLASSES),
    sample("beyond.tif", BEYOND, "bad-values"),
    sample("negative.tif", NEGATIVE, "bad-labels"),
    sample("half.tif", tiff(SQUARES / np.float32(2), photometric="minisblack"), "bad-labels"),
    sample("lossy.jpg", saved(GRAY, quality=90), "lossy-mask"),
    sample("smoothed.png", smoothed, "blurred-mask"),
    sample("pages.tif", tiff(np.stack([SQUARES] * 3), photometric="minisblack"), "several-pages"),
]
