#include "nodes/bodies/render_solid/render.h"

#include <algorithm>
#include <cmath>

#include "nodes/bodies/render_solid/sampler.h"

namespace terrazzo::render_solid {

using carving::SurfacePoint;

namespace {

constexpr float kLift = 2e-4f;  // world units by which a ray starts above its surface
constexpr std::uint64_t kPaths = 0x70617468;

class Paths {
 public:
  Paths(const Solid& solid, const Studio& studio, const RenderOptions& settings)
      : solid_(solid), studio_(studio), settings_(settings), bounds_(solid.bounds()) {}

  // Light paths `from` to `to` of the pixel start where the ray ends.
  Vec3f from_camera(const Vec3f& origin, const Vec3f& direction, PixelSampler& random, int from,
                    int to) const {
    const auto mean = [&](const auto& light_of_path) {
      Vec3f sum = Vec3f::Zero();
      for (int path = from; path < to; ++path) {
        random.start(path);
        sum += light_of_path();
      }
      return Vec3f(sum / static_cast<float>(to - from));
    };
    SurfacePoint s;
    if (may_meet_solid(origin, direction) && solid_.nearest(origin, direction, s, true))
      return glossy(s, direction, mean([&] { return light(s, random, 0); }));
    const float background = studio_.settings().background;
    Vec3f floor;
    if (!meets_floor(origin, direction, floor)) return Vec3f::Constant(background);
    Vec3f light = background * mean([&] { return floor_light(floor, random, 0); });
    if (settings_.gloss > 0) {
      // The floor reflects the solid a little; where it would reflect the dome it already is the background.
      const Vec3f up(direction.x(), direction.y(), -direction.z());
      const float f = settings_.gloss * fresnel(-direction.z());
      if (may_meet_solid(floor, up) && solid_.nearest(floor + Vec3f(0, 0, kLift), up, s))
        light += f * (s.albedo * studio_.irradiance(s.normal) - Vec3f::Constant(studio_.mirrored(up)));
    }
    return light.cwiseMax(0.0f);
  }

 private:
  static float fresnel(float cosine) {  // Schlick, for a refractive index of 1.5
    const float m = std::clamp(1 - cosine, 0.0f, 1.0f);
    return 0.04f + 0.96f * m * m * m * m * m;
  }

  bool meets_floor(const Vec3f& origin, const Vec3f& direction, Vec3f& point) const {
    if (!studio_.settings().has_floor || direction.z() >= -1e-6f) return false;
    point = origin - direction * (origin.z() / direction.z());
    point.z() = 0;
    return true;
  }

  // Far from the solid the floor is practically unshadowed.
  bool near_solid(const Vec3f& floor) const { return bounds_.squaredExteriorDistance(floor) < 9; }

  bool may_meet_solid(const Vec3f& origin, const Vec3f& direction) const {
    float from = 0, to = 1e30f;
    for (int k = 0; k < 3; ++k) {
      const float inverse = 1 / direction[k];
      const float a = (bounds_.min()[k] - origin[k]) * inverse, b = (bounds_.max()[k] - origin[k]) * inverse;
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    return from <= to * 1.0001f + 1e-4f;
  }

  Vec3f glossy(const SurfacePoint& s, const Vec3f& direction, const Vec3f& light) const {
    const Vec3f diffuse = s.albedo.cwiseProduct(light);
    if (settings_.gloss <= 0) return diffuse;
    const Vec3f mirror = direction - 2 * direction.dot(s.normal) * s.normal;
    const float f = settings_.gloss * fresnel(-direction.dot(s.normal));
    Vec3f seen;
    SurfacePoint other;
    const Vec3f origin = s.position + kLift * s.face;
    if (!s.open && mirror.dot(s.face) > 0 && solid_.nearest(origin, mirror, other))
      seen = 0.7f * other.albedo *
             studio_.irradiance(other.normal);  // inner faces see each other: partly in shade
    else
      seen = Vec3f::Constant(studio_.mirrored(mirror));
    return (1 - f) * diffuse + f * seen;
  }

  // Irradiance over π: that of an open surface, minus the lamp if it is hidden, plus the change made by other
  // surfaces.
  Vec3f light(const SurfacePoint& s, PixelSampler& random, int depth) const {
    Vec3f sum = Vec3f::Constant(studio_.irradiance(s.normal));
    const Vec3f origin = s.position + kLift * s.face;
    float u, v;
    if (!s.open && studio_.lamp() > 0) {
      random.next(u, v);
      const Vec3f d = studio_.to_lamp(u, v);
      const float cosine = s.normal.dot(d);
      if (cosine > 0 && s.face.dot(d) > 0 && solid_.any(origin, d)) sum.array() -= studio_.lamp() * cosine;
    }
    if (depth >= settings_.bounces) return sum.cwiseMax(0.0f);
    random.next(u, v);
    const Vec3f d = cosine_direction(s.normal, u, v);
    if (s.face.dot(d) <= 0) return sum;
    SurfacePoint next;
    Vec3f floor;
    if (!s.open && solid_.nearest(origin, d, next))
      sum += next.albedo.cwiseProduct(light(next, random, depth + 1)) - Vec3f::Constant(studio_.radiance(d));
    else if (meets_floor(origin, d, floor) && near_solid(floor))
      sum += studio_.settings().floor * (floor_light(floor, random, depth + 1) - Vec3f::Ones());
    return sum;
  }

  // The same for the floor, which receives 1 in the open.
  Vec3f floor_light(const Vec3f& point, PixelSampler& random, int depth) const {
    Vec3f sum = Vec3f::Ones();
    if (!near_solid(point)) return sum;
    const Vec3f origin = point + Vec3f(0, 0, kLift);
    float u, v;
    random.next(u, v);
    if (const Vec3f d = studio_.to_lamp(u, v);
        studio_.lamp() > 0 && d.z() > 0 && may_meet_solid(origin, d) && solid_.any(origin, d))
      sum.array() -= studio_.lamp() * d.z();
    random.next(u, v);
    const Vec3f d = cosine_direction(Vec3f::UnitZ(), u, v);
    SurfacePoint next;
    if (!may_meet_solid(origin, d) || !solid_.nearest(origin, d, next)) return sum;
    const Vec3f reflected = depth >= settings_.bounces
                                ? Vec3f(0.5f * next.albedo * studio_.irradiance(next.normal))
                                : Vec3f(next.albedo.cwiseProduct(light(next, random, depth + 1)));
    return sum + reflected - Vec3f::Constant(studio_.radiance(d));
  }

  const Solid& solid_;
  const Studio& studio_;
  const RenderOptions& settings_;
  Eigen::AlignedBox3f bounds_;
};

// A tent filter of radius 1 pixel: smooth edges without blur.
float tent(float u) { return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 - 2 * u); }

}  // namespace

Image render(const Solid& solid, const Studio& studio, const Camera& camera, const RenderOptions& settings,
             const Work& work, const std::function<void(Image)>& refined) {
  Image image(settings.width, settings.height, 1, 1);  // sums, until all rays are followed
  const Paths paths(solid, studio, settings);
  constexpr int kTile = 16;
  const int across = (settings.width + kTile - 1) / kTile, down = (settings.height + kTile - 1) / kTile;
  const auto divide = [](Image& sums, int count) {
    for (Vec3f& pixel : sums.pixels) pixel /= float(count);
  };
  // Color varies less within a pixel than light does, so each ray from the camera starts several light paths.
  const int paths_per_ray = settings.samples % 4 == 0 ? 4 : settings.samples % 2 == 0 ? 2 : 1;
  const int rays = settings.samples / paths_per_ray;
  for (int from = 0; from < rays;) {
    const int to = refined ? std::min(std::max(1, 2 * from), rays) : rays;
    const Work part = work.part(double(from) / rays, double(to) / rays);
    part.parallel(static_cast<std::size_t>(across) * down, 1, [&](std::size_t begin, std::size_t) {
      const int x0 = static_cast<int>(begin) % across * kTile, y0 = static_cast<int>(begin) / across * kTile;
      for (int y = y0; y < std::min(y0 + kTile, settings.height); ++y)
        for (int x = x0; x < std::min(x0 + kTile, settings.width); ++x) {
          work.check();
          const std::size_t pixel = image.index(x, y);
          PixelSampler lens(settings.seed, pixel, static_cast<std::uint32_t>(rays));
          PixelSampler random(settings.seed ^ kPaths, pixel, static_cast<std::uint32_t>(settings.samples));
          Vec3f sum = image.at(x, y);
          for (int i = from; i < to; ++i) {
            lens.start(i);
            float u, v;
            lens.next(u, v);
            const Vec3f d =
                camera.direction(float(x) + 0.5f + 0.75f * tent(u), float(y) + 0.5f + 0.75f * tent(v),
                                 settings.width, settings.height);
            sum += paths.from_camera(camera.position, d, random, paths_per_ray * i, paths_per_ray * (i + 1));
          }
          image.at(x, y) = sum;
        }
    });
    from = to;
    if (refined && from < rays) {
      Image shown = image;
      divide(shown, from);
      refined(std::move(shown));
    }
  }
  divide(image, rays);
  return image;
}

}  // namespace terrazzo::render_solid
