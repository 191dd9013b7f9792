"""Changes how pictures look at random, since photographs vary more than synthetic pictures do."""
import numpy as np
import torch
from torch.nn import functional


def change_looks(x, random):
    """x: pictures (n, 3, h, w) from 0 to 1, changed in place. Colors of three pictures in ten are mixed, three in ten lose detail."""
    for i in range(len(x)):
        if random.random() < 0.3:
            x[i] = recolored(x[i], random)
        if random.random() < 0.3:
            x[i] = enlarged(x[i], random)
    return x


def recolored(picture, random):
    """Mixes the channels, then changes contrast, lightness and gamma."""
    mix = torch.eye(3) + torch.from_numpy((0.18 * random.standard_normal((3, 3))).astype(np.float32))
    mean = picture.mean((1, 2), keepdim=True)
    shift = 0.08 * random.standard_normal() + torch.from_numpy((0.04 * random.standard_normal((3, 1, 1))).astype(np.float32))
    out = torch.einsum("ij,jhw->ihw", mix, picture - mean) * float(np.exp(0.3 * random.standard_normal())) + mean + shift
    return out.clamp(1e-3, 1) ** float(np.exp(0.25 * random.standard_normal()))


def enlarged(picture, random):
    """Reduces the picture to 0.35 to 0.9 of its resolution and enlarges it again, as cameras and programs do; sometimes with
    noise before and sharpening afterwards."""
    size = max(16, round(picture.shape[-1] * float(np.exp(random.uniform(np.log(0.35), np.log(0.9))))))
    mode = {"mode": "area"} if random.random() < 0.6 else {"mode": "bilinear", "align_corners": False}
    small = functional.interpolate(picture[None], size=(size, size), **mode)
    if random.random() < 0.5:
        small = small + torch.from_numpy((0.02 * random.random() * random.standard_normal(small.shape)).astype(np.float32))
    out = functional.interpolate(small, size=picture.shape[-2:], mode="bicubic", align_corners=False)
    if random.random() < 0.4:
        blurred = functional.avg_pool2d(functional.pad(out, (1, 1, 1, 1), mode="reflect"), 3, 1)
        out = out + float(random.uniform(0.2, 1.5)) * (out - blurred)
    return out[0].clamp(0, 1)
