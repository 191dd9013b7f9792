#!/usr/bin/python3
"""Fits confidence_of_score() of network_particles.cpp to the files of calibration.yaml.

calibrate.py OFFSET SLOPE FOLDER..., with the logistic function 1 / (1 + exp(OFFSET - SLOPE x)) that the program used. Prints the
new ones, and how often particles of each confidence are right.
"""
import csv
import sys

import numpy as np


def main():
    offset, slope = float(sys.argv[1]), float(sys.argv[2])
    confidence, right = np.zeros(0), np.zeros(0)
    for folder in sys.argv[3:]:
        found = [float(r["confidence"]) for r in csv.DictReader(open(folder + "/profiles.csv"))]
        matched = np.zeros(len(found))
        for row in csv.DictReader(open(folder + "/matches.csv")):
            matched[int(float(row["label"])) - 1] = 1
        confidence, right = np.append(confidence, found), np.append(right, matched)
    clipped = np.clip(confidence, 1e-9, 1 - 1e-9)
    score = (offset + np.log(clipped / (1 - clipped))) / slope
    a, b = offset, slope
    for _ in range(200):  # Newton's method for the logistic regression
        p = 1 / (1 + np.exp(a - b * score))
        gradient = np.array([-np.sum(p - right), np.sum((p - right) * score)])
        w = p * (1 - p)
        hessian = np.array([[np.sum(w), -np.sum(w * score)], [-np.sum(w * score), np.sum(w * score * score)]])
        step = np.linalg.solve(hessian + 1e-9 * np.eye(2), gradient)
        step = np.clip(step, -0.5, 0.5)  # far from the solution, whole steps overshoot
        a, b = a - step[0], b - step[1]
    print(f"{len(score)} particles, {right.mean():.3f} of them right; offset {a:.2f}, slope {b:.2f}")
    p = 1 / (1 + np.exp(a - b * score))
    for low in np.arange(0, 1, 0.1):
        inside = (p >= low) & (p < low + 0.1)
        if inside.any():
            print(f"confidence {low:.1f} to {low + 0.1:.1f}: {inside.sum():6d} particles, {right[inside].mean():.3f} right")


if __name__ == "__main__":
    main()
