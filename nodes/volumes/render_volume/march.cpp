#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "nodes/data/indices.h"
#include "nodes/volumes/render_volume/scene.h"
#include "nodes/volumes/render_volume/simplex.h"

namespace terrazzo::render_volume {
namespace {

using Four = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));

[[gnu::always_inline]] inline Four four(const Vec3f& v) { return Four{v.x(), v.y(), v.z(), 0}; }
[[gnu::always_inline]] inline Four whole(float v) { return Four{v, v, v, v}; }
[[gnu::always_inline]] inline Four mix(const Four& a, const Four& b, float t) {
  return a + (b - a) * whole(t);
}

// e^−x for x ≥ 0, accurate to 2e-7.
[[gnu::always_inline]] inline float exp_minus(float x) {
  const float y = std::min(x, 80.0f) * -1.44269504f;
  const int i = static_cast<int>(y) - 1;
  const float f = y - i;  // 0 … 1
  const float p =
      1.0f +
      f * (0.69314718f +
           f * (0.24022651f + f * (0.05550411f + f * (0.00961813f + f * (0.00133336f + f * 0.00015403f)))));
  return p * std::bit_cast<float>((i + 127) << 23);
}

// Trilinear interpolation of stored voxels; q is the corner with the smallest coordinates.
[[gnu::always_inline]] inline float between(const std::uint16_t* q, float fx, float fy, float fz) {
  constexpr int kRow = Bricks::kSide, kSlice = kRow * kRow;
#if defined(__SSE2__)
  const auto pair = [](const std::uint16_t* at) {
    std::int32_t v;
    std::memcpy(&v, at, 4);
    return v;
  };
  const __m128i both = _mm_set_epi32(pair(q + kSlice + kRow), pair(q + kSlice), pair(q + kRow), pair(q));
  const Four a = _mm_cvtepi32_ps(_mm_and_si128(both, _mm_set1_epi32(0xffff)));
  const Four b = _mm_cvtepi32_ps(_mm_srli_epi32(both, 16));
#else
  const Four a = {float(q[0]), float(q[kRow]), float(q[kSlice]), float(q[kSlice + kRow])};
  const Four b = {float(q[1]), float(q[kRow + 1]), float(q[kSlice + 1]), float(q[kSlice + kRow + 1])};
#endif
  const Four r = mix(a, b, fx);
  const float near = r[0] + (r[1] - r[0]) * fy, far = r[2] + (r[3] - r[2]) * fy;
  return near + (far - near) * fz;
}

[[gnu::always_inline]] inline Four texel(const std::array<std::uint16_t, 4>& t) {
#if defined(__SSE2__)
  const __m128i v = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(t.data()));
  return _mm_cvtepi32_ps(_mm_unpacklo_epi16(v, _mm_setzero_si128()));
#else
  return Four{float(t[0]), float(t[1]), float(t[2]), float(t[3])};
#endif
}

// A texture level with its placement in one frame.
struct Placed {
  const SolidTexture::Level* level = nullptr;
  Four x, y, z, offset;  // columns, divided by the level's size: one period is 0 … 1
  Four size;
  float weight = 0;

  Placed() = default;
  Placed(const SolidTexture& t, const Placement& p, float w) : level(&t.levels[p.level]), weight(w) {
    const Vec3f inverse = level->size.cast<float>().cwiseInverse();
    x = four(inverse.cwiseProduct(p.linear.col(0)));
    y = four(inverse.cwiseProduct(p.linear.col(1)));
    z = four(inverse.cwiseProduct(p.linear.col(2)));
    offset = four(inverse.cwiseProduct(p.offset));
    size = four(level->size.cast<float>());
  }

  [[gnu::always_inline]] Four at(const Four& p) const {
    const Four q = x * whole(p[0]) + y * whole(p[1]) + z * whole(p[2]) + offset;
    Four f = q - __builtin_convertvector(__builtin_convertvector(q, FourInts), Four);
    f = f < 0 ? f + 1.0f : f;
    const Four u = f * size;
    const FourInts i = __builtin_convertvector(u, FourInts);
    const int nx = level->size.x(), ny = level->size.y(), nz = level->size.z();
    // Rounding may have produced the period itself.
    const int x0 = i[0] < nx ? i[0] : 0, y0 = i[1] < ny ? i[1] : 0, z0 = i[2] < nz ? i[2] : 0;
    const int x1 = x0 + 1 < nx ? x0 + 1 : 0, y1 = y0 + 1 < ny ? y0 + 1 : 0, z1 = z0 + 1 < nz ? z0 + 1 : 0;
    const Four t = u - __builtin_convertvector(i, Four);
    const auto* base = level->texels.data();
    const std::size_t low = static_cast<std::size_t>(z0) * ny, high = static_cast<std::size_t>(z1) * ny;
    const auto *a = base + (low + y0) * nx, *b = base + (low + y1) * nx, *c = base + (high + y0) * nx,
               *d = base + (high + y1) * nx;
    const Four e = mix(mix(texel(a[x0]), texel(a[x1]), t[0]), mix(texel(b[x0]), texel(b[x1]), t[0]), t[1]);
    const Four g = mix(mix(texel(c[x0]), texel(c[x1]), t[0]), mix(texel(d[x0]), texel(d[x1]), t[0]), t[1]);
    return mix(e, g, t[2]);
  }
};

struct Ray {
  Four origin, direction, inverse;  // positions, positions per mm, and its inverse
  float from = 0, to = 0;           // mm
  int entry = 0;                    // axis of the face where the ray enters
  float facing = 1;                 // light on that face
};

class Marcher {
 public:
  Marcher(const Scene& scene, const Frame& frame, const Bricks& bricks)
      : scene_(scene),
        frame_(frame),
        bricks_(bricks),
        low_(four(frame.low)),
        high_(four(frame.high)),
        per_mm_(four(frame.per_mm)),
        tissues_(scene.intervals.tissue),
        ambient_(static_cast<float>(scene.look.ambient)),
        translucency_(static_cast<float>(scene.look.translucency)) {
    for (const float e : scene.intervals.edges) edges_.push_back(scene.scan.stored(e));
    for (const TissueLook& t : frame.tissues) {
      auto& placed = placed_.emplace_back();
      for (int s = 0; s < kScales && t.texture >= 0; ++s)
        placed[s] = Placed(scene.textures[t.texture], t.at[s], t.weight[s]);
    }
    for (int k = 0; k < kTable; ++k) extinction_[k] = extinction_of((float(k) + 0.5f) * (65536.0f / kTable));
  }

  Vec3f color(float x, float y, FrameCounts& counts) const {
    Ray ray;
    Four color = whole(0);
    float left = 1;
    if (enter(x, y, ray)) {
      ++counts.rays;
      trace(ray, color, left, counts);
    }
    const Vec3f& b = scene_.look.background;
    return Vec3f(color[0] + left * b.x(), color[1] + left * b.y(), color[2] + left * b.z());
  }

 private:
  static constexpr int kTable = 4096;
  static constexpr float kLamp = 0.67f;
  static constexpr float kOpaque = 1.0f / 255;  // end a ray when less than this passes
  static constexpr float kFaint = 1.0f / 512;   // skip detail of contributions smaller than this

  float extinction_of(
      float stored) const {  // per mm, for tissues whose opacity depends on density (section 6)
    const float in = stored * frame_.int_scale + frame_.int_offset;
    const float alpha = std::clamp(in + 0.25f, 0.3f, 0.95f);
    return -std::log(1 - alpha) / frame_.reference_step * float(scene_.look.opacity);
  }

  bool enter(float x, float y, Ray& ray) const {
    const Vec3f d = frame_.camera.direction(x, y, scene_.look.width, scene_.look.height);
    const Vec3f direction = d.cwiseProduct(frame_.per_mm);
    const Vec3f origin = frame_.camera.position.cwiseProduct(frame_.per_mm) + frame_.middle;
    float from = 0, to = 1e30f;
    Vec3f inverse;
    for (int k = 0; k < 3; ++k) {
      const float safe = std::abs(direction[k]) < 1e-9f ? 1e-9f : direction[k];
      inverse[k] = 1 / safe;
      const float a = (frame_.low[k] - origin[k]) * inverse[k], b = (frame_.high[k] - origin[k]) * inverse[k];
      if (std::min(a, b) > from) {
        from = std::min(a, b);
        ray.entry = k;
      }
      to = std::min(to, std::max(a, b));
    }
    if (!(from < to)) return false;
    ray.origin = four(origin);
    ray.direction = four(direction);
    ray.inverse = four(inverse);
    ray.from = from;
    ray.to = to;
    Vec3f normal = Vec3f::Zero();
    normal[ray.entry] = direction[ray.entry] > 0 ? -1.0f : 1.0f;
    ray.facing = lambert(normal.dot(frame_.light));
    return true;
  }

  // Ambient light, a lamp, and a little light from behind so that shapes facing away still show.
  float lambert(float cosine) const {
    return ambient_ + kLamp * std::max(0.0f, cosine) + 0.10f * std::max(0.0f, -cosine);
  }

  [[gnu::always_inline]] Four position(const Ray& ray, float t) const {
    const Four p = ray.origin + ray.direction * whole(t);
    const Four q = p < low_ ? low_ : p;
    return q > high_ ? high_ : q;
  }

  [[gnu::always_inline]] std::size_t brick_of(const FourInts& cell) const {
    return bricks_.index(cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
  }

  [[gnu::always_inline]] float density(const Four& p) const {
    const FourInts c = __builtin_convertvector(p, FourInts);
    const Four f = p - __builtin_convertvector(c, Four);
    const std::uint16_t* v = bricks_.voxels(brick_of(c));
    if (!v) return 0;
    constexpr int kRow = Bricks::kSide;
    const int at = (((c[2] & 7) + 1) * kRow + (c[1] & 7) + 1) * kRow + (c[0] & 7) + 1;
    return between(v + at, f[0], f[1], f[2]);
  }

  // Lambert's law on the density gradient; without a gradient, a constant.
  float light(const Ray& ray, const Four& p, float t, bool cut) const {
    const FourInts c = __builtin_convertvector(p, FourInts);
    const Four f = p - __builtin_convertvector(c, Four);
    const std::uint16_t* v = bricks_.voxels(brick_of(c));
    if (!v) return 0;
    constexpr int kRow = Bricks::kSide, kSlice = kRow * kRow;
    const std::uint16_t* q = v + (((c[2] & 7) + 1) * kRow + (c[1] & 7) + 1) * kRow + (c[0] & 7) + 1;
    const float gx = (between(q + 1, f[0], f[1], f[2]) - between(q - 1, f[0], f[1], f[2])) * per_mm_[0];
    const float gy = (between(q + kRow, f[0], f[1], f[2]) - between(q - kRow, f[0], f[1], f[2])) * per_mm_[1];
    const float gz =
        (between(q + kSlice, f[0], f[1], f[2]) - between(q - kSlice, f[0], f[1], f[2])) * per_mm_[2];
    const float square = 0.25f * (gx * gx + gy * gy + gz * gz);
    const Vec3f& l = frame_.light;
    const float cosine = -0.5f * (gx * l.x() + gy * l.y() + gz * l.z()) / std::sqrt(square + 1e-12f);
    const float share = square / (square + frame_.soft_gradient * frame_.soft_gradient);
    float out = 0.8f + (lambert(cosine) - 0.8f) * share;
    if (cut) {
      const float deep = std::min(1.0f, (t - ray.from) / (4 * frame_.step));
      out = ray.facing + (out - ray.facing) * deep;
    }
    return out;
  }

  int interval(float d, int guess) const {
    const int last = edges_.size();
    while (guess < last && d >= edges_[guess]) ++guess;
    while (guess > 0 && d < edges_[guess - 1]) --guess;
    return guess;
  }

  void trace(const Ray& ray, Four& color, float& left, FrameCounts& counts) const {
    walk(ray, counts, [&](bool cut, float t0, float length, float d0, float d1, int i0, int i1) {
      segment(ray, cut, t0, length, d0, d1, i0, i1, color, left, counts);
      if (left >= kOpaque) return true;
      left = 0;
      return false;
    });
  }

  // Calls see(cut, t0, length, d0, d1, i0, i1) for each step along the ray that may meet tissue: where it
  // begins, the densities at its ends and their intervals. `cut`: the ray enters through tissue. Ends when
  // `see` returns false.
  template <class See>
  [[gnu::always_inline]] void walk(const Ray& ray, FrameCounts& counts, See&& see) const {
    const float h = frame_.step, length = ray.to - ray.from;
    const int last = round_up(length / h);
    const bool skip = scene_.look.skip_empty;
    bool have = false, cut = false;
    float d0 = 0, t0 = 0;
    int i0 = 0;
    for (int k = 0; k <= last;) {
      const float t = ray.from + std::min(float(k) * h, length);
      const Four p = position(ray, t);
      const FourInts cell = __builtin_convertvector(p, FourInts);
      const FourInts brick = cell >> 3;
      const std::uint8_t distance = skip ? bricks_.distance(bricks_.index(brick[0], brick[1], brick[2])) : 0;
      if (distance > 0 && !have) {
        k = std::max(k + 1, beyond(ray, brick, distance, h));
        continue;
      }
      const float d1 = density(p);
      ++counts.samples;
      if (!have) {
        have = true;
        if (k == 0) {
          d0 = d1;
          t0 = t;
          i0 = interval(d1, 0);
          cut = tissues_[i0] >= 0;  // the face cuts through tissue
          ++k;
          continue;
        }
        t0 = ray.from + float(k - 1) * h;
        d0 = density(position(ray, t0));
        i0 = interval(d0, 0);
        ++counts.samples;
      }
      const int i1 = interval(d1, i0);
      if (i0 != i1 || tissues_[i0] >= 0) {
        if (!see(cut, t0, t - t0, d0, d1, i0, i1)) return;
      }
      d0 = d1;
      t0 = t;
      i0 = i1;
      if (distance > 0)
        have = false;  // skip from here on
      else
        ++k;
    }
  }

  // The first sample beyond the cube of invisible bricks.
  int beyond(const Ray& ray, const FourInts& brick, int distance, float h) const {
    const FourInts to = (brick + distance) * Bricks::kCells, from = (brick - (distance - 1)) * Bricks::kCells;
    const Four face =
        ray.direction > 0 ? __builtin_convertvector(to, Four) : __builtin_convertvector(from, Four);
    const Four t = (face - ray.origin) * ray.inverse;
    const float exit = std::min({t[0], t[1], t[2]});
    return static_cast<int>((std::min(exit, ray.to) - ray.from) / h) + 1;
  }

  // Treats density as linear from one sample to the next: splits the segment into pieces of one tissue each,
  // with exact lengths. Calls see(tissue, from, to, density in the middle) with fractions of the segment.
  template <class See>
  [[gnu::always_inline]] void split(float d0, float d1, int i, int i1, See&& see) const {
    float from = 0;
    const float inverse = 1 / (d1 - d0);  // used only if the intervals differ
    while (true) {
      float to = 1;
      if (i != i1) {
        const float edge = i1 > i ? edges_[i] : edges_[i - 1];
        to = std::min(1.0f, std::max(from, (edge - d0) * inverse));
      }
      if (const int tissue = tissues_[i]; tissue >= 0 && to > from)
        see(tissue, from, to, d0 + (d1 - d0) * (0.5f * (from + to)));
      if (i == i1) return;
      i += i1 > i ? 1 : -1;
      from = to;
    }
  }

  void segment(const Ray& ray, bool cut, float t0, float length, float d0, float d1, int i, int i1,
               Four& color, float& left, FrameCounts& counts) const {
    float lit = -1;
    split(d0, d1, i, i1, [&](int tissue, float from, float to, float d) {
      const float t = t0 + 0.5f * (from + to) * length;
      const Four p = position(ray, t);
      if (lit < 0) {
        lit = light(ray, p, t, cut);
        if (translucency_ > 0) lit += translucency_ * (ambient_ + kLamp * transmitted(p, counts) - lit);
      }
      piece(tissue, p, d, (to - from) * length, lit, color, left, counts);
    });
  }

  // The share of the lamp's light that reaches a point through the tissues (Beer and Lambert).
  float transmitted(const Four& p, FrameCounts& counts) const {
    constexpr float kDark = 8;  // optical depth that ends a ray
    Ray ray;
    const Vec3f direction = frame_.light.cwiseProduct(frame_.per_mm);
    ray.to = 1e30f;
    Vec3f inverse;
    for (int k = 0; k < 3; ++k) {
      const float safe = std::abs(direction[k]) < 1e-9f ? 1e-9f : direction[k];
      inverse[k] = 1 / safe;
      ray.to = std::min(ray.to, ((safe > 0 ? frame_.high[k] : frame_.low[k]) - p[k]) * inverse[k]);
    }
    ray.origin = p;
    ray.direction = four(direction);
    ray.inverse = four(inverse);
    float depth = 0;
    if (ray.to > 0)
      walk(ray, counts, [&](bool, float, float length, float d0, float d1, int i0, int i1) {
        split(d0, d1, i0, i1, [&](int tissue, float from, float to, float) {
          depth += (to - from) * length * frame_.tissues[tissue].light_extinction;
        });
        return depth < kDark;
      });
    return exp_minus(depth);
  }

  void piece(int tissue, const Four& p, float d, float length, float lit, Four& color, float& left,
             FrameCounts& counts) const {
    ++counts.pieces;
    const TissueLook& look = frame_.tissues[tissue];
    const float sigma = look.by_density ? extinction_[static_cast<int>(d) * kTable >> 16] : look.fixed;
    const float through = exp_minus(sigma * length);
    const float share = left * (1 - through);
    left *= through;
    const float in = d * frame_.int_scale + frame_.int_offset;
    // Equation 7: D + D · (int − threshold).
    const float bright = lit * share * std::max(0.0f, 1 + look.modulation * (in - look.threshold));
    if (look.texture >= 0 && share > kFaint) {
      counts.lookups += kScales;
      const auto& at = placed_[tissue];
      const Four c = at[0].at(p) * whole(at[0].weight) + at[1].at(p) * whole(at[1].weight) +
                     at[2].at(p) * whole(at[2].weight);
      color += c * whole(bright);
      return;
    }
    float noise = 1;
    if (look.noise && share > kFaint) {
      const Vec3f mm((p[0] - frame_.middle.x()) / per_mm_[0], (p[1] - frame_.middle.y()) / per_mm_[1],
                     (p[2] - frame_.middle.z()) / per_mm_[2]);
      noise += float(scene_.look.skin_noise) * simplex(scene_.look.seed, mm / float(scene_.look.skin_scale));
    }
    color += four(look.color) * whole(bright * noise);
  }

  const Scene& scene_;
  const Frame& frame_;
  const Bricks& bricks_;
  Four low_, high_, per_mm_;
  std::vector<float> edges_;  // in stored values
  std::vector<int> tissues_;
  float ambient_, translucency_;
  std::vector<std::array<Placed, kScales>> placed_;
  std::array<float, kTable> extinction_;
};

}  // namespace

std::vector<Vec3f> march(const Scene& scene, const Frame& frame, const Bricks& bricks, FrameCounts& counts,
                         const Work& work) {
  const int width = scene.look.width, height = scene.look.height, samples = scene.look.samples;
  std::vector<Vec3f> out(pixels_in(width, height));
  const Marcher marcher(scene, frame, bricks);
  constexpr int kTile = 16;
  const int across = (width + kTile - 1) / kTile, down = (height + kTile - 1) / kTile;
  std::vector<FrameCounts> parts(static_cast<std::size_t>(across) * down);
  work.parallel(parts.size(), 1, [&](std::size_t begin, std::size_t) {
    const int x0 = static_cast<int>(begin) % across * kTile, y0 = static_cast<int>(begin) / across * kTile;
    FrameCounts count;
    for (int y = y0; y < std::min(y0 + kTile, height); ++y) {
      work.check();
      for (int x = x0; x < std::min(x0 + kTile, width); ++x) {
        Vec3f sum = Vec3f::Zero();
        for (int j = 0; j < samples; ++j)
          for (int i = 0; i < samples; ++i)
            sum += marcher
                       .color(float(x) + (float(i) + 0.5f) / float(samples),
                              float(y) + (float(j) + 0.5f) / float(samples), count)
                       .cwiseMin(1.0f);
        out[pixel_at(x, y, width)] = sum / float(samples * samples);
      }
    }
    parts[begin] = count;
  });
  for (const FrameCounts& c : parts) counts += c;
  return out;
}

}  // namespace terrazzo::render_volume
