"""Reads the pictures that pictures.yaml makes, and cuts crops from them at random."""
import pathlib

import cv2
import numpy as np


class Pictures:
    """All pictures of the folders, in memory: colors, inside, inner border, relative distance, what is not material, and
    where the labels are to be trusted."""

    def __init__(self, folders):
        self.color, self.inside, self.border, self.distance, self.other, self.clear = [], [], [], [], [], []
        for folder in folders:
            for path in sorted(pathlib.Path(folder).glob("image_*.png")):
                number = path.stem[len("image_"):]
                labels = cv2.imread(str(path.with_name(f"labels_{number}.png")), cv2.IMREAD_UNCHANGED)
                other = cv2.imread(str(path.with_name(f"not_material_{number}.png")), cv2.IMREAD_UNCHANGED)
                color = cv2.imread(str(path))
                if color is None or labels is None or other is None:
                    raise SystemExit(f"train: {path}: the picture or its labels cannot be read")
                self.color.append(np.ascontiguousarray(color[:, :, ::-1]))
                border, distance = targets(labels)
                self.inside.append((labels > 0).astype(np.uint8))
                self.border.append(border)
                self.distance.append(distance)
                self.other.append((other > 0).astype(np.uint8))
                unclear = cv2.imread(str(path.with_name(f"unclear_{number}.png")), cv2.IMREAD_UNCHANGED)
                self.clear.append(np.ones(labels.shape, np.uint8) if unclear is None else (unclear == 0).astype(np.uint8))
        if not self.color:
            raise SystemExit("train: there are no pictures")

    def __len__(self):
        return len(self.color)

    def crop(self, random, size):
        """A crop of size × size pixels: (color (size, size, 3) from 0 to 1, targets and weights (5, size, size))."""
        i = int(random.integers(len(self)))
        height, width = self.inside[i].shape
        scale = float(np.exp(random.uniform(np.log(0.75), np.log(1.6))))
        side = min(int(round(size / scale)), height, width)
        y, x = int(random.integers(height - side + 1)), int(random.integers(width - side + 1))
        window = (slice(y, y + side), slice(x, x + side))
        color = self.color[i][window].astype(np.float32) / 255
        planes = [self.inside[i][window], self.border[i][window], self.distance[i][window], self.other[i][window],
                  self.clear[i][window]]
        planes = np.stack([p.astype(np.float32) for p in planes], 2)
        planes[:, :, 2] /= 255
        if side != size:
            color = cv2.resize(color, (size, size), interpolation=cv2.INTER_AREA if side > size else cv2.INTER_CUBIC)
            planes = cv2.resize(planes, (size, size), interpolation=cv2.INTER_LINEAR)
        # Most photographs are lit from above; that tells a stone from the hole that another one left.
        turns = int(random.integers(4)) if random.random() < 0.35 else 0
        mirror = bool(random.integers(2))
        color, planes = np.rot90(color, turns), np.rot90(planes, turns)
        if mirror:
            color, planes = color[:, ::-1], planes[:, ::-1]
        if random.random() < 0.06:
            color = np.repeat(color.mean(2, keepdims=True), 3, 2)
        elif random.random() < 0.3:
            color = color * np.exp(0.12 * random.standard_normal(3)).astype(np.float32)
        color = np.clip(0.5 + np.exp(0.15 * random.standard_normal()) * (color - 0.5) + 0.05 * random.standard_normal(), 0, 1)
        return color.astype(np.float32), np.ascontiguousarray(planes.transpose(2, 0, 1))


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
    distance = cv2.distanceTransform(open_pixels, cv2.DIST_L2, 5) + edge * 0.5
    deepest = np.zeros(int(labels.max()) + 1, np.float32)
    np.maximum.at(deepest, labels.ravel(), distance.ravel())
    relative = distance / np.maximum(deepest[labels], 1e-6) * (labels > 0)
    return edge.astype(np.uint8), np.round(255 * relative).astype(np.uint8)
