"""Reads the pictures that pictures.yaml makes, or their bundle, and cuts crops from them at random."""
import concurrent.futures
import math
import pathlib

import cv2
import numpy as np
import torch
from torch.nn import functional

SIDE = 256  # of the pictures of SyntheticPhoto; larger ones are cut into parts, smaller ones mirrored


class Pictures:
    """All pictures of the folders, in the memory of the device: `planes` (n, 8, 256, 256), from 0 to 255. The planes are red,
    green, blue, inside, inner border, relative distance, what is not material, and where the labels are to be trusted."""

    def __init__(self, folders, device="cpu"):
        paths = [path for folder in folders for path in sorted(pathlib.Path(folder).glob("image_*.*"))]
        if not paths:
            raise SystemExit("train: there are no pictures")
        with concurrent.futures.ThreadPoolExecutor(16) as pool:
            parts = [part for parts in pool.map(parts_of, paths) for part in parts]
        self.planes = torch.from_numpy(np.stack(parts)).to(device)

    def __len__(self):
        return len(self.planes)

    def whole(self, indices):
        """Colors (n, 3, 256, 256) from 0 to 1, targets and weights (n, 5, 256, 256)."""
        planes = self.planes[indices].float() / 255
        return planes[:, :3], planes[:, 3:]

    def crops(self, generator, count, size):
        """Crops of size × size pixels at random places, as `whole`: scaled, turned, mirrored and stretched a little."""
        device = self.planes.device

        def uniform(low, high):
            return low + (high - low) * torch.rand(count, generator=generator, device=device)

        color, targets = self.whole(torch.randint(len(self), (count,), generator=generator, device=device))
        scale = torch.exp(uniform(math.log(0.75), math.log(1.6)))
        stretch = torch.exp(uniform(-0.07, 0.07))
        # Most photographs are lit from above; that tells a stone from the hole that another one left.
        turns = (uniform(0, 1) < 0.35) * torch.floor(uniform(0, 4))
        angle = math.pi / 2 * turns + uniform(-0.17, 0.17) * (uniform(0, 1) < 0.5)
        mirror = 1 - 2 * (uniform(0, 1) < 0.5).float()
        half = size / SIDE / scale  # of the window's side, where the picture reaches from -1 to 1
        room = (1 - half).clamp(min=0)
        cosine, sine = torch.cos(angle), torch.sin(angle)
        rows = [half * mirror * cosine * stretch, -half * sine * stretch, room * uniform(-1, 1),
                half * mirror * sine / stretch, half * cosine / stretch, room * uniform(-1, 1)]
        grid = functional.affine_grid(torch.stack(rows, 1).view(count, 2, 3), (count, 1, size, size), align_corners=False)
        color = functional.grid_sample(color, grid, mode="bicubic", padding_mode="reflection", align_corners=False)
        targets = functional.grid_sample(targets, grid, mode="bilinear", padding_mode="reflection", align_corners=False)
        return color.clamp(0, 1), targets


def truth_of(path):
    """Labels, what is not material and what is unclear in the picture at `path`. A bundle has them in one file: 4 × label +
    2 × not material + unclear."""
    number = path.stem[len("image_"):]

    def read(kind):
        file = path.with_name(f"{kind}_{number}.png")
        return cv2.imread(str(file), cv2.IMREAD_UNCHANGED) if file.exists() else None

    truth = read("truth")
    if truth is not None:
        return (truth >> 2).astype(np.int32), truth & 2, truth & 1
    labels, other, unclear = read("labels"), read("not_material"), read("unclear")
    if labels is None or other is None:
        raise SystemExit(f"train: {path}: its labels or not_material cannot be read")
    return labels.astype(np.int32), other, np.zeros(labels.shape, np.uint8) if unclear is None else unclear


def planes_of(path):
    color = cv2.imread(str(path))
    if color is None:
        raise SystemExit(f"train: {path}: the picture cannot be read")
    labels, other, unclear = truth_of(path)
    border, distance = targets(labels)
    planes = [color[:, :, 2], color[:, :, 1], color[:, :, 0], 255 * (labels > 0), 255 * border, distance, 255 * (other > 0),
              255 * (unclear == 0)]
    return np.stack([p.astype(np.uint8) for p in planes])


def parts_of(path):
    """The planes of a picture, in parts of 256 × 256 pixels that overlap where they must."""
    planes = planes_of(path)
    height, width = planes.shape[1:]
    below, right = max(0, SIDE - height), max(0, SIDE - width)
    if below or right:
        planes = np.pad(planes, ((0, 0), (0, below), (0, right)), mode="symmetric")
    starts = [np.linspace(0, side - SIDE, -(-side // SIDE)).astype(int) for side in planes.shape[1:]]
    return [planes[:, y:y + SIDE, x:x + SIDE] for y in starts[0] for x in starts[1]]


def targets(labels):
    """Inner border (0 or 1) and distance to it (0 to 255 at the deepest pixel of the particle)."""
    edge = np.zeros(labels.shape, bool)
    right, below = labels[:, 1:] != labels[:, :-1], labels[1:] != labels[:-1]
    edge[:, 1:] |= right
    edge[:, :-1] |= right
    edge[1:] |= below
    edge[:-1] |= below
    edge &= labels > 0
    # Any way to another particle crosses this particle's own border first, so one transform serves all.
    open_pixels = ((labels > 0) & ~edge).astype(np.uint8)
    distance = cv2.distanceTransform(open_pixels, cv2.DIST_L2, 5) + edge * np.float32(0.5)
    order = np.argsort(labels, axis=None, kind="stable")
    sorted_labels = labels.ravel()[order]
    first = np.flatnonzero(np.diff(sorted_labels, prepend=-1))
    deepest = np.zeros(int(sorted_labels[-1]) + 1, np.float32)
    deepest[sorted_labels[first]] = np.maximum.reduceat(distance.ravel()[order], first)
    relative = distance / np.maximum(deepest[labels], 1e-6) * (labels > 0)
    return edge.astype(np.uint8), np.round(255 * relative).astype(np.uint8)
