#include "nodes/detail/residual/skins.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/periodic.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::residual {
namespace {

using Mat2f = Eigen::Matrix2f;

constexpr std::uint64_t kSkinStream = 0x736b696e;
// Differences in Oklab, in the logarithm of the size and in that of the stretching that count equally.
constexpr float kColorSpread = 0.03F, kSizeSpread = 0.5F, kStretchSpread = 0.2F;
constexpr float kEnlarged = 4;     // how much worse it is to enlarge a skin than to reduce it
constexpr float kStrange = 1;      // how much worse the skin of another stone is, whose outline differs
constexpr float kChance = 0.5F;    // of the choice: no skin is worn by all stones of one kind
constexpr float kSmallest = 0.6F;  // particle that wears a skin, in the smallest skin

// Of a solid about its centroid, the origin: sums over tetrahedra with one corner there.
Mat3 covariance_of(const Mesh& mesh) {
  Mat3 squares = Mat3::Zero();
  double volume = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double part = a.dot(b.cross(c)) / 6;
    const Vec3 sum = a + b + c;
    squares +=
        part / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    volume += part;
  }
  return squares / volume;
}

// The variance of points of the silhouette, seen along z, of the ellipsoid with this covariance.
Mat2f spread_from_above(const Mat3& covariance) {
  return (1.25 * covariance.topLeftCorner<2, 2>()).cast<float>();
}

// Of a symmetric, positive matrix (Cayley and Hamilton).
Mat2f root_of(const Mat2f& m) {
  const float s = std::sqrt(std::max(m.determinant(), 0.0F));
  const float t = std::sqrt(std::max(m.trace() + 2 * s, std::numeric_limits<float>::min()));
  return (m + s * Mat2f::Identity()) / t;
}

// The symmetric matrix that maps one ellipse to another (Olkin and Pukelsheim 1982).
Mat2f transport(const Mat2f& from, const Mat2f& to) {
  const Mat2f root = root_of(from);
  const Mat2f inverse = root.inverse();
  return inverse * root_of(root * to * root) * inverse;
}

// How much longer one direction becomes than the other, as a logarithm.
float stretching(const Mat2f& symmetric) {
  const float mean = symmetric.trace() / 2;
  const float part = std::sqrt(std::max(0.0F, mean * mean - symmetric.determinant()));
  return std::log((mean + part) / std::max(mean - part, 1e-6F * mean));
}

// Between pixel centers by Catmull and Rom's cubic, which keeps grain sharp. `index`: of the pixel in a
// column and a row that may lie outside.
template <class Index>
Vec3f sample(const std::vector<Vec3f>& values, float x, float y, Index&& index) {
  const auto weights = [](float t, float* w) {
    w[0] = t * (-0.5F + t * (1 - 0.5F * t));
    w[1] = 1 + t * t * (1.5F * t - 2.5F);
    w[2] = t * (0.5F + t * (2 - 1.5F * t));
    w[3] = t * t * (0.5F * t - 0.5F);
  };
  const int left = round_down(x - 0.5F);
  const int top = round_down(y - 0.5F);
  float across[4], down[4];
  weights(x - 0.5F - left, across);
  weights(y - 0.5F - top, down);
  Vec3f sum = Vec3f::Zero();
  for (int v = 0; v < 4; ++v)
    for (int u = 0; u < 4; ++u) sum += across[u] * down[v] * values[index(left + u - 1, top + v - 1)];
  return sum;
}

void smooth(std::vector<Vec3f>& shade, int width, int height, double pixels) {
  if (pixels <= 1) return;
  cv::Mat values(height, width, CV_32FC3, shade.data());
  cv::GaussianBlur(values, values, {0, 0}, std::sqrt((pixels * pixels - 1) / 12), 0, cv::BORDER_REPLICATE);
}

}  // namespace

Skins::Skins(const Detail& detail, const Particles& particles, const Shapes& shapes, double footprint)
    : box_(particles.box.cast<float>()),
      pixel_size_(detail.pixel_size),
      ground_(detail.ground),
      skins_(detail.skins) {
  if (has_ground()) smooth(ground_.shade, ground_.width, ground_.height, footprint / detail.pixel_size);
  worn_.resize(particles.count());
  if (skins_.empty()) return;
  smallest_ = std::numeric_limits<float>::max();
  for (Detail::Skin& skin : skins_) {
    smooth(skin.shade, skin.width, skin.height, footprint / detail.pixel_size);
    oklab_.push_back(linear_to_oklab(skin.color));
    smallest_ = std::min(smallest_, skin.size);
    of_profile_[skin.profile] = count_of(oklab_) - 1;
  }
  std::vector<Mat3> covariance;
  for (const Shape& shape : shapes.shapes) covariance.push_back(covariance_of(shape.mesh));
  for (std::size_t p = 0; p < particles.count(); ++p) {
    if (particles.is_void(p) || particles.size[p] < kSmallest * smallest_) continue;
    const std::int32_t shape = particles.shape[p];
    const Mat3 turn = particles.scale[p] * particles.orientation[p].normalized().toRotationMatrix();
    worn_[p] = choose(p, particles, spread_from_above(turn * covariance[shape] * turn.transpose()),
                      own_skin(shapes.shapes[shape], particles, p));
  }
}

std::optional<Skins::Worn> Skins::own_skin(const Shape& shape, const Particles& particles,
                                           std::size_t particle) const {
  const auto found = of_profile_.find(shape.traced.profile);
  const double scale = particles.scale[particle];
  if (found == of_profile_.end()) return {};
  const Detail::Skin& skin = skins_[found->second];
  Worn worn;
  worn.skin = found->second;
  const Vec2 start = (shape.traced.origin - skin.corner) / pixel_size_;
  worn.start = Vec2(start.x(), -start.y()).cast<float>();
  // A stone of another photograph is elsewhere.
  if ((worn.start - skin.center).squaredNorm() > skin.spread.trace()) return {};
  const Mat3 to_mesh = particles.orientation[particle].normalized().toRotationMatrix().transpose();
  const Eigen::Matrix2d to_photograph =
      Eigen::DiagonalMatrix<double, 2>(1, -1) * Eigen::Rotation2Dd(shape.traced.turn).toRotationMatrix();
  worn.to_skin = (to_photograph * to_mesh.topRows<2>() / (scale * pixel_size_)).cast<float>();
  return worn;
}

Skins::Worn Skins::choose(std::size_t particle, const Particles& particles, const Mat2f& spread,
                          const std::optional<Worn>& own) const {
  const Vec3f color = linear_to_oklab(particles.color[particle]);
  const float size =
      4 * std::sqrt(std::sqrt(spread.determinant()));      // the ellipse's half axes are two deviations
  const Mat2f flip = Eigen::Vector2f(1, -1).asDiagonal();  // rows of pictures run downwards
  Random random(1, kSkinStream, particle);
  Worn best;
  float lost_grain = 0;  // all of it where a pixel covers two
  float least = std::numeric_limits<float>::max();
  for (int k = 0; k < count_of(skins_); ++k) {
    const Detail::Skin& skin = skins_[k];
    const bool is_own = own && own->skin == k;
    const Mat2f map = transport(flip * spread * flip, skin.spread);
    float larger = std::log(size / skin.size);
    if (larger > 0) larger *= kEnlarged;
    const float stretched = is_own ? 0 : stretching(map) / kStretchSpread;
    const float cost = (oklab_[k] - color).squaredNorm() / (kColorSpread * kColorSpread) +
                       larger * larger / (kSizeSpread * kSizeSpread) + stretched * stretched +
                       (is_own ? 0 : kStrange) + kChance * static_cast<float>(random.uniform());
    if (cost >= least) continue;
    least = cost;
    lost_grain = std::clamp(std::log2(size / skin.size), 0.0F, 1.0F);
    if (is_own) {
      best = *own;
      continue;
    }
    best.skin = k;
    best.to_skin << map * flip, Eigen::Vector2f::Zero();
    best.start = skin.center;
  }
  best.lost_grain = lost_grain;
  best.center = particles.position[particle].cast<float>();
  return best;
}

Vec3f Skins::at(const Vec3f& mm, int particle, const Vec3f& color) const {
  const Worn& worn = worn_[particle];
  Vec3f offset = mm - worn.center;
  for (int a = 0; a < 3; ++a) offset[a] -= box_[a] * std::round(offset[a] / box_[a]);
  const Detail::Skin& skin = skins_[worn.skin];
  const Eigen::Vector2f at = worn.to_skin * offset + worn.start;
  const auto index = [&](int x, int y) {
    return pixel_at(std::clamp(x, 0, skin.width - 1), std::clamp(y, 0, skin.height - 1), skin.width);
  };
  return Detail::with_shade(color, sample(skin.shade, at.x(), at.y(), index));
}

Vec3f Skins::ground(const Vec3f& mm, const Vec3f& color) const {
  const Eigen::Vector2f at = mm.head<2>() / static_cast<float>(pixel_size_);
  const auto index = [&](int x, int y) {
    return pixel_at(wrap_index(x, ground_.width), wrap_index(y, ground_.height), ground_.width);
  };
  return Detail::with_shade(color, sample(ground_.shade, at.x(), -at.y(), index));
}

}  // namespace terrazzo::residual
