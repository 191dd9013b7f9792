// A scan as files hold it: one number a voxel, with its spacing; and the readers of the formats.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "nodes/common/linear.h"
#include "nodes/common/reading.h"
#include "runtime/work.h"

namespace terrazzo::load_volume {

struct LoadedScan {
  Vec3i size = Vec3i::Zero();
  Vec3 spacing = Vec3::Zero();             // mm; zero where the file does not say
  std::vector<float> values;               // stored numbers, x fastest
  std::optional<double> slope, intercept;  // of the file's own rescale: value = slope · stored + intercept
  std::vector<std::string> notes;          // what the user should know
};

// Makes room for the voxels. Throws Error "too-large" above 2^31 voxels or if they, their turned copy and
// `more` bytes exceed the budget, and "empty-volume" if an edge is below 1.
void allocate(LoadedScan&, const std::string& file, const Reading&, double more = 0);

// Whether a file can hold so many bytes of voxels: no compression in use packs better than 2000 to 1. Throws
// Error "unreadable-volume" where not, so that a damaged size asks for no memory.
void check_plausible(double bytes, const std::filesystem::path&);

// Turns the axes of the array to the nearest ones of space, by swaps and flips alone. Column k of `axes`:
// where index k leads, in a space with x to the right, y to the front and z to the head. Notes more than 1
// degree of what is left.
void align_axes(LoadedScan&, const Mat3& axes);

// NIfTI 1 and 2, also compressed, through libnifti. Throws Error "unreadable-volume", "not-a-volume" (time
// series, colours, complex numbers), "no-spacing".
bool is_nifti(const std::filesystem::path&);
// The other half of a pair (.hdr and .img, each also compressed): what the library opens besides the file
// that is named.
std::vector<std::filesystem::path> nifti_companions(const std::filesystem::path&);
LoadedScan read_nifti(const std::filesystem::path&, const Work& = {}, const Reading& = {});

// One DICOM series, a slice a file or all in one, through DCMTK: slices in order of their places. Throws
// Error "unreadable-volume", "mixed-series", "missing-slices", "not-a-volume".
bool is_dicom(const std::filesystem::path&);
LoadedScan read_dicom(const std::vector<std::filesystem::path>&, const Work& = {}, const Reading& = {});

// Grey pictures of one size in the order of their names, or the pages of one file, from below; numbers as
// stored. Throws Error "unreadable-image", "unequal-sections", "not-a-volume" (colours).
LoadedScan read_slices(const std::vector<std::filesystem::path>&, const Work& = {}, const Reading& = {});

}  // namespace terrazzo::load_volume
