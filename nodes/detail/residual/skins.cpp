#include "nodes/detail/residual/skins.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <span>
#include <utility>

#include "nodes/common/geometry/periodic.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::residual {
namespace {

using Mat2 = Eigen::Matrix2d;

constexpr std::uint64_t kSkinStream = 0x736b696e;
// Differences in Oklab, in the logarithm of the size and in that of the stretching that count equally.
constexpr double kColorSpread = 0.03, kSizeSpread = 0.5, kStretchSpread = 0.2;
constexpr double kTurnSpread = 0.8;  // radians by which a skin is turned, which count like those
constexpr double kEnlarged = 4;      // how much worse it is to enlarge a skin than to reduce it
constexpr double kStrange = 1;       // how much worse the skin of another stone is, whose outline differs
constexpr double kHidden = 0.1;      // share of a stone that others hide which counts like those
constexpr double kChance = 0.5;      // of the choice: no skin is worn by all stones of one kind
constexpr double kWorn = 1;          // how much worse a skin is that covers as much as one on average
constexpr double kUpright = 0.94;    // cosine of 20°: the sides of stones that lean more were hardly seen
constexpr double kSmallest = 0.6;    // particle that wears a skin, in the smallest skin

double square(double v) { return v * v; }

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
Mat2 spread_from_above(const Mat3& covariance) { return 1.25 * covariance.topLeftCorner<2, 2>(); }

// Of a symmetric, positive matrix (Cayley and Hamilton).
Mat2 root_of(const Mat2& m) {
  const double s = std::sqrt(std::max(m.determinant(), 0.0));
  const double t = std::sqrt(std::max(m.trace() + 2 * s, std::numeric_limits<double>::min()));
  return (m + s * Mat2::Identity()) / t;
}

// The symmetric matrices that map an ellipse to others (Olkin and Pukelsheim 1982).
struct Transport {
  Mat2 from, root, inverse;
  explicit Transport(const Mat2& ellipse) : from(ellipse), root(root_of(from)), inverse(root.inverse()) {}
  Mat2 to(const Mat2& other) const { return inverse * root_of(root * other * root) * inverse; }
};

// How much longer one direction becomes than the other, as a logarithm.
double stretching(const Mat2& symmetric) {
  const double mean = symmetric.trace() / 2;
  const double part = std::sqrt(std::max(0.0, mean * mean - symmetric.determinant()));
  return std::log((mean + part) / std::max(mean - part, 1e-6 * mean));
}

// The angle of an ellipse's long axis, radians.
double long_axis(const Mat2& spread) { return std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1)) / 2; }

// A map from the ellipse of a particle to that of a skin, and what it costs.
struct Laying {
  Mat2 to_skin = Mat2::Identity();
  double cost = 0;
};

// Stretches the skin, or turns it first until long axes agree, whichever costs less: a turned one shows its
// relief in the wrong light, a stretched one has streaks. `mirror`: what happens to the skin before.
Laying lay(const Transport& transport, const Mat2& mirror, const Mat2& spread) {
  const Mat2 mirrored = mirror * spread * mirror;
  const auto turned_by = [&](double angle) {
    const Mat2 turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
    const Mat2 map = transport.to(turn * mirrored * turn.transpose());
    return Laying{mirror * turn.transpose() * map,
                  square(stretching(map) / kStretchSpread) + square(angle / kTurnSpread)};
  };
  const Laying straight = turned_by(0);
  const double apart = long_axis(transport.from) - long_axis(mirrored);
  const Laying turned = turned_by(std::remainder(apart, std::numbers::pi));
  return turned.cost < straight.cost ? turned : straight;
}

// Where an angle in radians lies among this many directions around a circle, from 0 up to their number.
float direction_of(float angle, int directions) {
  const float turn = angle / (2 * std::numbers::pi_v<float>);
  return (turn - std::floor(turn)) * static_cast<float>(directions);
}

// Linear between directions; 0 beside one where nothing is known.
float in_direction(std::span<const float> outline, float angle) {
  const int n = count_of(outline);
  const float at = direction_of(angle, n);
  const int k = round_down(at);
  const float before = outline[k % n];
  const float after = outline[(k + 1) % n];
  if (!(before > 0) || !(after > 0)) return 0;
  return std::lerp(before, after, at - static_cast<float>(k));
}

// The share of a stone's silhouette that others hide, at least: what is seen of it spreads like an ellipse of
// that area or a smaller one.
double hidden_share(const Detail::Skin& skin, double pixel_size) {
  const double seen = 16 * std::sqrt(std::max(0.0F, skin.spread.determinant())) * square(pixel_size);
  return std::max(0.0, 1 - seen / square(skin.size));
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

// For pixels that cover several of a picture. `border`: how it continues, of OpenCV's kinds.
void smooth(std::vector<Vec3f>& shade, int width, int height, double pixels, int border) {
  if (pixels <= 1) return;
  const double sigma = std::min(std::sqrt((pixels * pixels - 1) / 12), double(std::min(width, height)) / 4);
  const int around = std::min(round_up(3 * sigma), std::min(width, height));
  const cv::Mat values(height, width, CV_32FC3, shade.data());
  cv::Mat wide;
  cv::copyMakeBorder(values, wide, around, around, around, around, border);
  cv::GaussianBlur(wide, wide, {0, 0}, sigma);
  wide(cv::Rect(around, around, width, height)).copyTo(values);
}

}  // namespace

Skins::Skins(const Detail& detail, const Particles& particles, const Shapes& shapes, double footprint,
             const Work& work)
    : box_(particles.box.cast<float>()),
      pixel_size_(detail.pixel_size),
      ground_(detail.ground),
      skins_(detail.skins) {
  if (has_ground())
    smooth(ground_.shade, ground_.width, ground_.height, footprint / detail.pixel_size, cv::BORDER_WRAP);
  worn_.resize(particles.count());
  if (skins_.empty()) return;
  covers_.assign(skins_.size(), 0);
  for (const double size : particles.size) usual_cover_ += square(size) / count_of(skins_);
  smallest_ = std::numeric_limits<float>::max();
  for (Detail::Skin& skin : skins_) {
    smooth(skin.shade, skin.width, skin.height, footprint / detail.pixel_size, cv::BORDER_REPLICATE);
    oklab_.push_back(linear_to_oklab(skin.color));
    hidden_.push_back(square(hidden_share(skin, detail.pixel_size) / kHidden));
    smallest_ = std::min(smallest_, skin.size);
    of_profile_[skin.profile] = count_of(oklab_) - 1;
  }
  std::vector<Mat3> covariance;
  for (const Shape& shape : shapes.shapes) covariance.push_back(covariance_of(shape.mesh));
  for (std::size_t p = 0; p < particles.count(); ++p) {
    if (particles.is_void(p) || particles.size[p] < kSmallest * smallest_) continue;
    work.check();
    const std::int32_t shape = particles.shape[p];
    const Mat3 turn = particles.scale[p] * particles.orientation[p].normalized().toRotationMatrix();
    worn_[p] = choose(p, particles, spread_from_above(turn * covariance[shape] * turn.transpose()),
                      own_skin(shapes.shapes[shape], particles, p));
    if (!bare(p)) covers_[worn_[p].skin] += square(particles.size[p]);
  }
  work.parallel(particles.count(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      if (bare(p)) continue;
      const Mat3 turn = particles.scale[p] * particles.orientation[p].normalized().toRotationMatrix();
      worn_[p].outline = outline_on_skin(worn_[p], shapes.shapes[particles.shape[p]].mesh, turn);
    }
  });
}

std::optional<Skins::Worn> Skins::own_skin(const Shape& shape, const Particles& particles,
                                           std::size_t particle) const {
  const auto found = of_profile_.find(shape.traced.profile);
  const double scale = particles.scale[particle];
  const Mat3 turned = particles.orientation[particle].normalized().toRotationMatrix();
  if (found == of_profile_.end() || !(turned(2, 2) > kUpright)) return {};
  const Detail::Skin& skin = skins_[found->second];
  Worn worn;
  worn.skin = found->second;
  const Vec2 start = (shape.traced.origin - skin.corner) / pixel_size_;
  worn.start = Vec2(start.x(), -start.y()).cast<float>();
  // A stone of another photograph is elsewhere.
  if ((worn.start - skin.center).squaredNorm() > skin.spread.trace()) return {};
  const Mat3 to_mesh = turned.transpose();
  const Eigen::Matrix2d to_photograph =
      Eigen::DiagonalMatrix<double, 2>(1, -1) * Eigen::Rotation2Dd(shape.traced.turn).toRotationMatrix();
  worn.to_skin = (to_photograph * to_mesh.topRows<2>() / (scale * pixel_size_)).cast<float>();
  return worn;
}

Skins::Worn Skins::choose(std::size_t particle, const Particles& particles, const Mat2& spread,
                          const std::optional<Worn>& own) const {
  const Vec3f color = linear_to_oklab(particles.color[particle]);
  // The ellipse's half axes are two standard deviations.
  const double size = 4 * std::sqrt(std::sqrt(std::max(0.0, spread.determinant())));
  const Mat2 flip = Vec2(1, -1).asDiagonal();  // rows of pictures run downwards
  const Transport transport(flip * spread * flip);
  Random random(1, kSkinStream, particle);
  // Half of the skins of other stones are seen in a mirror, left for right, so that fewer look alike; light
  // mostly comes from above.
  const Mat2 mirror = Vec2(random.uniform() < 0.5 ? -1 : 1, 1).asDiagonal();
  Worn best;
  best.center = particles.position[particle].cast<float>();
  double least = std::numeric_limits<double>::max();
  for (int k = 0; k < count_of(skins_); ++k) {
    const Detail::Skin& skin = skins_[k];
    const bool is_own = own && own->skin == k;
    double larger = std::log(size / skin.size);
    if (larger > 0) larger *= kEnlarged;
    double cost = (oklab_[k] - color).squaredNorm() / (kColorSpread * kColorSpread) +
                  larger * larger / (kSizeSpread * kSizeSpread) + hidden_[k] + (is_own ? 0 : kStrange) +
                  kWorn * covers_[k] / usual_cover_ + kChance * random.uniform();
    if (!(cost < least)) continue;
    const Laying laying = is_own ? Laying{} : lay(transport, mirror, skin.spread.cast<double>());
    cost += laying.cost;
    if (!(cost < least)) continue;  // neither is what is not a number
    least = cost;
    best.skin = k;
    best.lost_grain = static_cast<float>(std::clamp(std::log2(size / skin.size), 0.0, 1.0));
    best.start = is_own ? own->start : skin.center;
    if (is_own)
      best.to_skin = own->to_skin;
    else
      best.to_skin << (laying.to_skin * flip).cast<float>(), Eigen::Vector2f::Zero();
  }
  return best;
}

// The farthest edge of the mesh in each direction; 0 where there is none.
Skins::Outline Skins::outline_on_skin(const Worn& worn, const Mesh& mesh, const Mat3& turn) const {
  Outline outline{};
  const int directions = count_of(outline);
  const Eigen::Vector2f start = worn.start - skins_[worn.skin].center;
  const Eigen::Matrix<float, 2, 3> to_skin = worn.to_skin * turn.cast<float>();
  std::vector<Eigen::Vector2f> at;
  std::vector<float> direction;
  for (const Vec3& v : mesh.vertices) {
    at.push_back(to_skin * v.cast<float>() + start);
    direction.push_back(direction_of(std::atan2(at.back().y(), at.back().x()), directions));
  }
  const auto add_edge = [&](int i, int j) {
    float first = direction[i];
    float last = direction[j];
    if (first > last) std::swap(first, last);
    if (last - first > directions / 2.0F)  // the shorter way passes the first direction
      first = std::exchange(last, first + static_cast<float>(directions));
    for (int k = round_up(first); k <= last; ++k) {
      const float angle = 2 * std::numbers::pi_v<float> * k / directions;
      const Eigen::Vector2f ray(std::cos(angle), std::sin(angle));
      const Eigen::Vector2f edge = at[j] - at[i];
      const float across = ray.x() * edge.y() - ray.y() * edge.x();
      const float distance = (at[i].x() * edge.y() - at[i].y() * edge.x()) / across;
      float& farthest = outline[k % directions];
      if (std::isfinite(distance)) farthest = std::max(farthest, distance);
    }
  };
  for (const Triangle& t : mesh.triangles)
    for (int e = 0; e < 3; ++e)
      if (t[e] < t[(e + 1) % 3]) add_edge(t[e], t[(e + 1) % 3]);  // neighbors share it
  return outline;
}

// The place on the skin for a place relative to its center, both in pixels.
Eigen::Vector2f Skins::fitted(const Worn& worn, const Eigen::Vector2f& at) const {
  constexpr float kLeast = 0.8F, kMost = 1.25F;  // beyond them, grain would smear
  const std::vector<float>& seen = skins_[worn.skin].outline;
  const float distance = at.norm();
  if (seen.empty() || !(distance > 0)) return at;
  const float angle = std::atan2(at.y(), at.x());
  const float own = in_direction(worn.outline, angle);
  const float its = in_direction(seen, angle);
  if (!(own > 0) || !(its > 0)) return at;
  const float ratio = std::clamp(its / own, kLeast, kMost);
  return at * (1 + (ratio - 1) * std::min(1.0F, distance / own));
}

Vec3f Skins::at(const Vec3f& mm, int particle, const Vec3f& color) const {
  const Worn& worn = worn_[particle];
  Vec3f offset = mm - worn.center;
  for (int a = 0; a < 3; ++a) offset[a] -= box_[a] * std::round(offset[a] / box_[a]);
  const Detail::Skin& skin = skins_[worn.skin];
  const Eigen::Vector2f at = skin.center + fitted(worn, worn.to_skin * offset + worn.start - skin.center);
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

Detail without_light(Detail detail) {
  detail.skins.clear();
  detail.ground = {};
  for (Detail::Phase& phase : detail.phases) {
    phase.slope = 0;
    for (Vec3f& offset : phase.broad) offset -= Vec3f::Constant(offset.mean());
  }
  return detail;
}

}  // namespace terrazzo::residual
