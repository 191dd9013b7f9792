// Values as comma-separated text (RFC 4180, lines end with '\n', header first). Numbers are written as the
// shortest text that reads back to the same value.
#pragma once

#include <string>

#include "nodes/data/image.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

std::string csv_of(const Table&);
// What a picture adds to a table of its profiles.
struct ProfilePicture {
  double pixel_size = 0;  // mm; 0: unknown
  const Image* image = nullptr;
};
// section, class, area (mm²), centroid_x, centroid_y (mm), touches_border (0, 1), weight, confidence (0 to
// 1), color_r, color_g, color_b, the columns of profile_columns (mm, degrees); areas and lengths in pixels
// (area_px); mean_r, mean_g, mean_b of the image; map_x, map_y of the centroid if it is georeferenced.
// Unknown cells are empty.
std::string csv_of(const Profiles&, const ProfilePicture& = {}, const Work& = {});
// id, shape, class, x, y, z (mm), qw, qx, qy, qz, scale, size (mm), color_r, color_g, color_b, void (0, 1),
// and with shapes, equivalent_diameter (mm): of the sphere of the same volume. Throws Error "no-such-shape".
std::string csv_of(const Particles&, const Shapes* = nullptr);
// shape, class, size_low, size_high (mm), N_V, low, high (per mm³); one row per shape and size class
std::string csv_of(const SizeDistribution&);
// shape, profile_class, size_1 … size_n; one line per row of K; classes count from 1
std::string csv_of(const KMatrix&);
// name, probability, vertices, triangles, volume (mm³), surface_area (mm²), mean_caliper (mm),
// max_section_area (mm²)
std::string csv_of(const Shapes&);

}  // namespace terrazzo::exporting
