// Plane sections of a mesh as pixels, many per draw.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nodes/common/egl_context.h"
#include "nodes/common/linear.h"
#include "nodes/data/shapes.h"

namespace terrazzo {

struct SlicePlane {
  Quat rotation;  // the plane z = depth cuts the body turned by it
  double depth;   // mm from the mesh's origin
};

// Jagnow et al. 2004, section 3.2: an orthographic camera's near plane cuts the body, and the stencil buffer
// counts the surfaces left behind each pixel; where they are odd the pixel lies inside. Each plane gets a
// tile of one large stencil buffer, an instance of one draw. Lives on the thread that made it.
class StencilSlicer {
 public:
  static constexpr int kTile = 256;                    // pixels a side
  static constexpr int kColumns = 8;                   // tiles a side of the buffer
  static constexpr int kSlices = kColumns * kColumns;  // per draw
  // Throws Error "no-gl".
  StencilSlicer(const Mesh&, GlDevice);
  ~StencilSlicer();

  // At most kSlices planes. Pixel (x, y) of slice s is odd() [s][y · kTile + x]: 0 outside, 255 inside. Valid
  // until the next call.
  void draw(const std::vector<SlicePlane>&);
  const std::uint8_t* row(int slice, int y) const;
  double pixel_area() const { return pixel_area_; }  // mm²
  const std::string& renderer() const;

 private:
  struct Gl;
  std::unique_ptr<Gl> gl_;
  std::vector<std::uint8_t> stencil_;
  double pixel_area_ = 0;
};

}  // namespace terrazzo
