#!/usr/bin/python3
"""compare.py MODEL…: compares networks (ONNX) with the one in use, on pictures that none was trained on. Prints tables.

- loss of the held-back pictures, as in training;
- average precision (AP) of Segment on held-back pictures, pooled over the pictures of a folder;
- AP of Segment on photographs with masks, NAME.jpg and NAME_labels.png.

Segment's judge and close look stay those in use, which learned from the maps of the network in use. So the AP of another network can
rise when it has its own.
"""
import argparse
import csv
import pathlib
import subprocess
import tempfile

import cv2
import numpy as np
import torch

from pictures import Pictures
from train import loss_of

TRAINING = pathlib.Path(__file__).resolve().parent
SOURCE = TRAINING.parents[3]
IN_USE = TRAINING.parent / "model/segment.onnx"


def loss_on(model, folder):
    """Mean over all pictures of a folder."""
    network = cv2.dnn.readNetFromONNX(str(model))
    pictures, losses = Pictures([folder]), []
    for k in range(len(pictures)):
        x, target = pictures.whole([k])
        network.setInput(x.numpy())
        losses.append(float(loss_of(torch.logit(torch.from_numpy(network.forward()), eps=1e-6), target)))
    return np.mean(losses)


def score_of(program, model, photo, masks, view="auto"):
    """Found, masks, and matches at overlaps of 0.5 and 0.75."""
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([program, "run", SOURCE / "graphs/library/score.yaml", "--quiet", "--no-cache", "--out", out,
                               "--param", "method=network", "--param", f"photo={photo.resolve()}", "--param", f"masks={masks.resolve()}",
                               "--set", f"segment.model={model.resolve()}", "--set", f"segment.view={view}"], capture_output=True, text=True)
        if done.returncode != 0 and "no particles are left" in done.stderr:
            labels = cv2.imread(str(masks), cv2.IMREAD_UNCHANGED)
            return np.array([0.0, len(np.unique(labels[labels > 0])), 0.0, 0.0])
        if done.returncode != 0:
            raise SystemExit(f"compare: {photo}: {done.stderr.strip()}")
        with open(pathlib.Path(out) / "score.csv") as f:
            row = {name: float(value) for name, value in next(csv.DictReader(f)).items() if value}
    all_particles = row["found"] + row["masks"]
    return np.array([row["found"], row["masks"], row["matched"], row["ap_75"] * all_particles / (1 + row["ap_75"])])


def precision_of(score):
    found, masks, matched, matched_75 = score
    if found + masks == 0:
        return "no particles"
    return (f"{matched / (found + masks - matched):.3f} ({matched_75 / (found + masks - matched_75):.3f}), "
            f"precision {matched / max(1, found):.2f}, recall {matched / max(1, masks):.2f}")


def print_row(name, values):
    print(f"| {name} | " + " | ".join(values) + " |", flush=True)


def main():
    p = argparse.ArgumentParser()
    p.add_argument("models", type=pathlib.Path, nargs="+")
    p.add_argument("--pictures", type=pathlib.Path, nargs="*", default=[], help="folders of held-back pictures")
    p.add_argument("--photos", type=pathlib.Path, help="folder of photographs with masks")
    p.add_argument("--most", type=int, default=12, help="pictures of each folder whose particles are looked for")
    p.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/terrazzo")
    a = p.parse_args()
    models = [IN_USE, *a.models]
    for model in models:
        if not model.exists():
            raise SystemExit(f"compare: {model} is missing")
    print_row("", ["in use", *(str(model) for model in a.models)])
    print_row("---", ["---"] * len(models))
    for folder in a.pictures:
        print_row(f"loss, {folder.name}", [f"{loss_on(model, folder):.4f}" for model in models])
    for photo in sorted(a.photos.glob("*.jpg")) if a.photos else []:
        masks = photo.with_name(photo.stem + "_labels.png")
        print_row(f"AP, {photo.stem}", [precision_of(score_of(a.program, model, photo, masks)) for model in models])
    for folder in a.pictures:
        photos = sorted(folder.glob("image_*.png"))[:a.most]
        # Synthetic banks are seen at an angle, which the automatic view refuses.
        scores = [sum(score_of(a.program, model, photo, photo.with_name(photo.name.replace("image_", "labels_")), "surface")
                      for photo in photos) for model in models]
        print_row(f"AP, {folder.name}, {len(photos)} pictures", [precision_of(score) for score in scores])


if __name__ == "__main__":
    main()
