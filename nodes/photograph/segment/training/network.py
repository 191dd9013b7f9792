"""The network of Segment: an encoder and decoder with skip connections (U-Net, Ronneberger et al. 2015). At the four finest
levels, half of the channels are normalized within each picture (IBN-Net, Pan et al. 2018)."""
import torch
from torch import nn

CHANNELS = (16, 32, 48, 64, 96, 96)  # at 1, 1/2, ... 1/32 of the resolution
OUTPUTS = ("inside", "border", "distance", "not_material")
ADAPTIVE_LEVELS = 4  # whose first convolution normalizes within the picture


class HalfInstance(nn.Module):
    """Normalizes the first half of the channels within each picture, the others by the training pictures.

    Light, contrast and color differ between synthetic pictures and photographs. Half of the features don't see them."""

    def __init__(self, channels):
        super().__init__()
        self.half = channels // 2
        self.instance = nn.InstanceNorm2d(self.half, affine=True)
        self.batch = nn.BatchNorm2d(channels - self.half)

    def forward(self, x):
        return torch.cat([self.instance(x[:, :self.half]), self.batch(x[:, self.half:])], 1)


def convolution(inputs, outputs, size=3, adaptive=False):
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, size, padding=size // 2, bias=False),
        HalfInstance(outputs) if adaptive else nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )


class Network(nn.Module):
    """Maps pictures (n, 3, h, w), encoded sRGB from 0 to 1, h and w multiples of 32, to (n, 4, h, w).

    Channels, from 0 to 1: the pixel lies in a particle; on the inner border of one; its distance to the border
    divided by the largest distance within the same particle; it shows something that is not material.
    """

    def __init__(self):
        super().__init__()
        self.down, self.narrow, self.up = nn.ModuleList(), nn.ModuleList(), nn.ModuleList()
        previous = 3
        for level, width in enumerate(CHANNELS):
            layers = [convolution(previous, width, adaptive=level < ADAPTIVE_LEVELS)]
            if level > 0:
                layers.append(convolution(width, width))
            self.down.append(nn.Sequential(*layers))
            previous = width
        for level in range(len(CHANNELS) - 2, -1, -1):
            width = CHANNELS[level]
            self.narrow.append(convolution(CHANNELS[level + 1], width, 1))  # before enlarging: four times cheaper
            self.up.append(convolution(2 * width, width))
        self.head = nn.Conv2d(CHANNELS[0], len(OUTPUTS), 1)

    def logits(self, x):
        x = (x - 0.45) * 4
        skipped = []
        for level, block in enumerate(self.down):
            if level > 0:
                x = nn.functional.max_pool2d(x, 2)
            x = block(x)
            skipped.append(x)
        skipped.pop()
        for narrow, up in zip(self.narrow, self.up):
            x = nn.functional.interpolate(narrow(x), scale_factor=2, mode="nearest")
            x = up(torch.cat([skipped.pop(), x], 1))
        return self.head(x)

    def forward(self, x):
        return torch.sigmoid(self.logits(x))
