"""measure_labels.py LABELS.tif PROFILES.csv: compares exported measures with scikit-image's of the same labels, from 400 pixels on.

Prints the number of grains, the largest relative deviation of each length and area, and of orientations in degrees (of grains 1.1 times as
long as wide), as JSON."""
import csv
import json
import sys

import numpy
import tifffile
from skimage.measure import regionprops_table

names = {"area_px": "area", "major_axis_px": "major_axis_length", "minor_axis_px": "minor_axis_length",
         "equivalent_diameter_px": "equivalent_diameter_area"}
theirs = regionprops_table(tifffile.imread(sys.argv[1]).astype(int), properties=("orientation", *names.values()))
rows = list(csv.DictReader(open(sys.argv[2])))
assert len(rows) == len(theirs["area"])
large = theirs["area"] >= 400
ours = {k: numpy.array([float(r[k]) for r in rows]) for k in (*names, "orientation")}
out = {k: numpy.abs(ours[k] / theirs[v] - 1)[large].max() for k, v in names.items()}
long = large & (theirs["major_axis_length"] > 1.1 * theirs["minor_axis_length"])
turn = ours["orientation"] - 90 - numpy.degrees(theirs["orientation"])
out["orientation"] = numpy.abs((turn + 90) % 180 - 90)[long].max()
print(json.dumps({"count": int(large.sum()), **out}))
