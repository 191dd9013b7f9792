// The programs of the blockwise passes, and their tables on the device.
#pragma once

#include <array>
#include <vector>

#include "nodes/common/gl/gl_compute.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/blockwise/gl.h"

namespace terrazzo::solids {

struct BlockGl::Gl : GlCompute {
  GLuint search = 0, weigh = 0, blend = 0, map = 0, copy = 0, count = 0, finish = 0;

  explicit Gl(GlDevice device)
      : GlCompute(device,
                  {"the part", "cut the solid into more blocks, or set device: cpu", "set device: cpu"}) {}
};

// All tables of the three lines in one buffer, and where each begins.
struct BlockGl::LineTables {
  std::vector<int> numbers;
  std::array<int, 3> starts{}, covers{}, voxels{}, patches{};

  explicit LineTables(const TorusLines& lines) {
    for (std::size_t a = 0; a < 3; ++a) {
      const TorusLine& l = lines[a];
      const auto here = [&] { return count_of(numbers); };
      starts[a] = here();
      numbers.insert(numbers.end(), l.start.begin(), l.start.end());
      covers[a] = here();
      for (const PatchCover& c : l.cover) {
        numbers.push_back(c.patch[0]);
        numbers.push_back(c.count);
      }
      voxels[a] = here();
      for (int k = 0; k < l.to - l.from; ++k) numbers.push_back(l.original_voxel(k));
      patches[a] = here();
      for (int k = 0; k < l.patches(); ++k) numbers.push_back(l.original_patch(k));
    }
  }
};

// The search's tables for one exemplar.
struct BlockGl::ExemplarBuffers {
  GlBuffer features, similar, model;
  int bias_at, penalty_at;

  ExemplarBuffers(Gl& gl, const ExemplarLevel& e, const std::vector<float>& penalty)
      : features(gl), similar(gl), model(gl) {
    features.fill(e.features);
    similar.fill(e.similar);
    std::vector<float> m(e.space.basis.begin(), e.space.basis.end());
    bias_at = m.size();
    for (const float b : e.space.bias) m.push_back(-b);
    penalty_at = m.size();
    for (std::size_t i = 0; i < penalty.size(); ++i) m.push_back(e.usable[i] ? penalty[i] : 0.0f);
    model.fill(m);
  }
};

}  // namespace terrazzo::solids
