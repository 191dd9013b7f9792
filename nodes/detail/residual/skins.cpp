#include "nodes/detail/residual/skins.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "nodes/common/geometry/periodic.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/data/luminance.h"
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

// Stretches the skin, or turns it first until long axes agree, whichever costs less: a turned one shows what
// light is left in it from the wrong side, a stretched one has streaks. `mirror`: what happens to the skin
// before.
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

// The share of a stone's silhouette that others hide, at least: what is seen of it spreads like an ellipse of
// that area or a smaller one.
double hidden_share(const Detail::Skin& skin, double pixel_size) {
  const double seen = 16 * std::sqrt(std::max(0.0F, skin.spread.determinant())) * square(pixel_size);
  return std::max(0.0, 1 - seen / square(skin.size));
}

// Between pixel centers by Catmull and Rom's cubic, which keeps grain sharp. `index`: of the pixel in a
// column and a row that may lie outside.
template <class Value, class Index>
Value sample(const std::vector<Value>& values, float x, float y, Index&& index) {
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
  Value sum = Value::Zero();
  for (int v = 0; v < 4; ++v)
    for (int u = 0; u < 4; ++u) sum += across[u] * down[v] * values[index(left + u - 1, top + v - 1)];
  return sum;
}

// For pixels that cover several of the ground's, which repeats.
void smooth(Detail::Ground& ground, double pixels) {
  if (pixels <= 1) return;
  const int side = std::min(ground.width, ground.height);
  const double sigma = std::min(std::sqrt((pixels * pixels - 1) / 12), side / 4.0);
  const int around = std::min(round_up(3 * sigma), side);
  const cv::Mat values(ground.height, ground.width, CV_32FC3, ground.shade.data());
  cv::Mat wide;
  cv::copyMakeBorder(values, wide, around, around, around, around, cv::BORDER_WRAP);
  cv::GaussianBlur(wide, wide, {0, 0}, sigma);
  wide(cv::Rect(around, around, ground.width, ground.height)).copyTo(values);
}

// A direction to the right and upwards as one to the right and downwards, as rows of pictures run.
Eigen::Vector2f in_rows(const Eigen::Vector2f& v) { return {v.x(), -v.y()}; }
Eigen::Vector2f quarter_turn(const Eigen::Vector2f& v) { return {-v.y(), v.x()}; }

}  // namespace

Skins::Skins(const Detail& detail, const Particles& particles, const Shapes& shapes, double footprint,
             const std::optional<Vec2>& light, const Work& work)
    : box_(particles.box.cast<float>()),
      pixel_size_(detail.pixel_size),
      ground_(detail.ground),
      skins_(detail.skins) {
  if (has_ground()) smooth(ground_, footprint / detail.pixel_size);
  worn_.resize(particles.count());
  if (skins_.empty()) return;
  faceted_ = !shapes.shapes.empty() && std::all_of(shapes.shapes.begin(), shapes.shapes.end(),
                                                   [](const Shape& s) { return s.traced.faceted; });
  take_pictures(detail.relief, footprint > 0, work);
  covers_.assign(skins_.size(), 0);
  for (const double size : particles.size) usual_cover_ += square(size) / count_of(skins_);
  for (const Detail::Skin& skin : skins_) {
    oklab_.push_back(linear_to_oklab(skin.color));
    hidden_.push_back(square(hidden_share(skin, detail.pixel_size) / kHidden));
    of_profile_[skin.profile] = count_of(oklab_) - 1;
  }
  std::vector<Mat3> covariance;
  for (const Shape& shape : shapes.shapes) covariance.push_back(covariance_of(shape.mesh));
  for (std::size_t p = 0; p < particles.count(); ++p) {
    if (particles.is_void(p)) continue;
    work.check();
    const std::int32_t shape = particles.shape[p];
    const Mat3 turn = particles.scale[p] * particles.orientation[p].normalized().toRotationMatrix();
    worn_[p] = choose(p, particles, spread_from_above(turn * covariance[shape] * turn.transpose()),
                      own_skin(shapes.shapes[shape], particles, p));
    if (bare(p)) continue;
    covers_[worn_[p].skin] += square(particles.size[p]);
    fit_level(worn_[p], footprint);
    light_up(worn_[p], detail.relief.light, light);
  }
}

void Skins::take_pictures(const Detail::Relief& relief, bool reduced, const Work& work) {
  constexpr int kFewest = 4;  // pixels of the shorter side
  pictures_.resize(skins_.size());
  work.parallel(skins_.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      std::vector<Picture>& levels = pictures_[k];
      if (faceted_) remove_faces(skins_[k]);
      levels.push_back(with_relief(skins_[k], relief));
      while (reduced && std::min(levels.back().width, levels.back().height) >= 2 * kFewest)
        levels.push_back(halved(levels.back()));
      skins_[k].shade = std::vector<Vec3f>();
    }
  });
}

// Of detail that runs at an angle to the light, relief has a share of the power that grows with the square of
// the angle's cosine, since only slopes along the light are lit, and stains have the same at any angle. Both
// are estimated as Wiener does, each wave by itself.
Skins::Picture Skins::with_relief(const Detail::Skin& skin, const Detail::Relief& relief) {
  Picture out{skin.width, skin.height, {}};
  out.texels.reserve(skin.shade.size());
  for (const Vec3f& shade : skin.shade) {
    out.texels.push_back(Texel::Zero());
    out.texels.back().head<3>() = shade;
  }
  if (!(relief.strength > 0)) return out;
  const cv::Size size(cv::getOptimalDFTSize(skin.width), cv::getOptimalDFTSize(skin.height));
  cv::Mat shade(skin.height, skin.width, CV_32F), waves;
  for (std::size_t i = 0; i < skin.shade.size(); ++i)
    shade.at<float>(static_cast<int>(i)) = luminance_of(skin.shade[i]);
  shade -= cv::mean(shade);
  cv::copyMakeBorder(shade, shade, 0, size.height - skin.height, 0, size.width - skin.width,
                     cv::BORDER_REPLICATE);
  cv::dft(shade, waves, cv::DFT_COMPLEX_OUTPUT);
  const Eigen::Vector2f along = in_rows(relief.light);
  const Eigen::Vector2f across = in_rows(quarter_turn(relief.light));
  cv::Mat turned = waves.clone();
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector2f wave(static_cast<float>(u > size.width / 2 ? u - size.width : u) / size.width,
                                 static_cast<float>(v > size.height / 2 ? v - size.height : v) / size.height);
      const float a = wave.dot(along), b = wave.dot(across);
      const float all = relief.strength * a * a + wave.squaredNorm();
      waves.at<cv::Vec2f>(v, u) *= all > 0 ? relief.strength * a * a / all : 0;
      turned.at<cv::Vec2f>(v, u) *= all > 0 ? relief.strength * a * b / all : 0;
    }
  for (const auto& [channel, spectrum] : {std::pair(3, &waves), {4, &turned}}) {
    cv::idft(*spectrum, shade, cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
    for (int y = 0; y < skin.height; ++y)
      for (int x = 0; x < skin.width; ++x)
        out.texels[pixel_at(x, y, skin.width)][channel] = shade.at<float>(y, x);
  }
  return out;
}

// What is left of a skin without the faces of its stone, which are evenly light or dark, and without the
// edges between them, which stand out (weighted as by Beaton and Tukey 1974): its texture.
void Skins::remove_faces(Detail::Skin& skin) {
  constexpr int kMostReach = 127;                   // of OpenCV's median, pixels
  constexpr double kReach = 0.075;                  // of the median, in the stone's diameter
  constexpr float kStandsOut = 4.685F * 1.4826F;    // in the median deviation
  constexpr float kLowest = -2, kStep = 1.0F / 64;  // of shades
  cv::Mat shade(skin.height, skin.width, CV_8U), faces;
  for (std::size_t i = 0; i < skin.shade.size(); ++i)
    shade.data[i] = cv::saturate_cast<std::uint8_t>((luminance_of(skin.shade[i]) - kLowest) / kStep);
  const double diameter = 4 * std::sqrt(std::sqrt(skin.spread.determinant()));
  cv::medianBlur(shade, faces, 2 * std::clamp(round_nearest(kReach * diameter), 1, kMostReach) + 1);
  std::vector<float> texture, deviations;
  for (std::size_t i = 0; i < skin.shade.size(); ++i) {
    texture.push_back(luminance_of(skin.shade[i]) - kLowest - kStep * static_cast<float>(faces.data[i]));
    deviations.push_back(std::abs(texture.back()));
  }
  const float most = kStandsOut * median(std::move(deviations));
  for (std::size_t i = 0; i < skin.shade.size(); ++i) {
    const float part = most > 0 ? std::min(1.0F, std::abs(texture[i]) / most) : 1;
    const float kept = texture[i] * (1 - part * part) * (1 - part * part);
    skin.shade[i] += Vec3f::Constant(kept - luminance_of(skin.shade[i]));
  }
}

// Means of four pixels.
Skins::Picture Skins::halved(const Picture& p) {
  Picture out{p.width / 2, p.height / 2, {}};
  out.texels.reserve(pixels_in(out.width, out.height));
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const auto at = [&](int dx, int dy) { return p.texels[pixel_at(2 * x + dx, 2 * y + dy, p.width)]; };
      out.texels.push_back((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4);
    }
  return out;
}

// The picture whose pixels are about as large as those that will show it.
void Skins::fit_level(Worn& worn, double footprint) const {
  const double pixels = footprint * std::sqrt(std::abs(worn.to_skin.leftCols<2>().determinant()));
  const int last = count_of(pictures_[worn.skin]) - 1;
  worn.level = pixels > 1 ? std::min(round_nearest(std::log2(pixels)), last) : 0;
}

// A skin is laid with its relief, which grows with it, so slopes stay, and turns with it.
void Skins::light_up(Worn& worn, const Eigen::Vector2f& photographed,
                     const std::optional<Vec2>& light) const {
  constexpr float kSteepest = 1.5F;  // a skin that is pressed together
  const Eigen::Vector2f toward = light ? Eigen::Vector2f(light->normalized().cast<float>()) : photographed;
  const Eigen::Matrix2f laid = worn.to_skin.leftCols<2>();
  Eigen::Vector2f shown = laid * toward / std::sqrt(std::abs(laid.determinant()));
  if (!shown.allFinite()) return;
  shown *= kSteepest / std::max(kSteepest, shown.norm());
  worn.relit =
      Eigen::Vector2f(shown.dot(in_rows(photographed)) - 1, shown.dot(in_rows(quarter_turn(photographed))));
}

std::optional<Skins::Worn> Skins::own_skin(const Shape& shape, const Particles& particles,
                                           std::size_t particle) const {
  if (faceted_) return {};  // its faces are not the body's
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
  // Half of the skins of other stones are seen in a mirror, left for right, so that fewer look alike; what
  // light is left in them mostly comes from above.
  const Mat2 mirror = Vec2(random.uniform() < 0.5 ? -1 : 1, 1).asDiagonal();
  Worn best;
  best.center = particles.position[particle].cast<float>();
  double least = std::numeric_limits<double>::max();
  for (int k = 0; k < count_of(skins_); ++k) {
    const Detail::Skin& skin = skins_[k];
    const bool is_own = own && own->skin == k;
    double larger = std::log(size / skin.size);
    if (larger > 0)
      larger *= kEnlarged;
    else if (faceted_)
      larger = 0;  // a part of the texture
    double cost = (oklab_[k] - color).squaredNorm() / (kColorSpread * kColorSpread) +
                  larger * larger / (kSizeSpread * kSizeSpread) + hidden_[k] + (is_own ? 0 : kStrange) +
                  kWorn * covers_[k] / usual_cover_ + kChance * random.uniform();
    if (!(cost < least)) continue;
    const Laying laying = is_own     ? Laying{}
                          : faceted_ ? Laying{mirror / pixel_size_}
                                     : lay(transport, mirror, skin.spread.cast<double>());
    cost += laying.cost;
    if (!(cost < least)) continue;  // neither is what is not a number
    least = cost;
    best.skin = k;
    if (!faceted_) best.lost_grain = static_cast<float>(std::clamp(std::log2(size / skin.size), 0.0, 1.0));
    best.start = is_own ? own->start : skin.center;
    if (is_own)
      best.to_skin = own->to_skin;
    else
      best.to_skin << (laying.to_skin * flip).cast<float>(), Eigen::Vector2f::Zero();
  }
  return best;
}

Vec3f Skins::at(const Vec3f& mm, int particle, const Vec3f& color) const {
  const Worn& worn = worn_[particle];
  Vec3f offset = mm - worn.center;
  for (int a = 0; a < 3; ++a) offset[a] -= box_[a] * std::round(offset[a] / box_[a]);
  const Picture& picture = pictures_[worn.skin][worn.level];
  const Eigen::Vector2f at = std::ldexp(1.0F, -worn.level) * (worn.to_skin * offset + worn.start);
  const auto within = [&](int i, int n) { return faceted_ ? mirror_index(i, n) : std::clamp(i, 0, n - 1); };
  const Texel texel = sample(picture.texels, at.x(), at.y(), [&](int x, int y) {
    return pixel_at(within(x, picture.width), within(y, picture.height), picture.width);
  });
  return Detail::with_shade(color, texel.head<3>() + Vec3f::Constant(worn.relit.dot(texel.tail<2>())));
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
