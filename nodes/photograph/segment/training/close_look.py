#!/usr/bin/python3
"""close_look.py CLOSE_UPS… --work WORK: trains the network that looks at each candidate closely, on the files of terrazzo_evidence.

Training continues from its checkpoint. Writes WORK/close_look.onnx, and to WORK/log.csv what the network gains on held-back pictures."""
import argparse
import copy
import pathlib
import time

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from schedule import descend, interrupts, load_checkpoint, multiplies_bfloat16, parsed, rate_at, save_checkpoint, update_mean

SIDE, PLANES = 48, 10
LEAST = 0.2  # overlap: what hardly shares anything with a particle teaches no outline
CHANNELS = (16, 24, 32, 48)  # at 48, 24, 12 and 6 pixels
RECORD = np.dtype([("scale", "f4"), ("outside", "f4"), ("overlap", "f4"), ("planes", "u1", (PLANES, SIDE, SIDE))])


def convolution(inputs, outputs, size=3):
    return nn.Sequential(nn.Conv2d(inputs, outputs, size, padding=size // 2, bias=False), nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))


class CloseUps(nn.Module):
    """Maps close-ups (n, 10, 48, 48) to (n, 1, 48, 48): the logit that a pixel belongs to the particle which the candidate shows."""

    def __init__(self):
        super().__init__()
        self.down, self.narrow, self.up = nn.ModuleList(), nn.ModuleList(), nn.ModuleList()
        previous = PLANES
        for width in CHANNELS:
            layers = [convolution(previous, width)]
            if len(self.down) > 0:
                layers.append(convolution(width, width))
            self.down.append(nn.Sequential(*layers))
            previous = width
        for level in range(len(CHANNELS) - 2, -1, -1):
            width = CHANNELS[level]
            self.narrow.append(convolution(CHANNELS[level + 1], width, 1))
            self.up.append(convolution(2 * width, width))
        self.mask = nn.Conv2d(CHANNELS[0], 1, 1)

    def forward(self, x):
        skipped = []
        for level, block in enumerate(self.down):
            if level > 0:
                x = functional.max_pool2d(x, 2)
            x = block(x)
            skipped.append(x)
        skipped.pop()
        for narrow, up in zip(self.narrow, self.up):
            x = functional.interpolate(narrow(x), scale_factor=2, mode="nearest")
            x = up(torch.cat([skipped.pop(), x], 1))
        return self.mask(x)


def batch_of(records, indices, random, change):
    """Close-ups (n, 10, 48, 48), the particle's mask (n, 48, 48), and its area outside of the close-up."""
    chosen = records[np.sort(indices)]
    planes = chosen["planes"].astype(np.float32)
    planes[:, :3] = (planes[:, :3] - 128) / 32
    planes[:, 3:] /= 255
    mask = planes[:, 9].copy()
    planes[:, 9] = chosen["scale"][:, None, None]
    if change:
        for i in range(len(planes)):
            if random.random() < 0.5:
                planes[i], mask[i] = planes[i, :, :, ::-1], mask[i, :, ::-1]
            if random.random() < 0.35:
                turns = int(random.integers(4))
                planes[i], mask[i] = np.rot90(planes[i], turns, (1, 2)), np.rot90(mask[i], turns)
            color = planes[i, :3]
            if random.random() < 0.4:
                mix = np.eye(3) + 0.2 * random.standard_normal((3, 3))
                color = np.einsum("ij,jhw->ihw", mix, color)
            if random.random() < 0.15:
                color = np.repeat(color.mean(0, keepdims=True), 3, 0)
            if random.random() < 0.3:
                color = color + 0.3 * random.random() * random.standard_normal(color.shape)
            planes[i, :3] = color * np.exp(0.2 * random.standard_normal())
    return torch.from_numpy(planes), torch.from_numpy(mask), torch.from_numpy(chosen["outside"].copy())


def overlap_of(logit, mask, outside):
    found, true = (logit > 0).float(), mask
    shared = (found * true).sum((1, 2))
    return shared / (found.sum((1, 2)) + true.sum((1, 2)) + outside - shared).clamp(min=1)


def held_back(network, records):
    """Loss; mean overlap of the candidates with their particle, and of what the network makes of them."""
    network.eval()
    losses, after = [], []
    with torch.no_grad():
        for k in range(0, len(records), 256):
            x, mask, outside = batch_of(records, np.arange(k, min(k + 256, len(records))), None, False)
            logit = network(x)[:, 0]
            losses.append(float(functional.binary_cross_entropy_with_logits(logit, mask)))
            after.append(overlap_of(logit, mask, outside).numpy())
    network.train()
    return np.mean(losses), records["overlap"].mean(), np.concatenate(after).mean()


def export(network, path):
    network = copy.deepcopy(network).to(memory_format=torch.contiguous_format).eval()
    torch.onnx.export(network, torch.zeros(16, PLANES, SIDE, SIDE), str(path), opset_version=11, input_names=["close_up"],
                      output_names=["particle"], dynamic_axes={"close_up": {0: "n"}, "particle": {0: "n"}})


def main():
    p = argparse.ArgumentParser()
    p.add_argument("files", type=pathlib.Path, nargs="+")
    p.add_argument("--work", type=pathlib.Path, required=True)
    a = parsed(p, steps=7000, batch=64, rate=3e-3)
    files = [np.memmap(f, RECORD, "r") for f in a.files]
    last = len(files[-1]) // 12  # held back: the end of the last file, whose pictures are in no other part
    near = [f[f["overlap"] > LEAST] for f in (*files[:-1], files[-1][:-last], files[-1][-last:])]
    training, test = np.concatenate(near[:-1]), near[-1][:: max(1, len(near[-1]) // 3000)]
    print(len(training), "close-ups,", len(test), "held back", flush=True)
    network = CloseUps().to(memory_format=torch.channels_last)
    print(sum(w.numel() for w in network.parameters()), "weights", flush=True)
    average = copy.deepcopy(network)
    optimizer = torch.optim.Adam(network.parameters(), lr=a.rate)
    half = multiplies_bfloat16()
    step, seconds, checkpoint, log = 0, 0.0, a.work / "checkpoint.pt", a.work / "log.csv"
    if checkpoint.exists():
        step, seconds = load_checkpoint(checkpoint, network, average, optimizer)
    else:
        log.write_text("step,seconds,rate,loss,held_back,overlap_before,overlap_after\n")
    stop = interrupts()
    started, losses = time.time() - seconds, []
    while step < a.steps and not stop:
        random = np.random.default_rng([a.seed, step])
        x, mask, _ = batch_of(training, random.choice(len(training), a.batch), random, True)
        rate = rate_at(step, step / a.steps, a.rate)
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=half):
            out = network(x.contiguous(memory_format=torch.channels_last))
        loss = functional.binary_cross_entropy_with_logits(out.float()[:, 0], mask)
        descend(network, optimizer, loss, rate)
        losses.append(float(loss))
        step += 1
        update_mean(average, network, step)
        if step % 250 == 0 or step == a.steps or stop:
            seconds = time.time() - started
            line = f"{step},{seconds:.0f},{rate:.2e}," + ",".join(f"{v:.4f}" for v in (np.mean(losses), *held_back(average, test)))
            losses = []
            with log.open("a") as f:
                f.write(line + "\n")
            print(line, flush=True)
            save_checkpoint(checkpoint, network, average, optimizer, step, seconds)
            export(average, a.work / "close_look.onnx")
    if stop:
        raise SystemExit(130)


if __name__ == "__main__":
    main()
