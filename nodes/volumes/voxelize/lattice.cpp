#include "nodes/volumes/voxelize/lattice.h"

#include <fmt/format.h>

#include <cmath>

#include "graph/diagnostic.h"

namespace terrazzo::voxelize {
namespace {

constexpr double kTolerance = 1e-6;

bool fits(const Vec3& box, double voxel) {
  for (int a = 0; a < 3; ++a) {
    const double n = box[a] / voxel;
    if (std::round(n) < 1 || std::abs(n - std::round(n)) > kTolerance * n) return false;
  }
  return true;
}

std::string advice(const Vec3& box, std::int64_t wanted) {
  for (std::int64_t step = 1; step <= wanted; ++step)
    for (const std::int64_t n : {wanted - step, wanted + step})
      if (n > 0 && fits(box, box.maxCoeff() / n)) return fmt::format("resolution {} fits", n);
  return "choose a box whose edges are small multiples of one length";
}

}  // namespace

Lattice choose_lattice(const Vec3& box, const std::vector<std::int64_t>& resolution) {
  if (!box.allFinite() || box.minCoeff() <= 0)
    throw Error("bad-box",
                fmt::format("the particles' box must have positive edges; it is {:g} × {:g} × {:g} mm",
                            box.x(), box.y(), box.z()),
                "set the size of the packing");
  if (resolution.size() != 1 && resolution.size() != 3)
    throw Error("bad-value", fmt::format("resolution has {} numbers", resolution.size()),
                "set one number or three")
        .parameter("resolution");
  Lattice out;
  if (resolution.size() == 1) {
    out.voxel = box.maxCoeff() / resolution[0];
    if (!fits(box, out.voxel))
      throw Error("uneven-voxels",
                  fmt::format("every edge must be a whole number of voxels; {} voxels along the longest edge "
                              "of a box of {:g} × {:g} × {:g} mm make {:.4g} × {:.4g} × {:.4g}",
                              resolution[0], box.x(), box.y(), box.z(), box.x() / out.voxel,
                              box.y() / out.voxel, box.z() / out.voxel),
                  advice(box, resolution[0]))
          .parameter("resolution");
  } else {
    out.voxel = box.x() / resolution[0];
    for (int a = 1; a < 3; ++a)
      if (std::abs(box[a] / resolution[a] / out.voxel - 1) > kTolerance)
        throw Error("uneven-voxels",
                    fmt::format("voxels must be cubes; they are {:.6g} × {:.6g} × {:.6g} mm", out.voxel,
                                box.y() / resolution[1], box.z() / resolution[2]),
                    "set one number, the voxels along the longest edge")
            .parameter("resolution");
  }
  for (int a = 0; a < 3; ++a) out.size[a] = std::lround(box[a] / out.voxel);
  if (out.size.cast<double>().prod() > 4.1e9)
    throw Error("too-large",
                fmt::format("{} × {} × {} voxels exceed the limit of 4.1·10⁹", out.size.x(), out.size.y(),
                            out.size.z()),
                "lower resolution")
        .parameter("resolution");
  return out;
}

}  // namespace terrazzo::voxelize
