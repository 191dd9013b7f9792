#include "nodes/volumes/render_volume/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::render_volume {
namespace {

Eigen::AlignedBox3f box_of_visible(const ScanField& scan, const DensityIntervals& intervals) {
  std::vector<char> visible(65536);
  for (std::size_t v = 0; v < visible.size(); ++v) {
    const float density = scan.low + scan.step * v;
    const auto k =
        std::upper_bound(intervals.edges.begin(), intervals.edges.end(), density) - intervals.edges.begin();
    visible[v] = intervals.tissue[k] >= 0;
  }
  Eigen::AlignedBox3i box;
  std::size_t i = 0;
  for (int z = 0; z < scan.size.z(); ++z)
    for (int y = 0; y < scan.size.y(); ++y) {
      const std::uint16_t* row = &scan.voxels[i];
      int first = 0, last = scan.size.x() - 1;
      while (first <= last && !visible[row[first]]) ++first;
      while (last > first && !visible[row[last]]) --last;
      if (first <= last) {
        box.extend(Vec3i(first, y, z));
        box.extend(Vec3i(last, y, z));
      }
      i += scan.size.x();
    }
  if (box.isEmpty()) return {Vec3f(Vec3f::Zero()), Vec3f(Vec3f::Ones())};
  const Vec3f n = scan.size.cast<float>();
  return {Vec3f(box.min().cast<float>().cwiseQuotient(n)),
          Vec3f((box.max().cast<float>() + Vec3f::Ones()).cwiseQuotient(n))};
}

}  // namespace

Scene::Scene(ScanField s, std::vector<Tissue> t, std::vector<SolidTexture> x, const Look& l)
    : scan(std::move(s)),
      tissues(std::move(t)),
      intervals(intervals_of(tissues)),
      textures(std::move(x)),
      look(l) {
  seen = box_of_visible(scan, intervals);
  std::vector<std::string> wanting;
  for (const Tissue& tissue : tissues) {
    const bool wants = !textures.empty() && tissue.finish == Finish::Texture;
    texture.push_back(wants ? count_of(wanting) : -1);
    if (wants) wanting.push_back(tissue.name);
  }
  if (wanting.size() > textures.size())
    throw Error(
        "missing-texture",
        fmt::format("class '{}' needs a texture, but only {} of {} textures are connected",
                    wanting[textures.size()], textures.size(), wanting.size()),
        "connect one texture for each class with `texture`, in the order of their ranges, or remove the word")
        .parameter("classes");
  if (wanting.size() < textures.size())
    throw Error("spare-texture",
                fmt::format("{} textures are connected, but only {} classes use one", textures.size(),
                            wanting.size()),
                "disconnect the last texture, or add the word `texture` to its class")
        .parameter("classes");
}

namespace {

// A camera for a box with these half edges around 0, in mm. It is as close as it can be in all frames of a
// turn, so that nothing is cut off and the distance stays constant.
Camera camera_of(const Look& look, const Vec3f& half, float azimuth) {
  constexpr float kDegree = 0.0174532925f, kField = 0.38f, kFill = 0.94f;
  // The axes of the picture's world are those of the scan, rotated so that `up` becomes z.
  const int z = look.up, x = (z + 1) % 3, y = (z + 2) % 3;
  const auto turned = [&](const Vec3f& v) {
    Vec3f out;
    out[x] = v.x();
    out[y] = v.y();
    out[z] = v.z();
    return out;
  };
  const Eigen::AlignedBox3f unit(Vec3f(Vec3f::Constant(-1)), Vec3f(Vec3f::Ones()));
  Camera c = Camera::framing(unit, kDegree * azimuth, kDegree * static_cast<float>(look.elevation),
                             look.width, look.height, kField, kFill);
  const Vec3f box(half[x], half[y], half[z]);
  float distance = 0;
  for (int step = 0; step < 72; ++step)
    for (int k = 0; k < 8; ++k) {
      const Vec3f corner(k & 1 ? box.x() : -box.x(), k & 2 ? box.y() : -box.y(), k & 4 ? box.z() : -box.z());
      const Vec3f v = Eigen::AngleAxisf(kDegree * 5 * step, Vec3f::UnitZ()) * corner;
      distance = std::max({distance, std::abs(v.dot(c.right)) / (kFill * c.half_width) - v.dot(c.forward),
                           std::abs(v.dot(c.up)) / (kFill * c.half_height) - v.dot(c.forward)});
    }
  c.half_width /= static_cast<float>(look.zoom);
  c.half_height /= static_cast<float>(look.zoom);
  c.forward = turned(c.forward);
  c.right = turned(c.right);
  c.up = turned(c.up);
  c.position = -c.forward * distance;
  return c;
}

}  // namespace

Frame frame_of(const Scene& scene, double azimuth) {
  const Look& look = scene.look;
  const ScanField& scan = scene.scan;
  Frame f;
  const Vec3f extent = scan.extent(), n = scan.size.cast<float>();
  f.per_mm = scan.spacing.cwiseInverse();
  f.middle = 0.5f * n + Vec3f::Constant(0.5f);
  for (int k = 0; k < 3; ++k) {
    f.low[k] = 0.5f + n[k] * look.clip[0][k];
    f.high[k] = 0.5f + n[k] * look.clip[1][k];
  }
  // Frame only what is visible within the kept region.
  Eigen::AlignedBox3f kept(look.clip[0], look.clip[1]);
  if (const auto both = kept.intersection(scene.seen); !both.isEmpty()) kept = both;
  const Vec3f half = 0.5f * kept.sizes().cwiseProduct(extent);
  const Vec3f target = (kept.center() - Vec3f::Constant(0.5f)).cwiseProduct(extent);
  f.camera = camera_of(look, half, azimuth);
  const float distance = -f.camera.position.dot(f.camera.forward);
  f.camera.position += target;
  const Vec3f lamp = look.lamp.cast<float>();
  f.light = (lamp.y() * f.camera.up + lamp.x() * f.camera.right - lamp.z() * f.camera.forward).normalized();

  f.step = scan.spacing.minCoeff() * float(look.step);
  f.reference_step = extent.maxCoeff() / 1000;
  const float range = float(look.window.y() - look.window.x());
  f.int_scale = scan.step / range;
  f.int_offset = (scan.low - float(look.window.x())) / range;
  f.soft_gradient = 0.03f * range / scan.step / scan.spacing.minCoeff();
  const float footprint =
      2 * f.camera.half_height / float(look.height) * distance;  // mm per pixel, at the middle
  const double weights = look.weights[0] + look.weights[1] + look.weights[2];
  for (std::size_t i = 0; i < scene.tissues.size(); ++i) {
    const Tissue& t = scene.tissues[i];
    TissueLook l;
    const int texture = scene.texture[i];
    l.color = texture >= 0 ? scene.textures[texture].mean : t.color;
    l.noise = t.finish == Finish::Noise;
    l.by_density = t.opacity < 0;
    l.fixed = t.opacity < 0 ? 0
                            : -std::log(1 - std::min(float(t.opacity), 0.999f)) / f.reference_step *
                                  float(look.opacity);
    l.light_extinction = 1 / float(t.penetration > 0 ? t.penetration : look.penetration);
    l.threshold = (float(t.low) - float(look.window.x())) / range;
    l.modulation = l.noise ? 0 : float(look.modulation);
    if (texture >= 0 && look.textured) {
      l.texture = texture;
      for (int s = 0; s < kScales; ++s) {
        Placement p = placement(scene.textures[texture], look.scales[s], footprint, look.turning, look.seed,
                                i * kScales + s);
        // Convert from mm to positions: texel = linear · spacing · (position − middle) + offset.
        p.linear = p.linear * scan.spacing.asDiagonal();
        p.offset -= p.linear * f.middle;
        l.at[s] = p;
        l.weight[s] = float(look.weights[s] / weights) / 65535;
      }
    }
    f.tissues.push_back(l);
  }
  return f;
}

}  // namespace terrazzo::render_volume
