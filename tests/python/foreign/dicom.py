"""DICOM: single slices and enhanced files with many frames, written with pydicom."""

import numpy as np
import pytest

from foreign.sample import Sample, read_volume

STRAIGHT = [1, 0, 0, 0, 1, 0]
CT, ENHANCED_CT = "1.2.840.10008.5.1.4.1.1.2", "1.2.840.10008.5.1.4.1.1.2.1"
EXPLICIT, IMPLICIT = "1.2.840.10008.1.2.1", "1.2.840.10008.1.2"


def frame(z):
    """3 rows of 4 columns, different in each."""
    return np.fromfunction(lambda row, column: column + 10 * row + 100 * z, (3, 4)).astype(np.int16)


def dataset(kind, number, preamble=True):
    pydicom = pytest.importorskip("pydicom")
    meta = pydicom.dataset.FileMetaDataset()
    if preamble:
        meta.MediaStorageSOPClassUID = kind
        meta.MediaStorageSOPInstanceUID = f"1.2.3.{number}"
        meta.TransferSyntaxUID = EXPLICIT
    data = pydicom.dataset.FileDataset("", {}, file_meta=meta, preamble=bytes(128) if preamble else None)
    data.is_little_endian, data.is_implicit_VR = True, not preamble
    data.SOPClassUID, data.SOPInstanceUID = kind, f"1.2.3.{number}"
    data.Modality, data.SeriesInstanceUID = "CT", "1.2.9"
    data.Rows, data.Columns, data.SamplesPerPixel = 3, 4, 1
    data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 1
    data.PhotometricInterpretation = "MONOCHROME2"
    return data


def series(places, names=None, preamble=True, orientation=STRAIGHT, spacing=(1, 1), rescale=None):
    """One file per slice. A place is a distance along the normal of the slices."""
    normal = np.cross(orientation[:3], orientation[3:])

    def write(path):
        for k, z in enumerate(places):
            data = dataset(CT, k + 1, preamble)
            data.PixelSpacing, data.SliceThickness = list(spacing), 2
            data.ImageOrientationPatient = list(orientation)
            data.ImagePositionPatient = [float(v) for v in np.round(z * normal, 6)]
            if rescale:
                data.RescaleSlope, data.RescaleIntercept = rescale
            data.PixelData = frame(z).tobytes()
            data.save_as(path.with_name(names[k] if names else f"{k}.dcm"), write_like_original=not preamble)
    return write


def enhanced(places, step=None):
    """All slices in one file, each with a position of its own."""
    def write(path):
        pydicom = pytest.importorskip("pydicom")

        def group(**fields):
            out = pydicom.dataset.Dataset()
            for name, value in fields.items():
                setattr(out, name, value)
            return pydicom.sequence.Sequence([out])

        data = dataset(ENHANCED_CT, 1)
        data.NumberOfFrames = len(places)
        measures = group(PixelSpacing=[1, 1], SliceThickness=2)
        if step is not None:
            measures[0].SpacingBetweenSlices = step
        data.SharedFunctionalGroupsSequence = group(
            PixelMeasuresSequence=measures,
            PlaneOrientationSequence=group(ImageOrientationPatient=STRAIGHT))
        data.PerFrameFunctionalGroupsSequence = pydicom.sequence.Sequence(
            [group(PlanePositionSequence=group(ImagePositionPatient=[0, 0, z]))[0] for z in places])
        data.PixelData = np.stack([frame(z) for z in places]).tobytes()
        data.save_as(path, write_like_original=False)
    return write


def volume(places, spacing=(1, 1, 2)):
    """Slices in the order of their places. Rows go to the patient's back, columns to the left."""
    return {"voxels": np.stack([frame(z).T[::-1, ::-1] for z in sorted(places)], axis=2), "spacing": spacing}


def turned():
    """The slices of a patient cut from the side: rows go down, columns to the back, slices to the left."""
    slices = np.stack([frame(z) for z in (0, 2, 4)])  # z, row, column
    return {"voxels": np.transpose(slices, (0, 2, 1))[:, ::-1, ::-1], "spacing": [2, 0.5, 1]}


def sample(name, content, right):
    return Sample("DICOM", name, content, right, read_volume)


PLACES = [0, 2, 4, 6]
OBLIQUE = [0.8, 0.6, 0, -0.6, 0.8, 0]
SIDE = [0, 1, 0, 0, 0, -1]  # columns to the back, rows to the feet; the normal points to the right
SCALED = {"voxels": volume(PLACES)["voxels"] * 2.0 - 1000}

SAMPLES = [
    sample("shuffled_frames.dcm", enhanced([4, 0, 8, 2, 6]), volume([0, 2, 4, 6, 8])),
    sample("descending_frames.dcm", enhanced([8, 6, 4, 2, 0]), volume([0, 2, 4, 6, 8])),
    sample("negative_step.dcm", enhanced([0, 2, 4, 6, 8], -2), volume([0, 2, 4, 6, 8])),
    sample("gap.dcm", enhanced([0, 2, 4, 8, 10]), "missing-slices"),
    sample("twice.dcm", enhanced([0, 2, 2, 4, 6]), "missing-slices"),
    sample("IM*", series(PLACES, ["IM1", "IM2", "IM3", "IM4"], preamble=False), volume(PLACES)),
    sample("*.dcm", series([6, 0, 4, 2], ["1.dcm", "2.dcm", "10.dcm", "11.dcm"]), volume(PLACES)),
    sample("?.dcm", series(PLACES, spacing=(0.25, 0.5)), volume(PLACES, (0.5, 0.25, 2))),
    sample("[0-9].dcm", series(PLACES, rescale=(2, -1000)), SCALED),
    sample("[0-8].dcm", series(PLACES, orientation=OBLIQUE), volume(PLACES)),
    sample("[0-7].dcm", series([0, 2, 4], orientation=SIDE, spacing=(1, 0.5)), turned()),
    sample("[0-6].dcm", series([0, 2, 4, 8]), "missing-slices"),
]
