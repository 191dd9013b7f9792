#!/usr/bin/python3
"""Trains the network of Segment on synthetic pictures and writes it as ONNX. `./dev train` calls it.

Training continues from the checkpoint if there is one, so that it can run in several sittings. The log holds one
line per interval: step, seconds, learning rate, loss on training and on held-back pictures.
"""
import argparse
import copy
import pathlib
import time

import numpy as np
import torch

from looks import change_looks
from network import OUTPUTS, Network
from pictures import Pictures
from schedule import descend, interrupts, load_checkpoint, multiplies_bfloat16, parsed, rate_at, save_checkpoint, update_mean


def loss_of(logits, target):
    """Cross entropy of inside, border and not_material, and a smooth absolute error of the distance. Where a particle is too
    small or too faint for a label, the first three do not count."""
    entropy = torch.nn.functional.binary_cross_entropy_with_logits
    clear = target[:, 4]
    inside = entropy(logits[:, 0], target[:, 0], weight=clear)
    border = entropy(logits[:, 1], target[:, 1], weight=clear, pos_weight=torch.tensor(2.0))
    error = torch.nn.functional.smooth_l1_loss(torch.sigmoid(logits[:, 2]), target[:, 2], beta=0.1, reduction="none")
    distance = (clear * error).mean()
    other = entropy(logits[:, 3], target[:, 3])
    return inside + 0.5 * border + 2 * distance + 0.3 * other


def batch_of(pictures, random, count, size):
    crops = [pictures.crop(random, size) for _ in range(count)]
    color = np.stack([c for c, _ in crops]).transpose(0, 3, 1, 2)
    return torch.from_numpy(np.ascontiguousarray(color)), torch.from_numpy(np.stack([t for _, t in crops]))


def logits_of(network, x, half):
    with torch.autocast("cpu", dtype=torch.bfloat16, enabled=half):
        return network.logits(x.contiguous(memory_format=torch.channels_last)).float()


def held_back_loss(network, pictures, size, half):
    network.eval()
    random = np.random.default_rng(12345)
    with torch.no_grad():
        losses = [float(loss_of(logits_of(network, x, half), t))
                  for x, t in (batch_of(pictures, random, 8, size) for _ in range(8))]
    network.train()
    return float(np.mean(losses))


def export(network, path):
    network = copy.deepcopy(network).to(memory_format=torch.contiguous_format).eval()
    torch.onnx.export(network, torch.zeros(1, 3, 256, 256), str(path), opset_version=11, input_names=["picture"],
                      output_names=["maps"], dynamic_axes={"picture": {2: "h", 3: "w"}, "maps": {2: "h", 3: "w"}})


def main():
    p = argparse.ArgumentParser()
    p.add_argument("pictures", type=pathlib.Path, help="folder with one folder per run of pictures.yaml")
    p.add_argument("--work", type=pathlib.Path, required=True, help="folder of checkpoint, log and model")
    p.add_argument("--until", type=int, help="stop at this step, to go on with more pictures")
    p.add_argument("--start", type=pathlib.Path, help="checkpoint of another training whose weights to start from")
    p.add_argument("--held-back", nargs="*", help="folders that are not trained on; default: the last one")
    p.add_argument("--size", type=int, default=192)
    a = parsed(p, steps=17600, batch=6, rate=2.5e-3)

    folders = sorted((f for f in a.pictures.iterdir() if f.is_dir()), key=lambda f: int(f.name))
    if len(folders) < 2:
        raise SystemExit(f"train: {a.pictures} needs at least two folders of pictures; the last one is held back")
    kept = a.held_back or [folders[-1].name]
    training = Pictures([f for f in folders if f.name not in kept])
    held_back = Pictures([f for f in folders if f.name in kept])
    print(f"{len(training)} pictures, {len(held_back)} held back", flush=True)

    half = multiplies_bfloat16()
    network = Network().to(memory_format=torch.channels_last)
    average = copy.deepcopy(network)
    optimizer = torch.optim.Adam(network.parameters(), lr=a.rate)
    step, seconds = 0, 0.0
    checkpoint, log = a.work / "checkpoint.pt", a.work / "log.csv"
    if checkpoint.exists():
        step, seconds = load_checkpoint(checkpoint, network, average, optimizer)
    else:
        if a.start:
            weights = torch.load(a.start)["average"]
            network.load_state_dict(weights)
            average.load_state_dict(weights)
        log.write_text("step,seconds,rate,loss,held_back\n")
        print(sum(w.numel() for w in network.parameters()), "weights", flush=True)

    stop = interrupts()
    started, losses = time.time() - seconds, []
    network.train()
    last = min(a.steps, a.until or a.steps)
    while step < last and not stop:
        random = np.random.default_rng([a.seed, step])
        x, target = batch_of(training, random, a.batch, a.size)
        x = change_looks(x, random)
        rate = rate_at(step, a.steps, a.rate)
        loss = loss_of(logits_of(network, x, half), target)
        descend(network, optimizer, loss, rate)
        losses.append(float(loss))
        step += 1
        update_mean(average, network, step)
        if step % 200 == 0 or step == last or stop:
            seconds = time.time() - started
            line = f"{step},{seconds:.0f},{rate:.2e},{np.mean(losses):.4f},{held_back_loss(average, held_back, a.size, half):.4f}"
            losses = []
            with log.open("a") as f:
                f.write(line + "\n")
            print(line, f"# {seconds / step * (a.steps - step) / 60:.0f} minutes left", flush=True)
            save_checkpoint(checkpoint, network, average, optimizer, step, seconds)
            export(average, a.work / "segment.onnx")
    if stop:
        raise SystemExit(130)
    print("outputs:", ", ".join(OUTPUTS), "in", a.work / "segment.onnx")


if __name__ == "__main__":
    main()
