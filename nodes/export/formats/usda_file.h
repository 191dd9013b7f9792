// OpenUSD scenes as text (.usda): particles as one PointInstancer, and optionally a volume stored beside it.
// Lengths in mm (metersPerUnit 0.001), z up, colors scene-linear.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// The OpenVDB file that a scene refers to: its name relative to the scene, and its grids.
struct UsdaVolume {
  std::string file;
  const Volume* volume = nullptr;
};

// The prim /Aggregate/Particles is a PointInstancer with one prototype per shape in use beneath it. Its
// arrays, in particle order without voids: protoIndices, positions, orientations (quath: half precision,
// errors below 0.06 degrees), scales, ids (the particle's index), primvars:displayColor, primvars:class and
// primvars:size (mm), with the interpolation "vertex", one value per instance; and extent. Prototypes have
// subdivisionScheme "none"; smooth shapes have normals. One UsdPreviewSurface takes its color from
// displayColor. With `volume`, /Aggregate/Volume has one OpenVDBAsset per grid and is invisible at first,
// since it fills the same space. With `index`, primvars:particle has it, while ids count, since they must
// differ.
//
// `provenance`: JSON for customLayerData, or empty. Throws the errors of instances_of and render_mesh, Error
// "write-failed".
void write_usda(const std::filesystem::path&, const Particles&, const Shapes&, const UsdaVolume& = {},
                const std::string& provenance = {}, const Work& = {},
                const std::vector<std::int32_t>& index = {});

// Shapes alone: one Mesh each in /Aggregate, all in the same place, with the colors of vertices as
// displayColor (interpolation "vertex") if they have any. Throws Error "no-shapes" and the errors of
// render_mesh.
void write_usda(const std::filesystem::path&, const Shapes&, const UsdaVolume& = {},
                const std::string& provenance = {}, const Work& = {});

}  // namespace terrazzo::exporting
