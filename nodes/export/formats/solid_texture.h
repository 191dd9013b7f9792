// A periodic volume as a texture: slices in one picture (.png), or a 3D texture (.dds, .ktx2). Texel (i, j,
// k) is voxel (i, j, k): x to the right, y and z from the first row and slice of the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

enum class TexelKind {
  Color,   // RGBA, 8 bits, sRGB-encoded color, linear alpha
  Byte,    // R, 8 bits, 0 to 1
  Half,    // R, half floats
  Halves,  // RGBA, half floats
  Whole,   // R, int32
};

struct SolidTexels {
  TexelKind kind = TexelKind::Color;
  Vec3i size = Vec3i::Zero();
  Vec3 edges = Vec3::Zero();        // of the volume, mm
  bool alpha = false;               // whether alpha is a grid, not 1
  std::vector<std::uint8_t> bytes;  // x fastest, then y, then z
};

// `grids`: one grid, or a vector and a grid of single numbers from 0 to 1 for alpha. The grid Cd becomes
// Color, other vectors Halves, single numbers Half or, in a picture, Byte, whole numbers Whole. A picture
// holds Color and Byte only. Throws Error "format-does-not-fit", "bad-values" (beyond the format's range),
// "unsupported-grid", "too-large" beyond `memory` or 2048 voxels along an edge, and the errors of voxel_box.
SolidTexels solid_texels(const Volume&, const std::vector<std::string>& grids, bool picture,
                         std::uint64_t memory, const Work& = {});

// Columns and rows of slices in a picture: as square as possible, 16 × 16 for 256.
int atlas_columns(int slices);
int atlas_rows(int slices);

// Slice k is in column k mod columns and row k / columns, from the upper left corner, with y downwards. What
// is left over is black. Throws Error "too-large" beyond 16384 pixels along an edge, "write-failed".
void write_slice_atlas(const std::filesystem::path&, const SolidTexels&, const std::string& provenance);

// DirectDraw surface with the header DX10, one level. Throws Error "write-failed".
void write_dds(const std::filesystem::path&, const SolidTexels&);

// Khronos texture 2, one level, without compression. Metadata: KTXorientation, KTXwriter, terrazzo.edges (mm)
// and terrazzo.provenance. Throws Error "write-failed".
void write_ktx2(const std::filesystem::path&, const SolidTexels&, const std::string& provenance);

}  // namespace terrazzo::exporting
