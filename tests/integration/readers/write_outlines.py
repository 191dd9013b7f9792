"""write_outlines.py FOLDER: writes outlines as QuPath, pycocotools and ImageJ write them, and prints the pixels of each, as JSON.

The picture has 60 × 40 pixels. A pixel belongs to an outline if its center lies inside of an odd number of its rings."""
import json
import struct
import sys
import zipfile

import numpy
import tifffile
from skimage.measure import points_in_poly

WIDTH, HEIGHT = 60, 40
folder = sys.argv[1]
star = [(10.2, 2.1), (12.9, 8.2), (19.3, 8.6), (14.4, 12.5), (16.3, 18.7), (10.4, 15.1), (4.6, 18.5), (6.1, 12.4), (1.4, 8.3), (7.7, 8.4)]
outer, hole = [(25, 3), (41, 3), (41, 19), (25, 19)], [(30, 8), (30, 14), (36, 14), (36, 8)]
parts = [[(3, 25), (9, 25), (9, 31), (3, 31)], [(12, 25), (20, 25), (20, 36), (12, 36)]]
shapes = [[star], [outer, hole], parts]
names = ["quartz", "mica", "quartz"]


def mask_of(rings):
    x, y = numpy.meshgrid(numpy.arange(WIDTH) + 0.5, numpy.arange(HEIGHT) + 0.5)
    centers = numpy.column_stack([x.ravel(), y.ravel()])
    inside = numpy.zeros(WIDTH * HEIGHT, bool)
    for ring in rings:
        inside ^= points_in_poly(centers, numpy.asarray(ring, float))
    return inside.reshape(HEIGHT, WIDTH)


def labels_of(masks):
    out = numpy.zeros((HEIGHT, WIDTH), int)
    for number, mask in enumerate(masks, 1):
        assert not out[mask].any()
        out[mask] = number
    return out.ravel().tolist()


def closed(ring):
    return [list(p) for p in ring] + [list(ring[0])]


def runs_of(mask):
    flat = mask.T.ravel().astype(int)
    change = numpy.flatnonzero(numpy.diff(flat)) + 1
    edges = numpy.concatenate([[0], change, [flat.size]])
    counts = numpy.diff(edges).tolist()
    return counts if flat[0] == 0 else [0] + counts


def packed(counts):
    """The text form of run lengths (maskApi.c)."""
    text = ""
    for i, count in enumerate(counts):
        x = count - (counts[i - 2] if i > 2 else 0)
        more = True
        while more:
            c = x & 0x1F
            x >>= 5
            more = x != -1 if c & 0x10 else x != 0
            text += chr((c | 0x20 if more else c) + 48)
    return text


def roi(kind, rings=(), box=None, exact=False, composite=False, slice_=0, group=0):
    points = [p for ring in rings for p in ring]
    left, top, right, bottom = box or (int(min(x for x, _ in points)), int(min(y for _, y in points)),
                                       int(max(x for x, _ in points)) + 1, int(max(y for _, y in points)) + 1)
    body, count, shape = b"", 0, 0
    if composite:
        values = []
        for ring in rings:
            for i, p in enumerate(ring):
                values += [float(i > 0), *p]
            values.append(4.0)
        shape, body = len(values), struct.pack(f">{len(values)}f", *values)
    elif points:
        count = len(points)
        body = struct.pack(f">{2 * count}H", *[int(x) - left for x, _ in points], *[int(y) - top for _, y in points])
        if exact:
            body += struct.pack(f">{2 * count}f", *[x for x, _ in points], *[y for _, y in points])
    head = bytearray(64)
    struct.pack_into(">4sHBx4hH", head, 0, b"Iout", 228, kind, top, left, bottom, right, count)
    struct.pack_into(">i", head, 36, shape)
    struct.pack_into(">h", head, 50, 128 if exact else 0)
    struct.pack_into(">2i", head, 56, slice_, 64 + len(body))
    second = bytearray(64)
    second[30] = group
    return bytes(head) + body + bytes(second)


masks = [mask_of(rings) for rings in shapes]
# QuPath: a list of features or a collection.
json.dump([{"type": "Feature", "id": str(k), "geometry":
            {"type": "MultiPolygon", "coordinates": [[closed(r)] for r in rings]} if rings is parts
            else {"type": "Polygon", "coordinates": [closed(r) for r in rings]},
            "properties": {"objectType": "annotation", "classification": {"name": name, "color": [200, 0, 0]}}}
           for k, (rings, name) in enumerate(zip(shapes, names))], open(folder + "/qupath.geojson", "w"))
images = [{"id": 7, "width": WIDTH, "height": HEIGHT, "file_name": "a.png"}]
categories = [{"id": 3, "name": "mica"}, {"id": 9, "name": "quartz"}]
kinds = [9, 3, 9]


def annotations(segmentations):
    return [{"id": k, "image_id": 7, "category_id": kinds[k], "iscrowd": 0, "segmentation": s} for k, s in enumerate(segmentations)]


def coco(name, segmentations):
    json.dump({"images": images, "categories": categories, "annotations": annotations(segmentations)}, open(f"{folder}/{name}", "w"))


size = [HEIGHT, WIDTH]
coco("polygons.json", [[[v for p in r for v in p] for r in rings] for rings in shapes])
coco("runs.json", [{"size": size, "counts": runs_of(m)} for m in masks])
coco("packed.json", [{"size": size, "counts": packed(runs_of(m))} for m in masks])
ovals = numpy.hypot((numpy.arange(WIDTH) + 0.5 - 50) / 7, ((numpy.arange(HEIGHT) + 0.5 - 29) / 6)[:, None]) < 1
regions = [roi(0, [star], exact=True, group=2), roi(1, [outer, hole], composite=True, group=1), roi(8, [parts[0]], group=2),
           roi(7, [parts[1]], group=2), roi(1, box=(22, 24, 30, 33), group=1), roi(2, box=(43, 23, 57, 35), group=1)]
with zipfile.ZipFile(folder + "/set.zip", "w", zipfile.ZIP_DEFLATED) as archive:
    for k, region in enumerate(regions):
        archive.writestr(f"{k:04}-0001.roi", region)
open(folder + "/star.roi", "wb").write(roi(0, [star], exact=True, slice_=2))
rois = masks[:2] + [mask_of([p]) for p in parts] + [mask_of([[(22, 24), (30, 24), (30, 33), (22, 33)]]), ovals]
for kind in ("uint8", "uint16", "uint32", "int32"):
    tifffile.imwrite(f"{folder}/{kind}.tif", numpy.reshape(labels_of(masks), (HEIGHT, WIDTH)).astype(kind), compression="zlib")
print(json.dumps({"labels": labels_of(masks), "classes": [1, 0, 1], "roi_labels": labels_of(rois), "roi_classes": [1, 0, 1, 1, 0, 0]}))
