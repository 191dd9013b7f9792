#!/usr/bin/python3
"""bundle.py PICTURES OUT: puts training pictures and the training programs into one small folder, which trains anywhere.

`./dev train --bundle` calls it. A picture becomes a JPEG file, and everything known about it one PNG file (`truth_of` in
pictures.py). The JPEG quality is the best of 90, 85 … 60 whose folder is small enough.
"""
import argparse
import pathlib
import shutil

import cv2
import numpy as np

from pictures import truth_of

PROGRAMS = ("looks.py", "network.py", "pictures.py", "schedule.py", "train.py")


def truth_file(path):
    """The bytes of the PNG file. Labels are numbered again, since fewer bits are smaller."""
    labels, other, unclear = truth_of(path)
    values, numbers = np.unique(np.append(0, labels), return_inverse=True)
    if len(values) > 1 << 14:
        raise SystemExit(f"bundle: {path}: at most 16,383 particles fit; there are {len(values) - 1}")
    truth = 4 * numbers.ravel()[1:].reshape(labels.shape) + 2 * (other > 0) + (unclear > 0)
    truth = truth.astype(np.uint8 if truth.max() < 256 else np.uint16)
    return cv2.imencode(".png", truth, [cv2.IMWRITE_PNG_COMPRESSION, 9])[1].tobytes()


def picture_file(path, quality):
    options = [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_OPTIMIZE, 1, cv2.IMWRITE_JPEG_PROGRESSIVE, 1]
    return cv2.imencode(".jpg", cv2.imread(str(path)), options)[1].tobytes()


def main():
    p = argparse.ArgumentParser()
    p.add_argument("pictures", type=pathlib.Path, help="folder with one folder per run of pictures.yaml")
    p.add_argument("out", type=pathlib.Path)
    p.add_argument("--megabytes", type=float, default=60, help="most MiB that the folder may have (default: 60)")
    p.add_argument("--start", type=pathlib.Path, help="network.pt whose weights the training starts from")
    p.add_argument("--folders", nargs="*", help="folders of pictures to take; default: all")
    p.add_argument("--held-back", nargs="*", default=[], help="folders that are not trained on; 16 pictures of each are taken")
    a = p.parse_args()

    folders = sorted((f for f in a.pictures.iterdir() if f.is_dir() and f.name in (a.folders or [f.name])), key=lambda f: int(f.name))
    paths = [path for f in folders for path in sorted(f.glob("image_*.*"))[:16 if f.name in a.held_back else None]]
    if not paths:
        raise SystemExit(f"bundle: {a.pictures} holds no pictures")
    here = pathlib.Path(__file__).resolve().parent
    others = [here / name for name in PROGRAMS] + ([a.start] if a.start else [])
    truths = [truth_file(path) for path in paths]
    # Disks give whole blocks of 4 KiB, but what travels are bytes.
    room = a.megabytes * 2**20 - sum(map(len, truths)) - sum(f.stat().st_size for f in others)
    for quality in range(90, 55, -5):
        files = [picture_file(path, quality) for path in paths]
        if sum(map(len, files)) <= room:
            break
    else:
        raise SystemExit(f"bundle: {len(paths)} pictures do not fit into {a.megabytes} MiB; take fewer folders or raise --megabytes")
    shutil.rmtree(a.out / "pictures", ignore_errors=True)
    for path, picture, truth in zip(paths, files, truths):
        folder, number = a.out / "pictures" / path.parent.name, path.stem[len("image_"):]
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"image_{number}.jpg").write_bytes(picture)
        (folder / f"truth_{number}.png").write_bytes(truth)
    for file in others:
        shutil.copyfile(file, a.out / ("start.pt" if file == a.start else file.name))
    size = sum(f.stat().st_size for f in a.out.rglob("*") if f.is_file())
    print(f"{len(paths)} pictures of {len(folders)} folders, JPEG quality {quality}, {size / 2**20:.1f} MiB in {a.out}")


if __name__ == "__main__":
    main()
