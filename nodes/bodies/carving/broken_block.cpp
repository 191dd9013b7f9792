#include "nodes/bodies/carving/broken_block.h"

#include <algorithm>

#include "nodes/bodies/carving/particle_index.h"
#include "nodes/common/texture/noise.h"

namespace terrazzo::carving {

BrokenBlock::BrokenBlock(const Particles& particles, const Shapes& shapes, double level, double roughness,
                         std::uint64_t seed)
    : level_(level), roughness_(roughness), seed_(seed) {
  check_shown(particles, shapes);
  const double longest = particles.box.maxCoeff();
  longest_ = longest;
  size_ = (particles.box / longest).cast<float>();
  std::vector<double> radius;
  for (const Shape& s : shapes.shapes) {
    double far = 0;
    for (const Vec3& v : s.mesh.vertices) far = std::max(far, v.norm());
    radius.push_back(far);
  }
  top_ = static_cast<float>(level + 2 * roughness) * size_.z();
  const float highest = static_cast<float>(level + 1.35 * roughness) * size_.z();  // of the face
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const std::uint32_t mesh = particles.shape[i];
    const Mat3 turn = particles.orientation[i].normalized().toRotationMatrix();
    const float r = radius[mesh] * particles.scale[i] / longest;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const Vec3f at =
              (particles.position[i] / longest).cast<float>() + Vec3f(x, y, z).cwiseProduct(size_);
          if ((at.array() + r < 0).any() || (at.array() - r > size_.array()).any()) continue;
          const bool stays = !particles.is_void(i) && at.z() < height(at.x(), at.y());
          if (!stays && at.z() - r > highest) continue;  // removed, and too high to leave a socket
          RayScene::Instance instance;
          instance.mesh = mesh;
          instance.linear = (turn * (particles.scale[i] / longest)).cast<float>();
          instance.offset = at;
          instances_.push_back(instance);
          images_.push_back({i, mesh, turn.cast<float>(), stays});
          if (stays) top_ = std::max(top_, at.z() + r);
        }
  }
}

float BrokenBlock::height(float x, float y) const {
  const Vec3 p(4.0 * x + 0.3, 4.0 * y + 0.7, 0.5);
  return static_cast<float>(level_ + roughness_ * (noise(seed_, p) + 0.35 * noise(seed_ + 1, 5 * p))) *
         size_.z();
}

Shape BrokenBlock::under_the_face() const {
  constexpr int kN = kFaceSteps;
  Shape s;
  s.smooth = true;
  const auto place = [&](int i, float edge) { return double(edge) * (1.1 * i / kN - 0.05); };
  for (int j = 0; j <= kN; ++j)
    for (int i = 0; i <= kN; ++i) {
      const double x = place(i, size_.x()), y = place(j, size_.y());
      s.mesh.vertices.push_back(Vec3(x, y, height(float(x), float(y))));
    }
  for (int j = 0; j < kN; ++j)
    for (int i = 0; i < kN; ++i) {
      const int a = j * (kN + 1) + i;
      s.mesh.triangles.push_back({a, a + 1, a + kN + 2});
      s.mesh.triangles.push_back({a, a + kN + 2, a + kN + 1});
    }
  return s;
}

}  // namespace terrazzo::carving
