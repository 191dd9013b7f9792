#!/usr/bin/python3
"""Trains the network of Segment on synthetic pictures and writes it as ONNX. `./dev train` calls it.

It runs on a GPU if PyTorch finds one, otherwise on the processor. Training continues from the checkpoint if there is one, so that
it can run in several sittings. The log holds one line per interval: step, seconds, learning rate, loss on training and on held-back
pictures.
"""
import time

BEGIN = time.time()  # --minutes counts from here: loading PyTorch takes seconds

import argparse
import copy
import inspect
import pathlib

import numpy as np
import torch

from looks import change_looks
from network import OUTPUTS, WIDTHS, Network, multiply_adds, network_of
from pictures import Pictures
from schedule import descend, interrupts, load_checkpoint, multiplies_bfloat16, parsed, rate_at, save, save_checkpoint, update_mean


def loss_of(logits, target):
    """Cross entropy of inside, border and not_material, and a smooth absolute error of the distance. Where a particle is too
    small or too faint for a label, the first three do not count."""
    entropy = torch.nn.functional.binary_cross_entropy_with_logits
    clear = target[:, 4]
    twice = torch.full((1,), 2.0, device=logits.device)
    inside = entropy(logits[:, 0], target[:, 0], weight=clear)
    border = entropy(logits[:, 1], target[:, 1], weight=clear, pos_weight=twice)
    error = torch.nn.functional.smooth_l1_loss(torch.sigmoid(logits[:, 2]), target[:, 2], beta=0.1, reduction="none")
    distance = (clear * error).mean()
    other = entropy(logits[:, 3], target[:, 3])
    return inside + 0.5 * border + 2 * distance + 0.3 * other


def logits_of(network, x, half):
    with torch.autocast(x.device.type, dtype=torch.bfloat16, enabled=half):
        return network.logits(x.contiguous(memory_format=torch.channels_last)).float()


def held_back_loss(network, pictures, half, most=64):
    """The mean over at most `most` whole pictures, which are the same each time."""
    network.eval()
    chosen = np.unique(np.linspace(0, len(pictures) - 1, most).astype(int)).tolist()
    with torch.no_grad():
        losses = []
        for k in range(0, len(chosen), 8):
            x, target = pictures.whole(chosen[k:k + 8])
            losses.append(float(loss_of(logits_of(network, x, half), target)))
    network.train()
    return float(np.mean(losses))


def export(network, path):
    network = copy.deepcopy(network).to("cpu", memory_format=torch.contiguous_format).eval()
    # PyTorch 2 has a second exporter, which cannot write operators of version 11.
    first = {"dynamo": False} if "dynamo" in inspect.signature(torch.onnx.export).parameters else {}
    torch.onnx.export(network, torch.zeros(1, 3, 256, 256), str(path), opset_version=11, input_names=["picture"],
                      output_names=["maps"], dynamic_axes={"picture": {2: "h", 3: "w"}, "maps": {2: "h", 3: "w"}}, **first)


def saved_network(path):
    """The network of a file network.pt, or of a checkpoint."""
    return network_of(torch.load(path, map_location="cpu")["average"])


def folders_of(pictures, kept):
    """Folders of pictures to train on, and those held back."""
    folders = sorted((f for f in pictures.iterdir() if f.is_dir()), key=lambda f: int(f.name))
    kept = kept or [folders[-1].name] if folders else []
    training, held_back = [f for f in folders if f.name not in kept], [f for f in folders if f.name in kept]
    if not training or not held_back:
        raise SystemExit(f"train: {pictures} needs at least two folders of pictures; the last one, or those of --held-back, are held back")
    return training, held_back


class Training:
    """The network, the running mean of its weights and the optimizer, on one device."""

    def __init__(self, a, training):
        self.a, self.training, self.device = a, training, training.planes.device
        network = saved_network(a.start) if a.start else Network(a.widths)
        self.network = network.to(self.device, memory_format=torch.channels_last).train()
        self.average = copy.deepcopy(self.network)
        # Normalization and the head's constants are not pulled towards zero.
        decayed = [w for w in self.network.parameters() if w.ndim > 1]
        others = [w for w in self.network.parameters() if w.ndim <= 1]
        self.optimizer = torch.optim.AdamW([{"params": decayed, "weight_decay": a.decay}, {"params": others, "weight_decay": 0}], lr=a.rate)
        self.half = self.device.type == "cuda" or multiplies_bfloat16()
        self.generator = torch.Generator(self.device)
        self.good = None  # state at the last line of the log

    def batch(self, step):
        self.generator.manual_seed(1_000_003 * self.a.seed + step)
        x, target = self.training.crops(self.generator, self.a.batch, self.a.size)
        return change_looks(x, np.random.default_rng([self.a.seed, step]), self.generator), target

    def check(self):
        """Learns from one batch on a copy. Halves the batch until it fits into the memory; uses 32 bits if 16 are not enough."""
        while True:
            try:
                x, target = self.batch(0)
                trial = copy.deepcopy(self.network)
                losses = [loss_of(logits_of(trial, x, half), target) for half in (False, self.half)]
                losses[1].backward()
                finite = all(bool(torch.isfinite(w.grad).all()) for w in trial.parameters())
                break
            except RuntimeError as e:
                if "out of memory" not in str(e) or self.a.batch < 2:
                    raise
            self.a.batch //= 2
            print(f"train: the GPU has too little memory; the batch is halved to {self.a.batch}", flush=True)
        whole, half = (float(loss) for loss in losses)
        print(f"first loss {whole:.4f} with 32 bits" + (f", {half:.4f} with bfloat16" if self.half else ""), flush=True)
        if not finite or not abs(half - whole) < 0.05 * abs(whole):
            self.whole_precision()

    def whole_precision(self):
        if not self.half:
            raise SystemExit("train: the loss is not finite; try a smaller --rate")
        print("train: bfloat16 is not precise enough here; going on with 32 bits", flush=True)
        self.half = False

    def keep_state(self):
        self.good = [copy.deepcopy(part.state_dict()) for part in (self.network, self.average, self.optimizer)]

    def go_back(self):
        """To the last line of the log, since when the loss stopped being a number."""
        self.whole_precision()
        for part, state in zip((self.network, self.average, self.optimizer), self.good):
            part.load_state_dict(copy.deepcopy(state))

    def step(self, step, done):
        x, target = self.batch(step)
        loss = loss_of(logits_of(self.network, x, self.half), target)
        descend(self.network, self.optimizer, loss, rate_at(step, done, self.a.rate))
        update_mean(self.average, self.network, step + 1, 0.999 if self.device.type == "cuda" else 0.995)
        return loss.detach()


class Clock:
    """How much of the training is done, by steps or by time. Of `minutes`, which count from the start of the program, some are
    left for loading and the last files."""

    def __init__(self, a, step, seconds):
        self.a, self.started = a, time.time() - seconds
        last = min(15.0, 6 * a.minutes) if a.minutes else 0
        self.end = BEGIN + 60 * a.minutes - last if a.minutes else None
        self.shown = time.time()

    def done(self, step):
        if self.end is None:
            return step / self.a.steps
        return (time.time() - self.started) / max(1e-3, self.end - self.started)

    def over(self, step):
        if self.end is None:
            return step >= min(self.a.steps, self.a.until or self.a.steps)
        return time.time() >= self.end

    def reports(self, step):
        """Whether to write a line of the log: every 200 steps, or every 30 seconds."""
        if self.end is None:
            return step % 200 == 0
        return time.time() - self.shown >= 30


def train(t, held_back):
    a, step, seconds = t.a, 0, 0.0
    state, log = (a.state or a.work) / "checkpoint.pt", a.work / "log.csv"
    if state.exists():
        step, seconds = load_checkpoint(state, t.network, t.average, t.optimizer)
    else:
        log.write_text("step,seconds,rate,loss,held_back\n")
    stop, clock = interrupts(), Clock(a, step, seconds)
    t.keep_state()
    total, count, before = torch.zeros((), device=t.device), 0, (step, time.time())
    while not stop and not clock.over(step):
        done = clock.done(step)
        total += t.step(step, done)
        step, count = step + 1, count + 1
        if step % 25 == 0:
            float(total)  # waits for the GPU, so that the clock is right
        if not (stop or clock.over(step) or clock.reports(step)):
            continue
        loss, now = float(total) / count, time.time()
        speed = (step - before[0]) / (now - before[1])
        total, count = torch.zeros((), device=t.device), 0
        if not np.isfinite(loss):
            t.go_back()
            clock.shown, before = now, (step, now)
            continue
        line = f"{step},{now - clock.started:.0f},{rate_at(step, done, a.rate):.2e},{loss:.4f},{held_back_loss(t.average, held_back, t.half):.4f}"
        with log.open("a") as f:
            f.write(line + "\n")
        left = (1 - clock.done(step)) * (clock.end - clock.started) if a.minutes else (a.steps - step) / speed
        print(line, f"# {speed:.1f} steps/s, {max(0, left) / 60:.1f} minutes left", flush=True)
        weights = {name: w.cpu().contiguous() for name, w in t.average.state_dict().items()}
        save({"average": weights, "step": step}, a.work / "network.pt")
        save_checkpoint(state, t.network, t.average, t.optimizer, step, now - clock.started)
        t.keep_state()
        clock.shown, before = time.time(), (step, time.time())
    print(f"{step} steps of {a.batch} crops in {time.time() - BEGIN:.0f} s since the start, "
          f"with {'bfloat16' if t.half else '32 bits'} on {t.device}; {a.work / 'network.pt'} holds the network", flush=True)
    export(t.average, a.work / "segment.onnx")
    if stop:
        raise SystemExit(130)


def arguments():
    p = argparse.ArgumentParser()
    p.add_argument("pictures", type=pathlib.Path, nargs="?", help="folder with one folder per run of pictures.yaml, or of a bundle")
    p.add_argument("--work", type=pathlib.Path, required=True, help="folder of network.pt, segment.onnx and log.csv")
    p.add_argument("--state", type=pathlib.Path, help="folder of the checkpoint, which continues a training; default: --work")
    p.add_argument("--export", type=pathlib.Path, metavar="NETWORK", help="write segment.onnx from this network.pt and end")
    p.add_argument("--minutes", type=float, help="train for this time instead of --steps, loading included")
    p.add_argument("--until", type=int, help="stop at this step, to go on with more pictures")
    p.add_argument("--start", type=pathlib.Path, help="network.pt or checkpoint whose weights to start from")
    p.add_argument("--held-back", nargs="*", help="folders that are not trained on; default: the last one")
    p.add_argument("--size", type=int, default=192, help="side of the crops, a multiple of 32")
    p.add_argument("--widths", type=int, nargs="+", default=WIDTHS, help="channels of the network at 1, 1/2, … of the resolution")
    p.add_argument("--decay", type=float, default=0.0, help="weight decay of AdamW")
    p.add_argument("--device", choices=("cuda", "cpu"), help="default: cuda if there is a GPU")
    return parsed(p, steps=17600, batch=6, rate=2.5e-3)


def main():
    a = arguments()
    if a.export:
        export(saved_network(a.export), a.work / "segment.onnx")
        return
    if a.pictures is None:
        raise SystemExit("train: give the folder of pictures")
    if a.device == "cuda" and not torch.cuda.is_available():
        raise SystemExit("train: PyTorch finds no GPU; leave out --device to train on the processor")
    if a.device is None and not torch.cuda.is_available():
        print("train: PyTorch finds no GPU; training on the processor, which is much slower", flush=True)
    device = torch.device("cpu" if a.device == "cpu" or not torch.cuda.is_available() else "cuda")
    torch.backends.cudnn.benchmark = True  # all batches have one shape
    if a.state:
        a.state.mkdir(parents=True, exist_ok=True)
    training, held_back = (Pictures(f, device) for f in folders_of(a.pictures, a.held_back))
    t = Training(a, training)
    print(f"{len(training)} pictures, {len(held_back)} held back; {sum(w.numel() for w in t.network.parameters())} weights, "
          f"{multiply_adds(t.average, 480) / 1e9:.2f} billion multiply-adds at 480 × 480; ready after {time.time() - BEGIN:.1f} s on "
          f"{torch.cuda.get_device_name() if device.type == 'cuda' else 'the processor'}, PyTorch {torch.__version__}", flush=True)
    t.check()
    train(t, held_back)
    print("outputs:", ", ".join(OUTPUTS), "in", a.work / "segment.onnx")


if __name__ == "__main__":
    main()
