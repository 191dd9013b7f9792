"""Pictures with color profiles, gamma, palettes and other kinds of pixels."""

import struct
import zlib

import numpy as np
import pytest

from foreign.sample import Sample, read_picture

COLOR = (120, 100, 60)
FLAT = np.full((32, 32, 3), COLOR, np.uint8)


def fixed(*numbers):
    return b"".join(struct.pack(">i", round(number * 65536)) for number in numbers)


def profile(space, tags):
    """An ICC profile of version 2, from its specification."""
    tags = [(b"desc", b"desc" + bytes(4) + struct.pack(">I", 2) + b"x" + bytes(80)),
            (b"cprt", b"text" + bytes(4) + b"x\0"),
            (b"wtpt", b"XYZ " + bytes(4) + fixed(0.9642, 1, 0.8249)), *tags]
    table, body = struct.pack(">I", len(tags)), b""
    for name, data in tags:
        table += name + struct.pack(">II", 132 + 12 * len(tags) + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    head = struct.pack(">I4xI4s4s4s6H4s28x", 128 + len(table + body), 0x02400000, b"mntr", space, b"XYZ ",
                       2020, 1, 1, 0, 0, 0, b"acsp") + fixed(0.9642, 1, 0.8249)
    return head.ljust(128, b"\0") + table + body


def rgb_profile(primaries, gamma):
    curve = b"curv" + bytes(4) + struct.pack(">IH", 1, round(gamma * 256)) + bytes(2)
    names = (b"r", b"g", b"b")
    tags = [(name + b"XYZ", b"XYZ " + bytes(4) + fixed(*xyz)) for name, xyz in zip(names, primaries)]
    return profile(b"RGB ", tags + [(name + b"TRC", curve) for name in names])


ADOBE = [(0.60974, 0.31111, 0.01947), (0.20528, 0.62567, 0.06087), (0.14919, 0.06322, 0.74457)], 563 / 256
PROPHOTO = [(0.79767, 0.28804, 0), (0.13519, 0.71188, 0), (0.03134, 0.00008, 0.8249)], 461 / 256
LINEAR_GRAY = profile(b"GRAY", [(b"kTRC", b"curv" + bytes(4) + struct.pack(">IH", 1, 256) + bytes(2))])


def srgb(linear):
    linear = np.asarray(linear, float)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def converted(primaries, gamma):
    """By the matrices of the two spaces, both for the white of profiles."""
    from_srgb = [(0.43607, 0.38515, 0.14307), (0.22249, 0.71687, 0.06061), (0.01392, 0.09708, 0.7141)]
    return srgb(np.linalg.inv(from_srgb) @ np.transpose(primaries) @ (np.array(COLOR) / 255) ** gamma)


def saved(pixels, mode=None, **options):
    """Writes with Pillow, in the format that the name says."""
    def write(path):
        image = pytest.importorskip("PIL.Image")
        image.fromarray(pixels, mode).save(path, **options)
    return write


def png(pixels, bits=8, color=2, chunks=()):
    """With any chunks. Rows of pixels are bytes already."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    wide = len(pixels[0]) * 8 // (bits * {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[color])
    header = struct.pack(">IIBBBBB", wide, len(pixels), bits, color, 0, 0, 0)
    body = b"".join(chunk(name, data) for name, data in chunks)
    rows = zlib.compress(b"".join(b"\0" + bytes(row) for row in pixels))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + body + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def gamma(value):
    return [(b"gAMA", struct.pack(">I", round(value * 100000)))]


def turned(path):
    image = pytest.importorskip("PIL.Image").fromarray(HALVES)
    exif = image.getexif()
    exif[0x0112] = 6
    image.save(path, exif=exif, compress_level=1)


def cmyk(path):
    pytest.importorskip("PIL.Image").fromarray(FLAT).convert("CMYK").save(path)


def animation(path):
    image = pytest.importorskip("PIL.Image")
    frames = [image.fromarray(np.full((16, 16), 80 * k, np.uint8)) for k in range(3)]
    frames[0].save(path, save_all=True, append_images=frames[1:])


def tiff(pixels, **options):
    def write(path):
        pytest.importorskip("tifffile").imwrite(path, pixels, **options)
    return write


def sample(name, content, right, tolerance=0.5, **parameters):
    """Tolerance in levels of 8 bits."""
    if not isinstance(right, str):
        right = {"srgb": np.broadcast_to(right, (32, 32, 3)) if np.ndim(right) < 2 else right}
    return Sample("picture", name, content, right, read_picture, {"pixel_size": 1, **parameters}, tolerance)


HALVES = np.zeros((32, 48, 3), np.uint8)
HALVES[:, :24] = COLOR
GRADIENT = np.fromfunction(lambda y, x, c: 7 * x + 80 * c, (32, 32, 3)).astype(np.uint8)
SIXTEEN = GRADIENT.astype(np.uint16) * 257
SIXTEEN_BYTES = SIXTEEN.astype(">u2").view(np.uint8).reshape(32, 192)
PALETTE = np.array([COLOR, (200, 10, 90), (0, 0, 0), (255, 255, 255)], np.uint8)
INDICES = np.fromfunction(lambda y, x: (x + y) % 4, (32, 32)).astype(np.uint8)
PACKED = np.packbits(np.unpackbits(INDICES[..., None], axis=2)[..., 6:].reshape(32, 64), axis=1)
CLEAR = PALETTE.copy()
CLEAR[1] = 0  # transparent pixels are black
HALF_CLEAR = np.dstack([FLAT, np.full((32, 32), 255, np.uint8)])
HALF_CLEAR[:, 16:, 3] = 0
LINEAR = GRADIENT / np.float32(255)

SAMPLES = [
    sample("plain.png", saved(GRADIENT), GRADIENT),
    sample("adobe.png", saved(FLAT, icc_profile=rgb_profile(*ADOBE)), converted(*ADOBE), 1),
    sample("adobe.tif", saved(FLAT, icc_profile=rgb_profile(*ADOBE)), converted(*ADOBE), 1),
    sample("adobe.jpg", saved(FLAT, icc_profile=rgb_profile(*ADOBE), quality=98, subsampling=0),
           converted(*ADOBE), 3),
    sample("prophoto.png", saved(FLAT, icc_profile=rgb_profile(*PROPHOTO)), converted(*PROPHOTO), 1),
    sample("linear_gray.png", saved(FLAT[..., 0], icc_profile=LINEAR_GRAY), [srgb(120 / 255)] * 3),
    sample("gamma_1.png", png(FLAT.reshape(32, 96), chunks=gamma(1)), srgb(np.array(COLOR) / 255)),
    sample("gamma_22.png", png(FLAT.reshape(32, 96), chunks=gamma(0.45455)), COLOR, 1),
    sample("sixteen.png", png(SIXTEEN_BYTES, 16), GRADIENT),
    sample("sixteen_gamma_1.png", png(SIXTEEN_BYTES, 16, chunks=gamma(1)), srgb(GRADIENT / 255)),
    sample("palette.png", png(PACKED, 2, 3, [(b"PLTE", PALETTE.tobytes())]), PALETTE[INDICES]),
    sample("palette_clear.png", png(PACKED, 2, 3, [(b"PLTE", PALETTE.tobytes()), (b"tRNS", b"\xff\0")]),
           CLEAR[INDICES]),
    sample("alpha.png", saved(HALF_CLEAR), np.where(HALF_CLEAR[..., 3:], FLAT, 0)),
    sample("one_bit.png", saved(INDICES > 1), np.repeat((INDICES > 1)[..., None] * 255, 3, axis=2)),
    sample("turned.png", turned, np.rot90(HALVES, -1)),
    sample("plain.bmp", saved(GRADIENT), GRADIENT),
    sample("plain.ppm", saved(GRADIENT), GRADIENT),
    sample("palette.gif", saved(INDICES * 80), np.repeat(INDICES[..., None] * 80, 3, axis=2)),
    sample("planes.tif", tiff(np.moveaxis(GRADIENT, 2, 0), photometric="rgb", planarconfig="separate"),
           GRADIENT),
    sample("sixteen.tif", tiff(SIXTEEN, photometric="rgb", compression="zlib", predictor=True), GRADIENT),
    sample("float.tif", tiff(LINEAR, photometric="rgb"), srgb(LINEAR)),
    sample("white_is_zero.tif", tiff(255 - GRADIENT[..., 0], photometric="miniswhite"),
           np.repeat(GRADIENT[..., :1], 3, axis=2)),
    sample("cmyk.jpg", cmyk, "unsupported-image"),
    sample("animation.gif", animation, "several-pages"),
    sample("pages.tif", tiff(np.zeros((3, 16, 16), np.uint8), photometric="minisblack"), "several-pages"),
    sample("cut.png", png(FLAT.reshape(32, 96))[:-30], "unreadable-image"),
]
