"""Volumes of numbers: NumPy, NRRD, MetaImage, MRC, NIfTI, VTK image data and DREAM3D."""

import base64
import bz2
import gzip
import io
import struct
import zlib

import numpy as np
import pytest

from foreign.sample import RAMP, RAMP_BYTES, Sample, read_volume


def sample(kind, name, content, right, **parameters):
    if not isinstance(right, (dict, str)):
        right = {"voxels": right}
    return Sample(kind, name, content, right, read_volume, parameters)


def npy(array, version=None):
    out = io.BytesIO()
    np.lib.format.write_array(out, array, version)
    return out.getvalue()


def npy_header(shape):
    """A file with a shape that NumPy itself does not write."""
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + bytes(32)


IDS = np.full((4, 4, 4), -1)
IDS[1:3, 1:3, 1:3] = 20_000_001
IDS[0, 0, 0] = 20_000_002
BEYOND = np.zeros((3, 3, 3), np.uint64)
BEYOND[1, 1, 1] = 2**53 + 1
FIELDS = np.zeros((4, 5, 6), [("a", "<f4"), ("b", "<i4")])
COMPLEX = RAMP.astype(np.complex64)


def numpy_array(name, content, right=RAMP, **parameters):
    content = npy(content) if isinstance(content, np.ndarray) else content
    return sample("NumPy array", name, content, right, spacing=1, **parameters)


NUMPY = [
    numpy_array("float16.npy", RAMP.astype(np.float16)),
    numpy_array("big_endian.npy", RAMP.astype(">i4")),
    numpy_array("big_endian_float64.npy", RAMP.astype(">f8")),
    numpy_array("fortran.npy", np.asfortranarray(RAMP)),
    numpy_array("int64.npy", RAMP.astype(np.int64)),
    numpy_array("version_2.npy", npy(RAMP, (2, 0))),
    numpy_array("version_3.npy", npy(RAMP, (3, 0))),
    numpy_array("bool.npy", RAMP > 200, RAMP > 200),
    numpy_array("ids.npy", IDS, {"voxels": IDS, "grid": "id"}, grid="id"),
    numpy_array("beyond_float.npy", BEYOND, "bad-values"),
    numpy_array("nan.npy", np.full((2, 2, 2), np.nan), "bad-values"),
    numpy_array("fields.npy", FIELDS, "unreadable-volume"),
    numpy_array("complex.npy", COMPLEX, "unreadable-volume"),
    numpy_array("two_axes.npy", RAMP[0], "not-a-volume"),
    numpy_array("negative.npy", npy_header("(-2, -2, 2)"), "unreadable-volume"),
    numpy_array("exponent.npy", npy_header("(2e0, 2, 2)"), "unreadable-volume"),
    numpy_array("huge.npy", npy_header("(99999999999, 2, 2)"), "unreadable-volume"),
    numpy_array("truncated.npy", npy(RAMP)[:-4], "unreadable-volume"),
]

LPS = "space: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,2)"
IN_MM = [0.5, 0.5, 2]
FLIPPED = {"voxels": RAMP[::-1, ::-1], "spacing": IN_MM}  # to x on the right and y to the front


NRRD_HEADER = """NRRD0005
# a comment
type: {kind}
dimension: {dimension}
sizes: {sizes}
{space}
endian: {endian}
encoding: {encoding}
key:=value
{extra}
"""


def nrrd(data=RAMP_BYTES, sizes="4 5 6", kind="float", encoding="raw", endian="little", space=LPS, extra=""):
    header = NRRD_HEADER.format(kind=kind, dimension=len(sizes.split()), sizes=sizes, space=space,
                                endian=endian, encoding=encoding, extra=extra)
    return header.encode() + data


def nrrd_with_data(path):
    path.with_suffix(".raw").write_bytes(RAMP_BYTES)
    path.write_bytes(nrrd(b"", extra=f"data file: {path.stem}.raw\n"))


def nrrd_sample(name, content, right=FLIPPED):
    return sample("NRRD", name, content, right)


BIG_SHORTS, DOUBLES = RAMP.T.astype(">i2").tobytes(), RAMP.T.astype("<f8").tobytes()
WORDS = " ".join(f"{number:g}" for number in RAMP.T.ravel()).encode()
# The fastest axis of the file is the patient's z.
Z_FIRST = "space: right-anterior-superior\nspace directions: (0,0,2) (0.5,0,0) (0,0.5,0)"
MICROMETERS = """space dimension: 3
space units: "um" "um" "um"
space directions: (500,0,0) (0,500,0) (0,0,2000)"""
UNITS = 'spacings: 0.5 0.5 2\nunits: "cm" "cm" "cm"'
COMPONENTS = LPS.replace("s: (", "s: none (")
TILTED = "space: RAS\nspace directions: (0.4,0.3,0) (-0.3,0.4,0) (0,0,2)"

NRRD = [
    nrrd_sample("raw.nrrd", nrrd()),
    nrrd_sample("gzip.nrrd", nrrd(gzip.compress(RAMP_BYTES), encoding="gzip")),
    nrrd_sample("ascii.nrrd", nrrd(WORDS, encoding="ascii")),
    nrrd_sample("txt.nrrd", nrrd(WORDS.replace(b" ", b"\r\n"), encoding="txt")),
    nrrd_sample("big_endian.nrrd", nrrd(BIG_SHORTS, kind="short", endian="big")),
    nrrd_sample("double.nrrd", nrrd(DOUBLES, kind="double")),
    nrrd_sample("crlf.nrrd", nrrd(b"").replace(b"\n", b"\r\n") + RAMP_BYTES),
    nrrd_sample("detached.nhdr", nrrd_with_data),
    nrrd_sample("byte_skip.nrrd", nrrd(bytes(7) + RAMP_BYTES, extra="byte skip: -1\n")),
    nrrd_sample("micrometers.nrrd", nrrd(space=MICROMETERS), {"voxels": RAMP, "spacing": IN_MM}),
    nrrd_sample("centimeters.nrrd", nrrd(space=UNITS), {"voxels": RAMP, "spacing": [5, 5, 20]}),
    nrrd_sample("z_first.nrrd", nrrd(RAMP.transpose(1, 0, 2).tobytes(), "6 4 5", space=Z_FIRST),
                {"voxels": RAMP, "spacing": IN_MM}),
    nrrd_sample("one_component.nrrd", nrrd(sizes="1 4 5 6", space=COMPONENTS)),
    nrrd_sample("tilted.nrrd", nrrd(space=TILTED), {"voxels": RAMP}),
    nrrd_sample("colors.nrrd", nrrd(sizes="3 4 5 2", space=COMPONENTS), "not-a-volume"),
    nrrd_sample("hex.nrrd", nrrd(RAMP_BYTES.hex().encode(), encoding="hex"), "unreadable-volume"),
    nrrd_sample("bzip2.nrrd", nrrd(bz2.compress(RAMP_BYTES), encoding="bzip2"), "unreadable-volume"),
    nrrd_sample("block.nrrd", nrrd(kind="block"), "unreadable-volume"),
]

META = """ObjectType = Image
NDims = 3
BinaryData = True
BinaryDataByteOrderMSB = {msb}
CompressedData = {packed}
TransformMatrix = 1 0 0 0 1 0 0 0 1
Offset = 0 0 0
{extra}ElementSpacing = 0.5 0.5 2
DimSize = 4 5 6
ElementType = MET_{kind}
ElementDataFile = {file}
"""
UNFLIPPED = {"voxels": RAMP, "spacing": IN_MM}


def meta(data=RAMP_BYTES, kind="FLOAT", msb=False, packed=False, file="LOCAL", extra=""):
    return META.format(kind=kind, msb=msb, packed=packed, file=file, extra=extra).encode() + data


def meta_with_data(path):
    path.with_suffix(".raw").write_bytes(RAMP_BYTES)
    path.write_bytes(meta(b"", file=f"{path.stem}.raw"))


def meta_sample(name, content, right=UNFLIPPED):
    return sample("MetaImage", name, content, right)


METAIMAGE = [
    meta_sample("float.mha", meta()),
    meta_sample("double.mha", meta(DOUBLES, "DOUBLE")),
    meta_sample("packed.mha", meta(zlib.compress(RAMP_BYTES), packed=True)),
    meta_sample("big_endian.mha", meta(BIG_SHORTS, "SHORT", msb=True)),
    meta_sample("text.mha", meta(WORDS).replace(b"BinaryData = True", b"BinaryData = False")),
    meta_sample("crlf.mha", meta(b"").replace(b"\n", b"\r\n") + RAMP_BYTES),
    meta_sample("beside.mhd", meta_with_data),
    meta_sample("rai.mha", meta(extra="AnatomicalOrientation = RAI\n"), FLIPPED),
    meta_sample("channels.mha", meta(RAMP_BYTES * 3, extra="ElementNumberOfChannels = 3\n"), "not-a-volume"),
    meta_sample("missing.mhd", meta(b"", file="elsewhere.raw"), "unreadable-file"),
]


def mrc(mode, type_, order="<", axes=(1, 2, 3), data=None):
    """A map whose voxels are 0.5 by 0.5 by 2 mm."""
    stored = (data if data is not None else RAMP.T).astype(order + type_)
    header = struct.pack(order + "10i6f3i", *stored.shape[::-1], mode, 0, 0, 0, 4, 5, 6,
                         4 * 5e6, 5 * 5e6, 6 * 2e7, 90, 90, 90, *axes)
    stamp = b"\x44\x44\0\0" if order == "<" else b"\x11\x11\0\0"
    return header.ljust(208, b"\0") + b"MAP " + stamp + bytes(1024 - 216) + stored.tobytes()


def mrcfile_map(path):
    mrcfile = pytest.importorskip("mrcfile")
    with mrcfile.new(path) as file:
        file.set_data(np.ascontiguousarray(RAMP.T).astype(np.int16))
        file.voxel_size = (5e6, 5e6, 2e7)


LOW = RAMP % 100
MRC = [sample("MRC map", name, content, {"voxels": voxels, "spacing": IN_MM}) for name, content, voxels in [
    ("int8.mrc", mrc(0, "i1", data=LOW.T), LOW),
    ("int16.mrc", mrc(1, "i2"), RAMP),
    ("float32.mrc", mrc(2, "f4"), RAMP),
    ("uint16.mrc", mrc(6, "u2"), RAMP),
    ("float16.mrc", mrc(12, "f2"), RAMP),
    ("big_endian.map", mrc(2, "f4", ">"), RAMP),
    ("z_first.map", mrc(2, "f4", axes=(3, 1, 2), data=RAMP.transpose(1, 0, 2)), RAMP),
    ("mrcfile.mrc", mrcfile_map, RAMP),
]] + [sample("MRC map", "complex.mrc", mrc(4, "c8"), "not-a-volume")]


def nifti(data=None, datatype=16, order="<", slope=0, intercept=0, units=2, spacing=IN_MM, left=False):
    data = RAMP.T.astype(order + "f4").tobytes() if data is None else data
    header = struct.pack(order + "i36x8h14xhhh8f4f", 348, 3, 4, 5, 6, 1, 1, 1, 1, datatype, 8, 0,
                         1, *spacing, 0, 0, 0, 0, 352, slope, intercept, 0)
    header = header[:123] + bytes([units]) + bytes(128)
    x = -spacing[0] if left else spacing[0]
    rows = (x, 0, 0, 0, 0, spacing[1], 0, 0, 0, 0, spacing[2], 0)
    place = struct.pack(order + "hh6f12f", 0, 1, 0, 0, 0, 0, 0, 0, *rows)
    return header[:252].ljust(252, b"\0") + place + bytes(16) + b"n+1\0" + bytes(4) + data


SHORTS = RAMP.T.astype("<i2").tobytes()
NIFTI = [sample("NIfTI", name, content, {"voxels": voxels, "spacing": IN_MM}) for name, content, voxels in [
    ("float.nii", nifti(), RAMP),
    ("packed.nii.gz", gzip.compress(nifti()), RAMP),
    ("big_endian.nii", nifti(order=">"), RAMP),
    ("scaled.nii", nifti(SHORTS, 4, slope=2, intercept=-1000), RAMP * 2 - 1000),
    ("left.nii", nifti(left=True), RAMP[::-1]),
    ("micrometers.nii", nifti(units=3, spacing=(500, 500, 2000)), RAMP),
]] + [sample("NIfTI", "colors.nii", nifti(bytes(3 * 120), 128), "not-a-volume")]


def vti(body, form="binary", attributes="", cells="CellData", order="LittleEndian", kind="Float32"):
    return f"""<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="{order}" {attributes}>
<ImageData WholeExtent="0 4 0 5 0 6" Origin="0 0 0" Spacing="0.0005 0.0005 0.002"><Piece Extent="0 4 0 5 0 6">
<{cells}><DataArray type="{kind}" Name="density" format="{form}">
{body}
</DataArray></{cells}></Piece></ImageData></VTKFile>
"""


def in_base64(*parts):
    """Each part is encoded by itself, as some writers do with the header."""
    return "".join(base64.b64encode(part).decode() for part in parts)


LENGTH = struct.pack("<I", len(RAMP_BYTES))
PACKED = zlib.compress(RAMP_BYTES)
BLOCKS = struct.pack("<4Q", 1, len(RAMP_BYTES), 0, len(PACKED))
ZLIB = 'header_type="UInt64" compressor="vtkZLibDataCompressor"'
BIG = struct.pack(">I", len(RAMP_BYTES)) + RAMP.T.astype(">f4").tobytes()
VTI = [sample("VTK image data", name, content, right) for name, content, right in [
    ("header_apart.vti", vti(in_base64(LENGTH, RAMP_BYTES), attributes='header_type="UInt32"'), UNFLIPPED),
    ("header_joined.vti", vti(in_base64(LENGTH + RAMP_BYTES), attributes='header_type="UInt32"'), UNFLIPPED),
    ("zlib.vti", vti(in_base64(BLOCKS, PACKED), attributes=ZLIB), UNFLIPPED),
    ("ascii.vti", vti(WORDS.decode(), "ascii"), UNFLIPPED),
    ("big_endian.vti", vti(in_base64(BIG), order="BigEndian"), UNFLIPPED),
    ("lz4.vti", vti(in_base64(BLOCKS, PACKED), attributes=ZLIB.replace("ZLib", "LZ4")), "unreadable-volume"),
    ("points.vti", vti(WORDS.decode(), "ascii", cells="PointData"), "not-a-volume"),
]]


def dream3d(type_="<f4", group="DataContainers/Image", **options):
    def write(path):
        h5py = pytest.importorskip("h5py")
        latest = options.pop("latest", False)
        with h5py.File(path, "w", libver="latest" if latest else "earliest") as file:
            geometry = file.create_group(group + "/_SIMPL_GEOMETRY")
            geometry["DIMENSIONS"] = np.array([4, 5, 6], "<u8")
            geometry["SPACING"] = np.array([500, 500, 2000], "<f4")
            voxels = RAMP.T[..., None].astype(type_)
            file.create_dataset(group + "/CellData/density", data=voxels, **options)
    return write


DREAM3D = [sample("DREAM3D (HDF5)", name, content, right) for name, content, right in [
    ("plain.dream3d", dream3d(), UNFLIPPED),
    ("latest.dream3d", dream3d(latest=True), UNFLIPPED),
    ("big_endian.dream3d", dream3d(">i2"), UNFLIPPED),
    ("double.dream3d", dream3d("<f8", chunks=(2, 2, 2, 1)), UNFLIPPED),
    ("packed.dream3d", dream3d(chunks=(2, 3, 3, 1), compression="gzip", shuffle=True), UNFLIPPED),
    ("checked.dream3d", dream3d(">f4", chunks=(2, 3, 3, 1), fletcher32=True, latest=True), UNFLIPPED),
    ("lzf.dream3d", dream3d(chunks=(2, 3, 3, 1), compression="lzf"), "unreadable-volume"),
    ("other.h5", dream3d(group="entry"), "not-a-volume"),
]]

SAMPLES = NUMPY + NRRD + METAIMAGE + MRC + NIFTI + VTI + DREAM3D
