"""Tables of measured profiles: headers with units, encodings, separators and rows of statistics."""

import numpy as np

from foreign.sample import Sample, read_areas

AREAS = np.linspace(10, 400, 40)  # the same numbers in each table; units differ
MM2, UM2 = {"mm2": AREAS}, {"mm2": AREAS * 1e-6}


def table(header, row="{area}", end="", separator="\n"):
    rows = [row.format(number=k + 1, area=area) for k, area in enumerate(AREAS)]
    return separator.join([header, *rows, *([end] if end else [])]) + separator


def with_commas(text):
    return text.replace(".", ",")


def sample(name, content, right, **parameters):
    return Sample("table", name, content, right, read_areas, parameters, 1e-15)


IMAGEJ = "Mean,205,1\nSD,116,0\nMin,10,1\nMax,400,1"
WORDS = "Average,205\nStd Dev,116\nTotal,8200\nMedian,205"
DIAMETERS = {"mm2": np.pi / 4 * (AREAS * 1e-6) ** 2}

SAMPLES = [
    sample("micrometers.csv", table("Label,Area (µm²)", "{number},{area}"), UM2),
    sample("one_column.csv", table("area_um2"), UM2),
    sample("latin_1.csv", table("Area [µm²]").encode("latin-1"), UM2),
    sample("greek_mu.csv", table("Area (μm^2)"), UM2),
    sample("square_mm.csv", table("Area [mm^2],Feret", "{area},1"), MM2),
    sample("diameters.tsv", table("Equivalent Diameter (nm)\tx", "{area}\t2"), DIAMETERS),
    sample("utf16_le.csv", table("Area").encode("utf-16"), MM2),
    sample("utf16_be.csv", b"\xfe\xff" + table("Area").encode("utf-16-be"), MM2),
    sample("utf8_bom.csv", b"\xef\xbb\xbf" + table("Area").encode(), MM2),
    sample("cr.csv", table("Area", separator="\r"), MM2),
    sample("crlf.csv", table("Area", separator="\r\n"), MM2),
    sample("decimal_commas.csv", with_commas(table("Area;Mean", "{area};2.5")), MM2),
    sample("decimal_commas.tsv", with_commas(table("Area\tMean", "{area}\t2.5")), MM2),
    sample("decimal_commas_utf16.tsv", with_commas(table("Area\tMean", "{area}\t2.5")).encode("utf-16"), MM2),
    sample("decimal_commas_one_column.csv", with_commas(table("Area")), MM2),
    sample("quoted.csv", table('"No.","Area (µm²)"', '"{number}","{area}"'), UM2),
    sample("quoted_commas.csv", with_commas(table('"No";"Area (µm²)"', '"{number}";"{area}"')), UM2),
    sample("quoted_separator.csv", table("Label,Area", '"grain, {number}",{area}'), MM2),
    sample("exponents.csv", table("Area", "{area:.6E}"), MM2),
    sample("blank_lines.csv", table("Area") + "\n\n", MM2),
    sample("imagej.csv", table(" ,Area,Mean", "{number},{area},1", IMAGEJ), MM2),
    sample("words.csv", table("Name,Area", "g{number},{area}", WORDS), MM2),
    sample("pixels.csv", table("Area (px)"), "unknown-unit"),
    sample("other_unit.csv", table("Area (µm²)"), "contradicting-unit", unit="mm"),
    sample("no_column.csv", table("Particle Area"), "no-column"),
    sample("text.csv", table("Area", end="n/a"), "malformed-row"),
    sample("negative.csv", table("Area", end="-4"), "malformed-row"),
]
