"""EBSD maps: EDAX/TSL .ang and Oxford/HKL .ctf."""

import numpy as np

from foreign.sample import Sample, partition, read_map

WIDE, HIGH, STEP = 24, 12, 0.5  # µm
ROWS = [(i, j, i * STEP, j * STEP) for j in range(HIGH) for i in range(WIDE)]  # column, row, x, y
COLUMNS = sorted(ROWS, key=lambda point: point[:2])
HEX_STEP = STEP * np.sqrt(3) / 2
HEX = [(i, j, i * STEP + (j % 2) * STEP / 2, j * HEX_STEP) for j in range(HIGH) for i in range(WIDE - j % 2)]
ANGLES = [(0.3, 0.2, 0.1), (1.3, 0.7, 0.4), (2.5, 1.2, 0.9), (4.0, 0.4, 1.3)]

ANG = """# TEM_PIXperUM          1.000000
{extra}# Phase 1
# MaterialName  \tAluminum
# Symmetry              43
# LatticeConstants      4.040 4.040 4.040  90.000  90.000  90.000
# NumberFamilies        0
# GRID: {grid}
# XSTEP: {dx:.6f}
# YSTEP: {dy:.6f}
# NCOLS_ODD: {wide}
# NCOLS_EVEN: {even}
# NROWS: {high}
"""
CTF = """Channel Text File
Prj\tx
JobMode\tGrid
XCells\t24
YCells\t12
XStep\t{dx}
YStep\t{dy}
Euler angles refer to Sample Coordinate system (CS0)!\tMag\t100\tCoverage\t100\tDevice\t0\tKV\t20
Phases\t1
4.040;4.040;4.040\t90.000;90.000;90.000\tAluminum\t11\t225
Phase\tX\tY\tBands\tError\tEuler1\tEuler2\tEuler3\tMAD\tBC\tBS
"""
OIM_8 = """# NOTES: Start
# a note: GRID: HexGrid
# XSTEP: 99
# NOTES: End
# COLUMN_COUNT: 10
# COLUMN_HEADERS: phi1, PHI, phi2, x, y, IQ, CI, Phase index, SEM, Fit
# COLUMN_UNITS: radians, radians, radians, microns, microns, , , , , degrees
"""


def grain(column, row):
    return (column >= 10) + 2 * (row >= 5)


def moved(points, x=0, y=0, sign=1):
    return [(i, j, sign * px + x, sign * py + y) for i, j, px, py in points]


def ang(points=ROWS, grid="SqrGrid", dx=STEP, dy=STEP, wide=WIDE, extra=""):
    even = wide - (grid == "HexGrid")
    text = ANG.format(grid=grid, dx=dx, dy=dy, wide=wide, even=even, high=HIGH, extra=extra)
    for i, j, x, y in points:
        angles = "   ".join(f"{angle:.5f}" for angle in ANGLES[grain(i, j)])
        text += f"  {angles}      {x:.5f}      {y:.5f} 1000.0  0.900  1      1  1.000\n"
    return text


def ctf(points=ROWS, dx=STEP, dy=STEP):
    text = CTF.format(dx=dx, dy=dy)
    for i, j, x, y in points:
        angles = "\t".join(f"{angle:.3f}" for angle in np.degrees(ANGLES[grain(i, j)]))
        text += f"1\t{x:.4f}\t{y:.4f}\t8\t0\t{angles}\t0.5\t100\t200\n"
    return text


GRAINS = partition(np.array([[grain(i, j) + 1 for i in range(WIDE)] for j in range(HIGH)]))
SQUARE = {"grains": GRAINS, "pixel": STEP / 1000}
MISSING = {"grains": GRAINS.copy()}
MISSING["grains"][100 // WIDE, 100 % WIDE] = 0


def hexagonal():
    """Square pixels, as wide as rows are apart, take the point whose cell is at their center."""
    grains = np.zeros((HIGH, int((WIDE - 0.5) * STEP / HEX_STEP)), int)
    for j, i in np.ndindex(grains.shape):
        x = (i + 0.5) * HEX_STEP - STEP / 2  # cells begin half a step before the first point
        column = min((p for p in HEX if p[1] == j), key=lambda p: abs(p[2] - x))[0]
        grains[j, i] = grain(column, j) + 1
    return {"grains": partition(grains), "pixel": HEX_STEP / 1000}


def sample(name, content, right=SQUARE):
    return Sample("EBSD map", name, content, right, read_map)


SHUFFLED = [ROWS[k] for k in np.random.default_rng(1).permutation(len(ROWS))]
HEX_COLUMNS = sorted(HEX, key=lambda point: point[2:])
CROPPED = [point for point in ROWS if 3 <= point[0] < 20 and 2 <= point[1] < 11]

SAMPLES = [
    sample("rows.ang", ang()),
    sample("columns.ang", ang(COLUMNS)),
    sample("shuffled.ang", ang(SHUFFLED)),
    sample("oim_8.ang", ang(extra=OIM_8)),
    sample("hash_after_grid.ang", ang(grid="SqrGrid#")),
    sample("cr.ang", ang().replace("\n", "\r")),
    sample("crlf.ang", ang().replace("\n", "\r\n")),
    sample("utf16.ang", ang().encode("utf-16")),
    sample("origin.ang", ang(moved(ROWS, 103.5, 77.25))),
    sample("negative.ang", ang(moved(ROWS, -103.5, -77.25))),
    sample("descending.ang", ang(ROWS[::-1])),
    sample("negative_step.ang", ang(moved(ROWS, sign=-1), dx=-STEP, dy=-STEP),
           {"grains": partition(GRAINS[::-1, ::-1])}),
    sample("hexagonal.ang", ang(HEX, "HexGrid", dy=HEX_STEP), hexagonal()),
    sample("hexagonal_columns.ang", ang(HEX_COLUMNS, "HexGrid", dy=HEX_STEP), hexagonal()),
    sample("missing_point.ang", ang(ROWS[:100] + ROWS[101:]), MISSING),
    sample("no_points.ang", ang([]), "unreadable-file"),
    sample("other_step.ang", ang(dx=2.0, dy=2.0), "malformed-row"),
    sample("twice.ang", ang(ROWS[:100] + ROWS[99:100] + ROWS[101:]), "malformed-row"),
    sample("cropped.ang", ang(CROPPED), "unreadable-file"),
    sample("rows.ctf", ctf()),
    sample("columns.ctf", ctf(COLUMNS)),
    sample("crlf.ctf", ctf().replace("\n", "\r\n")),
    sample("decimal_commas.ctf", ctf().replace(".", ",").replace("\n", "\r\n")),
    sample("decimal_commas_utf16.ctf", ctf().replace(".", ",").encode("utf-16")),
    sample("negative.ctf", ctf(moved(ROWS, -103.5, -77.25))),
    sample("hexagonal.ctf", ctf(HEX, dy=HEX_STEP), hexagonal()),
    sample("other_step.ctf", ctf(dx=2, dy=2), "malformed-row"),
]
