// The same ray marching in a shader.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nodes/common/gl/egl_context.h"
#include "nodes/volumes/render_volume/scene.h"

namespace terrazzo::render_volume {

// Holds a scene on a GPU, or in Mesa's software renderer. Must be used on the thread that made it.
class GlMarcher {
 public:
  // Throws Error "no-gl" if there is no such device or it rejects the shader, "too-large-for-gl" if the
  // device cannot hold the volume or a texture, or if there are more than 12 textures.
  GlMarcher(const Scene&, const Bricks&, GlDevice);
  ~GlMarcher();

  // Same as march() except for rounding: the mean difference is below 1/1000.
  std::vector<Vec3f> march(const Frame&, FrameCounts&, const Work& = {});
  // Draws the frame without reading it.
  void draw(const Frame&, const Work& = {});
  const std::string& renderer() const;

 private:
  struct Gl;
  void set(const Frame&);
  void draw_rows(int top, const Work&);
  const Scene& scene_;
  std::unique_ptr<Gl> gl_;
};

}  // namespace terrazzo::render_volume
