"""PNG files of pictures, for notebooks. Files on disk are written by the Export node."""

import struct
import zlib

import numpy as np


def _chunk(kind, data):
    body = kind + data
    return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))


def encode(pixels):
    """The bytes of a PNG file of uint8 (height, width, 3)."""
    height, width = pixels.shape[:2]
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each row starts with the number of its filter: none
    rows[:, 1:] = pixels.reshape(height, -1)
    return (b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)) +
            _chunk(b"sRGB", b"\0") + _chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + _chunk(b"IEND", b""))


def srgb(linear):
    """Scene-linear colors as uint8, encoded as sRGB (IEC 61966-2-1)."""
    v = np.clip(linear, 0, 1)
    v = np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)
    return np.round(255 * v).astype(np.uint8)


def _tiled(stack, width):
    """The sections of a stack side by side, in one picture of at most this width."""
    if stack.shape[0] == 1:
        return stack[0]
    columns = max(1, min(stack.shape[0], width // max(1, stack.shape[2])))
    lines = []
    for start in range(0, stack.shape[0], columns):
        line = list(stack[start:start + columns])
        line += [np.zeros_like(line[0])] * (columns - len(line))
        lines.append(np.concatenate(line, axis=1))
    return np.concatenate(lines, axis=0)


_largest = 2048  # pixels of an edge of the pictures in notebooks


def _shown(stack):
    step = max(1, -(-max(stack.shape[1:3]) // _largest))
    return _tiled(stack[:16, ::step, ::step], _largest)


def image_png(image):
    pixels = image.pixels
    return encode(srgb(_shown(pixels if pixels.ndim == 4 else pixels[None])))


def volume_png(volume):
    """The middle plane along z, with x to the right and y up: colors, or the first grid from its least value (black) to
    its largest (white)."""
    name = "Cd" if "Cd" in volume.grids else next(iter(volume.grids), None)
    plane = None if name is None else volume._plane(name)
    if plane is None or not plane.size:
        return None
    pixels = plane[:, :, 0].swapaxes(0, 1)[::-1]
    if name != "Cd":
        pixels = pixels.astype(float)
        least, span = pixels.min(), np.ptp(pixels)
        pixels = (pixels - least) / span if span > 0 else np.zeros_like(pixels)
    if pixels.ndim == 2:
        pixels = np.repeat(pixels[..., None], 3, axis=-1)
    return encode(srgb(_shown(pixels[None])))


def labels_png(labels):
    """Each profile in a color of its own; the binder is black."""
    ids = labels.ids
    ids = _shown(ids if ids.ndim == 3 else ids[None]).astype(np.uint32)
    mixed = ids * np.uint32(2654435761)  # Knuth's multiplicative hash
    colors = np.stack([(mixed >> shift & 0xFF) for shift in (24, 16, 8)], axis=-1)
    return encode(np.where(ids[..., None] > 0, 64 + colors * 191 // 255, 0).astype(np.uint8))
