"""The network of Segment: an encoder and decoder with skip connections (U-Net, Ronneberger et al. 2015). At the four finest
levels, half of the channels are normalized within each picture (IBN-Net, Pan et al. 2018)."""
import torch
from torch import nn

WIDTHS = (16, 32, 48, 64, 96, 96)  # channels at 1, 1/2, ... 1/32 of the resolution
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
        halves = x[:, :self.half], x[:, self.half:]
        if not x.is_cuda:
            return torch.cat([self.instance(halves[0]), self.batch(halves[1])], 1)
        # The GPU normalizes tensors many times faster if their channels lie together.
        halves = self.instance(halves[0]), self.batch(together(halves[1]))
        return torch.cat([together(half) for half in halves], 1)


def together(x):
    return x.contiguous(memory_format=torch.channels_last)


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

    def __init__(self, widths=WIDTHS):
        super().__init__()
        self.down, self.narrow, self.up = nn.ModuleList(), nn.ModuleList(), nn.ModuleList()
        previous = 3
        for level, width in enumerate(widths):
            layers = [convolution(previous, width, adaptive=level < ADAPTIVE_LEVELS)]
            if level > 0:
                layers.append(convolution(width, width))
            self.down.append(nn.Sequential(*layers))
            previous = width
        for level in range(len(widths) - 2, -1, -1):
            width = widths[level]
            self.narrow.append(convolution(widths[level + 1], width, 1))  # before enlarging: four times cheaper
            self.up.append(convolution(2 * width, width))
        self.head = nn.Conv2d(widths[0], len(OUTPUTS), 1)

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


def network_of(weights):
    """The network that has these weights, whose shapes tell its widths."""
    levels = sum(name.startswith("down.") and name.endswith(".0.0.weight") for name in weights)
    network = Network([weights[f"down.{level}.0.0.weight"].shape[0] for level in range(levels)])
    network.load_state_dict(weights)
    return network


def multiply_adds(network, side):
    """Multiplications of the convolutions for a picture of side × side pixels."""
    counts = []
    hooks = [m.register_forward_hook(lambda m, _, out: counts.append(m.weight.numel() * out.shape[2] * out.shape[3]))
             for m in network.modules() if isinstance(m, nn.Conv2d)]
    training = network.training
    with torch.no_grad():
        network.eval()(torch.zeros(1, 3, side, side, device=network.head.weight.device))
    network.train(training)
    for hook in hooks:
        hook.remove()
    return sum(counts)
