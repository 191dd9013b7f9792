#include "nodes/textures/bake/bake_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/carving/particle_index.h"
#include "nodes/bodies/cutting/soften.h"
#include "nodes/bodies/cutting/volume_section.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/volume.h"

namespace terrazzo::bake {
namespace {

using textures::id_color;
using textures::Roughness;

// Rows that a thread takes at once: about 16,384 texels, since rows of small textures are too short.
std::size_t rows_at_once(int size) { return static_cast<std::size_t>(std::max(1, 16384 / size)); }

// Calls visit(texel, x, y, triangle) for every texel of a triangle, on all threads.
template <class Visit>
void each_texel(const UvTexels& texels, const Work& work, const Visit& visit) {
  work.parallel(texels.size, rows_at_once(texels.size), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (int x = 0; x < texels.size; ++x) {
        const int y = static_cast<int>(row);
        const std::size_t at = pixel_at(x, y, texels.size);
        if (texels.triangle[at] >= 0) visit(at, x, y, texels.triangle[at]);
      }
  });
}

BakedMaps blank_maps(int size, const Vec3f& color) {
  BakedMaps out;
  out.base_color = Image(size, size, 1, 1, color);
  out.roughness = Image(size, size, 1, 1);
  out.id = out.roughness;
  out.cover.assign(out.id.pixels.size(), 0.0f);
  return out;
}

class ParticleBaker {
 public:
  ParticleBaker(const UvTexels& texels, const TexelPlaces& places, const Particles& particles,
                const Shapes& shapes, const Roughness& roughness)
      : texels_(texels),
        places_(places),
        particles_(particles),
        roughness_(roughness),
        index_(particles, shapes),
        out_(blank_maps(texels.size, particles.binder_color)),
        owner_(texels.triangle.size(), -1),
        ids_(texels.triangle.size(), -1) {}

  BakedMaps bake(const residual::ResidualField* detail, double softness, const Work& work) {
    take_centers(work.part(0, 0.4));
    average_edges(work.part(0.4, 0.7));
    if (detail) add_detail(*detail, softness, work.part(0.7, 1));
    return std::move(out_);
  }

 private:
  // The particle at a point, and whether the point is on the wall of a void, which counts as binder.
  struct Seen {
    std::int32_t particle = -1;
    bool wall = false;
  };
  Vec3f place(int x, int y, std::int32_t triangle, double right, double down) const {
    return wrap_point(places_.at(triangle, x, y, right, down), particles_.box).cast<float>();
  }
  Seen seen(const Vec3f& mm) const {
    const std::int32_t particle = index_.at(mm);
    if (particle >= 0 && particles_.is_void(particle)) return {-1, true};
    return {particle, false};
  }
  const Vec3f& color(std::int32_t particle) const {
    return particle < 0 ? particles_.binder_color : particles_.color[particle];
  }
  float roughness(const Seen& s) const {
    if (s.wall) return Roughness::kNaturalBinder;
    return static_cast<float>(s.particle < 0 ? roughness_.binder
                                             : roughness_.of_class(particles_.cls[s.particle]));
  }

  void take_centers(const Work& work) {
    each_texel(texels_, work, [&](std::size_t at, int x, int y, std::int32_t triangle) {
      const Seen s = seen(place(x, y, triangle, 0.5, 0.5));
      owner_[at] = ids_[at] = s.particle;
      out_.cover[at] = s.particle < 0 ? 0.0f : 1.0f;
      out_.base_color.pixels[at] = color(s.particle);
      out_.roughness.pixels[at].setConstant(roughness(s));
      out_.id.pixels[at] = id_color(s.particle);
    });
  }

  bool on_edge(int x, int y) const {
    const int n = texels_.size;
    const std::int32_t own = ids_[pixel_at(x, y, n)];
    for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const int i = x + dx, j = y + dy;
      if (i < 0 || j < 0 || i >= n || j >= n) continue;
      const std::size_t at = pixel_at(i, j, n);
      if (texels_.triangle[at] >= 0 && ids_[at] != own) return true;
    }
    return false;
  }

  void average_edges(const Work& work) {
    each_texel(texels_, work, [&](std::size_t at, int x, int y, std::int32_t triangle) {
      if (on_edge(x, y)) average(at, x, y, triangle);
    });
  }

  void average(std::size_t at, int x, int y, std::int32_t triangle) {
    constexpr int kSide = 4, kAll = kSide * kSide;
    std::array<std::int32_t, kAll> found;
    Vec3f sum = Vec3f::Zero();
    float rough = 0;
    int covered = 0;
    for (int k = 0; k < kAll; ++k) {
      const Seen s = seen(place(x, y, triangle, (k % kSide + 0.5) / kSide, (k / kSide + 0.5) / kSide));
      found[k] = s.particle;
      sum += color(s.particle);
      rough += roughness(s);
      covered += s.particle >= 0;
    }
    out_.base_color.pixels[at] = sum / kAll;
    out_.roughness.pixels[at].setConstant(rough / kAll);
    out_.cover[at] = static_cast<float>(covered) / kAll;
    std::sort(found.begin(), found.end());
    std::ptrdiff_t most = 0;
    for (auto first = std::upper_bound(found.begin(), found.end(), -1); first != found.end();) {
      const auto last = std::upper_bound(first, found.end(), *first);
      if (last - first > most) {
        most = last - first;
        owner_[at] = *first;
      }
      first = last;
    }
  }

  void add_detail(const residual::ResidualField& detail, double softness, const Work& work) {
    section::soften(out_.base_color.pixels.data(), out_.cover.data(),
                    {texels_.size, texels_.size, 1, 1, false}, softness);
    each_texel(texels_, work, [&](std::size_t at, int x, int y, std::int32_t triangle) {
      const Vec3f offset = detail.mixed(place(x, y, triangle, 0.5, 0.5), owner_[at], out_.cover[at]);
      Vec3f& pixel = out_.base_color.pixels[at];
      pixel = srgb_to_linear((linear_to_srgb(pixel) + offset).cwiseMax(0.0f));
    });
  }

  const UvTexels& texels_;
  const TexelPlaces& places_;
  const Particles& particles_;
  const Roughness& roughness_;
  carving::ParticleIndex index_;
  BakedMaps out_;
  std::vector<std::int32_t> owner_;  // particle with the largest share of the texel; −1: none
  std::vector<std::int32_t> ids_;    // particle at the center; −1: binder
};

// The grid `density` as a field of grays, over one period.
std::optional<carving::ColorField> density_field(const Volume& volume, const Work& work) {
  const auto grid = volume.find<openvdb::FloatGrid>("density");
  if (!grid) return std::nullopt;
  const openvdb::CoordBBox box = voxels_of(volume, *grid);
  const Vec3i n(box.dim().x(), box.dim().y(), box.dim().z());
  std::vector<Vec3f> gray(voxels_in(n));
  work.parallel(n.z(), 1, [&](std::size_t begin, std::size_t end) {
    auto voxels = grid->getConstAccessor();
    for (int z = static_cast<int>(begin); z < static_cast<int>(end); ++z)
      for (int y = 0; y < n.y(); ++y)
        for (int x = 0; x < n.x(); ++x)
          gray[voxel_at(x, y, z, n)].setConstant(
              std::clamp(voxels.getValue(box.min().offsetBy(x, y, z)), 0.0f, 1.0f));
  });
  work.check();
  return carving::ColorField(n, gray);
}

}  // namespace

BakedMaps bake_particles(const UvTexels& texels, const TexelPlaces& places, const Particles& particles,
                         const Shapes& shapes, const Roughness& roughness,
                         const residual::ResidualField* detail, double softness, const Work& work) {
  return ParticleBaker(texels, places, particles, shapes, roughness).bake(detail, softness, work);
}

BakedMaps bake_volume(const UvTexels& texels, const TexelPlaces& places, const Volume& volume,
                      const Roughness& roughness, const Work& work) {
  const carving::ColorField colors = carving::ColorField::of(volume, work.part(0, 0.2));
  const std::optional<carving::ColorField> density = density_field(volume, work.part(0.2, 0.3));
  const auto ids = volume.find<openvdb::Int32Grid>("id");
  const section::VolumeBox box = section::volume_box(volume);
  const openvdb::Coord first = voxels_of(volume).min();
  const auto voxel_of = [&](const Vec3& at) {  // by rounding, a point may be at the end of the period
    const auto along = [&](int k) { return std::clamp(round_down(at[k]), 0, colors.resolution()[k] - 1); };
    return first.offsetBy(along(0), along(1), along(2));
  };
  const Vec3 per_mm = colors.resolution().cast<double>().cwiseQuotient(box.size);
  BakedMaps out = blank_maps(texels.size, Vec3f::Constant(0.5f));
  work.part(0.3, 1).parallel(texels.size, rows_at_once(texels.size), [&](std::size_t begin, std::size_t end) {
    std::optional<openvdb::Int32Grid::ConstAccessor> id;
    if (ids) id.emplace(ids->getConstAccessor());
    for (std::size_t at = begin * texels.size; at < end * texels.size; ++at) {
      if (texels.triangle[at] < 0) continue;
      const int x = static_cast<int>(at % texels.size), y = static_cast<int>(at / texels.size);
      const Vec3 mm = places.at(texels.triangle[at], x, y, 0.5, 0.5) - box.corner;
      const Vec3 voxel = wrap_point(mm, box.size).cwiseProduct(per_mm);
      out.base_color.pixels[at] = colors.at(voxel.cast<float>());
      const float share = density ? density->at(voxel.cast<float>()).x() : 1.0f;
      out.cover[at] = share;
      out.roughness.pixels[at].setConstant(static_cast<float>(double{share} * roughness.particles[0] +
                                                              (1 - double{share}) * roughness.binder));
      if (id) out.id.pixels[at] = id_color(std::max(-1, id->getValue(voxel_of(voxel))));
    }
  });
  return out;
}

Image normals_on_mesh(const UvTexels& texels, const TexelPlaces& places, const textures::HeightField& h,
                      const Work& work) {
  const int n = texels.size;
  Image out(n, n, 1, h.mm_x, Vec3f(0.5f, 0.5f, 1));
  // Difference of heights per texel, from the neighbors that belong to a triangle.
  const auto slope = [&](int x, int y, int dx, int dy) {
    double first = double{h.at(x, y)}, last = first;
    int span = 0;
    const auto take = [&](int i, int j, double& height) {
      if (i < 0 || j < 0 || i >= n || j >= n || texels.triangle[pixel_at(i, j, n)] < 0) return;
      height = double{h.at(i, j)};
      ++span;
    };
    take(x - dx, y - dy, first);
    take(x + dx, y + dy, last);
    return span ? (last - first) / span : 0.0;
  };
  each_texel(texels, work, [&](std::size_t at, int x, int y, std::int32_t triangle) {
    const double right = slope(x, y, 1, 0), down = slope(x, y, 0, 1);
    if (right == 0 && down == 0) return;
    const TexelPlaces::Axes axes = places.axes(triangle);
    // The gradient in the triangle's plane that has these differences along the texture's axes.
    Eigen::Matrix2d metric;
    metric << axes.right.squaredNorm(), axes.right.dot(axes.down), axes.right.dot(axes.down),
        axes.down.squaredNorm();
    // Without one, of a triangle that is a line in space, the texel stays flat.
    constexpr double kLeast = 1e-12;  // sine of the angle between the axes, squared
    if (!(metric.determinant() > kLeast * metric(0, 0) * metric(1, 1))) return;
    const Eigen::Vector2d w = metric.inverse() * Eigen::Vector2d(right, down);
    const Vec3 gradient = w.x() * axes.right + w.y() * axes.down;
    const Vec3 tangent = axes.right.normalized();
    Vec3 up = axes.normal.cross(tangent);
    if (up.dot(axes.down) > 0) up = -up;  // mirrored
    const Vec3 normal = Vec3(-gradient.dot(tangent), -gradient.dot(up), 1).normalized();
    out.pixels[at] = (0.5 * (normal + Vec3::Ones())).cast<float>();
  });
  return out;
}

}  // namespace terrazzo::bake
