// Rasterizes plane sections of a mesh, many per draw.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nodes/common/gl/egl_context.h"
#include "nodes/data/linear.h"
#include "nodes/data/shapes.h"

namespace terrazzo::kmatrix {

struct SlicePlane {
  Quat rotation;  // the plane z = depth cuts the rotated body
  double depth;   // mm from the mesh's origin
};

// Jagnow et al. 2004, section 3.2: the near plane of an orthographic camera cuts the body, and the
// stencil buffer counts the remaining surfaces behind each pixel; an odd count means inside. Each
// plane is one instance of a draw and has its own tile of one large stencil buffer. Use only on the
// thread that created it.
class StencilSlicer {
 public:
  static constexpr int kTile = 256;                    // pixels per side
  static constexpr int kColumns = 8;                   // tiles per side of the buffer
  static constexpr int kSlices = kColumns * kColumns;  // slices per draw
  // Throws Error "no-gl".
  StencilSlicer(const Mesh&, GlDevice);
  ~StencilSlicer();

  // Draws at most kSlices planes. Pixel (x, y) of slice s is bit x % 32 of row(s, y)[x / 32]: 1 inside. Valid
  // until the next call.
  void draw(const std::vector<SlicePlane>&);
  const std::uint32_t* row(int slice, int y) const;
  double pixel_area() const { return pixel_area_; }  // mm²
  const std::string& renderer() const;

 private:
  struct Gl;
  std::unique_ptr<Gl> gl_;
  std::vector<std::uint32_t> bits_;
  double pixel_area_ = 0;
};

}  // namespace terrazzo::kmatrix
