"""read_outlines.py FILE WIDTH HEIGHT: prints the label of each pixel, the classes and whether polygons are valid, as JSON.

GeoJSON and COCO are read with Python's json, ImageJ's regions after the offsets of RoiDecoder.java. A pixel belongs to an outline if its
center lies inside of an odd number of its rings."""
import json
import struct
import sys
import zipfile

import numpy
from skimage.measure import points_in_poly


def rings_mask(rings, width, height):
    x, y = numpy.meshgrid(numpy.arange(width) + 0.5, numpy.arange(height) + 0.5)
    centers = numpy.column_stack([x.ravel(), y.ravel()])
    inside = numpy.zeros(width * height, bool)
    for ring in rings:
        inside ^= points_in_poly(centers, numpy.asarray(ring, float))
    return inside.reshape(height, width)


def runs_mask(runs):
    height, width = runs["size"]
    values = numpy.repeat(numpy.arange(len(runs["counts"])) % 2, runs["counts"])
    return values.reshape(width, height).T.astype(bool)


def read_roi(data):
    assert data[:4] == b"Iout"
    version, kind = struct.unpack(">hBx", data[4:8])
    top, left, bottom, right = struct.unpack(">4h", data[8:16])
    count, = struct.unpack(">H", data[16:18])
    shape, = struct.unpack(">i", data[36:40])
    options, = struct.unpack(">h", data[50:52])
    position, second = struct.unpack(">2i", data[56:64])
    assert len(data) >= second + 64
    group = data[second + 30]
    if shape:
        assert kind == 1
        values, rings = list(struct.unpack(f">{shape}f", data[64:64 + 4 * shape])), []
        while values:
            segment = values.pop(0)
            if segment == 4:
                continue
            if segment == 0:
                rings.append([])
            rings[-1].append((values.pop(0), values.pop(0)))
    elif options & 128:
        numbers = struct.unpack(f">{2 * count}f", data[64 + 4 * count:64 + 12 * count])
        rings = [list(zip(numbers[:count], numbers[count:]))]
    else:
        numbers = struct.unpack(f">{2 * count}H", data[64:64 + 4 * count])
        rings = [[(left + a, top + b) for a, b in zip(numbers[:count], numbers[count:])]]
    for ring in rings:
        for a, b in ring:
            assert left <= a <= right and top <= b <= bottom
    return rings, max(0, group - 1), max(0, position - 1)


def main(path, width, height):
    masks, classes, sections, valid, wound = [], [], [], True, True
    if path.endswith(".geojson"):
        from shapely.geometry import shape
        for feature in json.load(open(path))["features"]:
            geometry = shape(feature["geometry"])
            valid &= geometry.is_valid
            parts = [geometry] if geometry.geom_type == "Polygon" else list(geometry.geoms)
            wound &= all(p.exterior.is_ccw and not any(i.is_ccw for i in p.interiors) for p in parts)
            masks.append(rings_mask([r.coords for p in parts for r in (p.exterior, *p.interiors)], width, height))
            classes.append(int(feature["properties"]["classification"]["name"].split()[1]))
            sections.append(feature["properties"]["section"])
    elif path.endswith(".json"):
        data = json.load(open(path))
        for a in data["annotations"]:
            s = a["segmentation"]
            masks.append(runs_mask(s) if isinstance(s, dict)
                         else rings_mask([numpy.reshape(p, (-1, 2)) for p in s], width, height))
            valid &= a["area"] == masks[-1].sum() or not all(float(v).is_integer() for p in s for v in p)
            y, x = numpy.nonzero(masks[-1])
            valid &= abs(a["bbox"][0] - x.min()) <= 1 and abs(a["bbox"][1] + a["bbox"][3] - y.max() - 1) <= 1
            classes.append([c["id"] for c in data["categories"]].index(a["category_id"]))
            sections.append([i["id"] for i in data["images"]].index(a["image_id"]))
    else:
        archive = zipfile.ZipFile(path) if path.endswith(".zip") else None
        for data in [archive.read(n) for n in sorted(archive.namelist())] if archive else [open(path, "rb").read()]:
            rings, group, section = read_roi(data)
            masks.append(rings_mask(rings, width, height))
            classes.append(group)
            sections.append(section)
    labels = numpy.zeros((max(sections) + 1, height, width), int)
    for number, (mask, section) in enumerate(zip(masks, sections), 1):
        labels[section][mask] = number
    print(json.dumps({"labels": labels.ravel().tolist(), "classes": classes, "valid": bool(valid), "wound": bool(wound)}))


main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
