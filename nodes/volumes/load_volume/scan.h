// A scan as stored in files (one number per voxel and the voxel size), and the readers of its formats.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::load_volume {

struct LoadedScan {
  Vec3i size = Vec3i::Zero();
  Vec3 spacing = Vec3::Zero();             // mm; zero if not in the file
  std::vector<float> values;               // stored numbers, x fastest; empty if `whole` has them
  std::vector<std::int32_t> whole;         // stored whole numbers, which floats would round
  std::optional<double> slope, intercept;  // the file's rescale: value = slope · stored + intercept
  bool is_lossy = false;                   // the numbers went through JPEG
  std::vector<std::string> notes;          // warnings for the user

  std::size_t count() const { return whole.empty() ? values.size() : whole.size(); }
  double stored(std::size_t i) const {
    return whole.empty() ? double{values[i]} : static_cast<double>(whole[i]);
  }
};

// A shorter edge of a voxel, in mm, is no size: OpenVDB takes it for zero.
constexpr double kSmallestSpacing = 1e-9;
// Throws Error "bad-spacing" if the voxels are too small for a grid in mm, with what to set instead.
void require_representable(const Vec3& spacing);

// Checks that the scan's size is possible: throws Error "too-large" above 2^31 voxels or if the voxels, their
// reoriented copy and `more` bytes exceed the memory budget, and "empty-volume" if an edge is below 1 voxel.
void require_voxels(const LoadedScan&, const std::string& file, const Reading&, double more = 0);
// The same, and allocates `values`.
void allocate(LoadedScan&, const std::string& file, const Reading&, double more = 0);

// Throws Error "unreadable-volume" if the file is too small for that many bytes of voxels: no compression in
// use exceeds 2000 : 1. This prevents a damaged size from allocating memory.
void check_plausible(double bytes, const std::filesystem::path&);

// Reorders and flips the axes of the array to match the axes of space as closely as possible, without
// resampling. Column k of `axes` is the direction of index k in a space with x to the right, y to the front
// and z to the head. Adds a note if a tilt of more than 1 degree remains.
void align_axes(LoadedScan&, const Mat3& axes);

// Reads NIfTI 1 and 2, compressed or not, through libnifti. read_nifti throws Error "unreadable-volume",
// "not-a-volume" (time series, colors, complex numbers), "too-large". Without a spacing in the file,
// `spacing` stays zero.
bool is_nifti(const std::filesystem::path&);
// The other half of a pair (.hdr and .img, each possibly compressed), which the library opens in addition to
// the named file.
std::vector<std::filesystem::path> nifti_companions(const std::filesystem::path&);
LoadedScan read_nifti(const std::filesystem::path&, const Work& = {}, const Reading& = {});

// Reads a NumPy array [x, y, z] of numbers, in C or Fortran order and either byte order. It contains no
// spacing. Throws Error "unreadable-volume", "not-a-volume" (not three dimensions), "too-large".
bool is_npy(const std::filesystem::path&);
LoadedScan read_npy(const std::filesystem::path&, const Work& = {}, const Reading& = {});

// Reads NRRD (versions 1 to 5) with attached or detached data, raw, ascii or gzip. Throws Error
// "unreadable-volume", "not-a-volume" (not three axes of space), "too-large".
bool is_nrrd(const std::filesystem::path&);
std::vector<std::filesystem::path> nrrd_companions(const std::filesystem::path&);
LoadedScan read_nrrd(const std::filesystem::path&, const Work& = {}, const Reading& = {});

// Reads MetaImage, .mha or .mhd with its data file, raw, compressed or ascii. Throws Error
// "unreadable-volume", "not-a-volume" (not three dimensions, several channels), "too-large".
bool is_metaimage(const std::filesystem::path&);
std::vector<std::filesystem::path> metaimage_companions(const std::filesystem::path&);
LoadedScan read_metaimage(const std::filesystem::path&, const Work& = {}, const Reading& = {});

// Reads MRC 2014 and CCP4 maps. Throws Error "unreadable-volume", "not-a-volume" (a mode of complex numbers,
// a stack of pictures or volumes), "too-large".
bool is_mrc(const std::filesystem::path&);
LoadedScan read_mrc(const std::filesystem::path&, const Work& = {}, const Reading& = {});

// Reads one DICOM series through DCMTK, with one slice per file or all in one file. Slices are sorted by
// position. read_dicom throws Error "unreadable-volume", "mixed-series", "missing-slices", "not-a-volume",
// "too-large".
bool is_dicom(const std::filesystem::path&);
LoadedScan read_dicom(const std::vector<std::filesystem::path>&, const Work& = {}, const Reading& = {});

// Throws Error "unreadable-volume" if the file has a known format that is not read.
void refuse_foreign(const std::filesystem::path&);
// The error of a file that is neither a volume nor a picture, from the error of reading it as a picture.
Error no_volume(const std::filesystem::path&, const Error& picture);

}  // namespace terrazzo::load_volume
