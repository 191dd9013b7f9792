#include "nodes/photograph/segment/color/faint_bodies.h"

#include "nodes/common/geometry/rank.h"

namespace terrazzo::segment {

std::vector<bool> faint_bodies(const Mosaic& m, const std::vector<std::int32_t>& labels, std::int32_t count) {
  constexpr float kDeviations = 6;
  std::vector<Vec3f> sums(count + 1, Vec3f::Zero());
  std::vector<float> pixels(count + 1, 0), axes[3];
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const Vec3f& color = m.colors[m.patches[i] - 1];
    sums[labels[i]] += color;
    ++pixels[labels[i]];
    for (int axis = 0; axis < 3 && labels[i] == 0; ++axis) axes[axis].push_back(color[axis]);
  }
  std::vector<bool> faint(count, false);
  if (axes[0].empty()) return faint;
  Vec3f binder;
  for (int axis = 0; axis < 3; ++axis) binder[axis] = at_rank(axes[axis], axes[axis].size() / 2);
  for (std::int32_t k = 0; k < count; ++k)
    faint[k] = pixels[k + 1] > 0 && (sums[k + 1] / pixels[k + 1] - binder).norm() < kDeviations * m.noise;
  return faint;
}

}  // namespace terrazzo::segment
