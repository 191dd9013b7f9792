// What terrazzo_gpu measures: each path that has a shader, on the device and on the processor.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "nodes/common/gl/egl_context.h"

namespace terrazzo::gpu {

struct Options {
  GlDevice device = GlDevice::Gpu;
  bool quick = false;  // small inputs and single runs, to test the program itself
  int repeats = 3;     // after one run to warm up
  int most = 512;      // voxels along an edge
};

// Seconds of a call.
inline double seconds_of(const std::function<void()>& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Seconds of each of the repeated calls.
inline std::vector<double> repeated(const Options& o, const std::function<void()>& call) {
  if (!o.quick) call();
  std::vector<double> seconds;
  for (int i = 0; i < (o.quick ? 1 : o.repeats); ++i) seconds.push_back(seconds_of(call));
  return seconds;
}

double median(std::vector<double> values);

// Tells one line, and collects the same as JSON.
using Tell = std::function<void(const std::string& line, const nlohmann::json& entry)>;

// K of an ellipsoid of 5,120 triangles from planes through the stencil buffer. The error is the largest of
// the shares of ten classes, against the closed form.
void measure_slices(const Options&, const Tell&);
// One turn of 36 frames about a scan, plain and with three textures.
void measure_volumes(const Options&, const Tell&);
// Blockwise solids, and the share of voxels that differ from the processor's.
void measure_solids(const Options&, const Tell&);

}  // namespace terrazzo::gpu
