#include "nodes/photograph/grain/grain.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::grain {
namespace {

double lattice(std::uint64_t seed, std::int64_t x, std::int64_t y) {
  const std::uint64_t h = mix64(mix64(seed ^ static_cast<std::uint64_t>(x)) + y);
  return (h >> 11) * 0x1p-52 - 1;
}

// Value noise with quintic blending, in −1…1.
double value_noise(std::uint64_t seed, double x, double y) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto blend = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const double u = blend(x - fx), v = blend(y - fy);
  const auto i = static_cast<std::int64_t>(fx), j = static_cast<std::int64_t>(fy);
  const double low = lattice(seed, i, j) * (1 - u) + lattice(seed, i + 1, j) * u;
  const double high = lattice(seed, i, j + 1) * (1 - u) + lattice(seed, i + 1, j + 1) * u;
  return low * (1 - v) + high * v;
}

// Five octaves, scaled to a standard deviation of about one.
double mottles(std::uint64_t seed, double x, double y) {
  double sum = 0, amplitude = 1;
  for (int octave = 0; octave < 5; ++octave, amplitude *= 0.6, x *= 2.03, y *= 2.03)
    sum += amplitude * value_noise(seed + octave, x, y);
  return sum * 2.2;
}

std::vector<double> gaussian(double sd) {
  const int radius = round_up(3 * sd);
  std::vector<double> k(2 * radius + 1);
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) sum += k[i + radius] = std::exp(-0.5 * i * i / (sd * sd));
  for (double& w : k) w /= sum;
  return k;
}

Image blurred(const Image& in, double sd, const Work& work) {
  if (sd <= 0) return in;
  const auto k = gaussian(sd);
  const int radius = k.size() / 2;
  Image rows = in, out = in;
  const auto pass = [&](const Image& from, Image& to, bool along_x) {
    work.parallel(static_cast<std::size_t>(in.height) * in.sections, 16, [&](std::size_t b, std::size_t e) {
      for (std::size_t r = b; r < e; ++r) {
        const int y = r % in.height, s = r / in.height;
        for (int x = 0; x < in.width; ++x) {
          Eigen::Vector3d sum = Eigen::Vector3d::Zero();
          for (int i = -radius; i <= radius; ++i) {
            const int px = along_x ? std::clamp(x + i, 0, in.width - 1) : x;
            const int py = along_x ? y : std::clamp(y + i, 0, in.height - 1);
            sum += k[i + radius] * from.at(px, py, s).cast<double>();
          }
          to.at(x, y, s) = sum.cast<float>();
        }
      }
    });
  };
  pass(in, rows, true);
  pass(rows, out, false);
  return out;
}

}  // namespace

Image add_grain(const Image& image, const Labels* labels, const GrainOptions& g, const Work& work) {
  if (image.pixels.empty()) throw Error("empty-image", "the picture has no pixels");
  if (labels &&
      (labels->width != image.width || labels->height != image.height || labels->sections != image.sections))
    throw Error("size-mismatch", "labels and picture have different sizes");
  Image out = image;
  const double per_mm = image.pixel_size / g.scale;
  work.part(0, 0.5).parallel(
      static_cast<std::size_t>(image.height) * image.sections, 16, [&](std::size_t b, std::size_t e) {
        for (std::size_t r = b; r < e; ++r)
          for (int x = 0; x < image.width; ++x) {
            const std::size_t i = r * image.width + x;
            const std::uint64_t id = labels ? labels->ids[i] : 0;
            const double y = r % image.height;
            // Each body has its own pattern and direction.
            Random own(g.seed, 1, id);
            const double turn = own.uniform(0, 6.283185307179586), c = std::cos(turn), s = std::sin(turn);
            const double m =
                mottles(mix64(g.seed ^ mix64(id)), (c * x - s * y) * per_mm, (s * x + c * y) * per_mm);
            for (int k = 0; k < 3; ++k) {
              const double factor = (1 + g.mottle * m) * (1 + (id ? g.vary * own.normal() : 0.0));
              out.pixels[i][k] = std::max(0.0, out.pixels[i][k] * factor);
            }
          }
      });
  out = blurred(out, g.blur, work.part(0.5, 0.8));
  work.part(0.8, 1).parallel(out.pixels.size(), 1 << 14, [&](std::size_t b, std::size_t e) {
    for (std::size_t i = b; i < e; ++i) {
      Random random(g.seed, 2, i);
      for (int k = 0; k < 3; ++k) {
        const double v = out.pixels[i][k];
        out.pixels[i][k] = std::max(0.0, v + g.noise * std::sqrt(v / 0.5) * random.normal());
      }
    }
  });
  return out;
}

}  // namespace terrazzo::grain
