"""Changes how pictures look at random, since photographs vary more than synthetic pictures do.

Every function takes pictures (n, 3, h, w) from 0 to 1 and a generator of the same device, and returns changed pictures.
"""
import functools
import math

import torch
from torch.nn import functional

# Quantization of brightness in JPEG files at quality 50 (ITU-T T.81, table K.1).
JPEG_TABLE = (
    (16, 11, 10, 16, 24, 40, 51, 61), (12, 12, 14, 19, 26, 58, 60, 55), (14, 13, 16, 24, 40, 57, 69, 56),
    (14, 17, 22, 29, 51, 87, 80, 62), (18, 22, 37, 56, 68, 109, 103, 77), (24, 35, 55, 64, 81, 104, 113, 92),
    (49, 64, 78, 87, 103, 121, 120, 101), (72, 92, 95, 98, 112, 100, 103, 99))


def change_looks(x, random, generator):
    """Steps of a camera in their order, each on a share of the pictures. `random` draws their number, `generator` the rest."""
    x = exposed(x, generator)
    for share, change in ((0.06, gray), (0.28, tinted), (0.3, recolored), (0.25, unevenly_lit), (0.1, enlarged), (0.1, enlarged),
                          (0.1, enlarged), (0.3, softened), (0.3, grainy), (0.3, compressed)):
        count = int(random.binomial(len(x), share))
        if count > 0:
            chosen = torch.randperm(len(x), generator=generator, device=x.device)[:count]
            x[chosen] = change(x[chosen], *((random, generator) if change in (enlarged, unevenly_lit) else (generator,))).clamp(0, 1)
    return x


def normal(x, generator, channels=1):
    return torch.randn((len(x), channels, 1, 1), generator=generator, device=x.device)


def uniform(x, generator, low=0.0, high=1.0):
    return low + (high - low) * torch.rand((len(x), 1, 1, 1), generator=generator, device=x.device)


def exposed(x, generator):
    return (0.5 + torch.exp(0.15 * normal(x, generator)) * (x - 0.5) + 0.05 * normal(x, generator)).clamp(0, 1)


def gray(x, _):
    return x.mean(1, keepdim=True).expand_as(x)


def tinted(x, generator):
    return x * torch.exp(0.12 * normal(x, generator, 3))


def recolored(x, generator):
    """Mixes the channels, then changes contrast, lightness and gamma."""
    mix = torch.eye(3, device=x.device) + 0.18 * torch.randn((len(x), 3, 3), generator=generator, device=x.device)
    mean = x.mean((2, 3), keepdim=True)
    shift = 0.08 * normal(x, generator) + 0.04 * normal(x, generator, 3)
    out = (mix @ (x - mean).flatten(2)).view_as(x) * torch.exp(0.3 * normal(x, generator)) + mean + shift
    return out.clamp(1e-3, 1) ** torch.exp(0.25 * normal(x, generator))


def unevenly_lit(x, random, generator):
    """Light that changes slowly across the picture, as under trees or near a flash."""
    cells = int(random.integers(2, 6))
    field = torch.randn((len(x), 1, cells, cells), generator=generator, device=x.device)
    field = functional.interpolate(field, size=x.shape[-2:], mode="bicubic", align_corners=True)
    return x * torch.exp(uniform(x, generator, 0.05, 0.35) * field)


def enlarged(x, random, generator):
    """Reduces the pictures to 0.35 to 0.9 of their resolution and enlarges them again, as cameras and programs do."""
    size = max(16, round(x.shape[-1] * math.exp(random.uniform(math.log(0.35), math.log(0.9)))))
    mode = {"mode": "area"} if random.random() < 0.6 else {"mode": "bilinear", "align_corners": False}
    small = functional.interpolate(x, size=(size, size), **mode)
    if random.random() < 0.5:
        small = small + uniform(x, generator, 0, 0.02) * torch.randn(small.shape, generator=generator, device=x.device)
    out = functional.interpolate(small, size=x.shape[-2:], mode="bicubic", align_corners=False)
    return out + uniform(x, generator, 0, 1.2) * (out - blurred(out)) if random.random() < 0.4 else out


def blurred(x):
    """The mean of 3 × 3 pixels with the weights 1, 2, 1 of each row and column."""
    p = functional.pad(x, (1, 1, 1, 1), mode="reflect")
    p = (p[..., :-2] + 2 * p[..., 1:-1] + p[..., 2:]) / 4
    return (p[..., :-2, :] + 2 * p[..., 1:-1, :] + p[..., 2:, :]) / 4


def softened(x, generator):
    """From blurred twice to sharpened."""
    once = blurred(x)
    share = uniform(x, generator, -1, 1)
    return torch.where(share > 0, x + share * (blurred(once) - x), x - share * (x - once))


def grainy(x, generator):
    """Noise of single pixels and of coarser grain, the same or not in the three channels."""
    fine = torch.randn(x.shape, generator=generator, device=x.device)
    shared = fine.mean(1, keepdim=True) * 3 ** 0.5
    fine = torch.where(uniform(x, generator) < 0.5, shared.expand_as(x), fine)
    coarse = torch.randn((*x.shape[:2], x.shape[2] // 2, x.shape[3] // 2), generator=generator, device=x.device)
    coarse = functional.interpolate(coarse, size=x.shape[-2:], mode="bilinear", align_corners=False)
    return x + uniform(x, generator, 0, 0.05) * fine + uniform(x, generator, 0, 0.03) * coarse


def compressed(x, generator):
    """What a JPEG file of quality 20 to 90 keeps. Color has half of the resolution. Sides must be multiples of 16."""
    red, green, blue = x.unbind(1)
    light = 0.299 * red + 0.587 * green + 0.114 * blue
    quality = uniform(x, generator, 20, 90)
    factor = torch.where(quality < 50, 50 / quality, 2 - quality / 50)
    light = quantized(light[:, None], factor)
    color = functional.avg_pool2d(torch.stack(((blue - light[:, 0]) * 0.564, (red - light[:, 0]) * 0.713), 1), 2)
    color = functional.interpolate(quantized(color, factor), scale_factor=2, mode="bilinear", align_corners=False)
    bluish, reddish = color[:, :1], color[:, 1:]
    return torch.cat((light + 1.403 * reddish, light - 0.344 * bluish - 0.714 * reddish, light + 1.773 * bluish), 1)


@functools.lru_cache(maxsize=None)
def jpeg_constants(device):
    """The cosine transform of 8 values, whose inverse is its transpose, and the table. Kept, because a copy to the GPU waits for it."""
    k = torch.arange(8, dtype=torch.float32)
    wave = torch.cos(math.pi / 8 * (k[None, :] + 0.5) * k[:, None]) / 2
    wave[0] /= 2 ** 0.5
    return wave.to(device), (torch.tensor(JPEG_TABLE) / 255.0).to(device)


def quantized(x, factor):
    """Rounds the cosine coefficients of blocks of 8 × 8 pixels."""
    n, channels, height, width = x.shape
    wave, table = jpeg_constants(x.device)
    table = table * factor[..., None, None]
    blocks = x.reshape(n, channels, height // 8, 8, width // 8, 8).transpose(3, 4)
    coefficients = torch.round(wave @ blocks @ wave.T / table) * table
    return (wave.T @ coefficients @ wave).transpose(3, 4).reshape(n, channels, height, width)
