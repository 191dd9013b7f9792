#include "nodes/packing/measure3d/thickness.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "nodes/common/geometry/periodic.h"
#include "nodes/packing/measure3d/distance.h"
#include "runtime/memory.h"

namespace terrazzo::measure3d {
namespace {

// Lengths are in units of the shortest edge of a voxel.
struct Ball {
  float square;  // of the radius
  int x, y, z;   // voxel of the center
};

// The nearest voxel outside is exactly as far as a ball's radius, and must stay outside after rounding if
// voxels are not cubes. If they are, distances are exact up to radii of 2000 voxels.
constexpr double kRounding = 2.5e-7;

// The largest whole h ≥ 0 with w·h² < square, for square > 0.
int reach_of(double square, double w) {
  int h = static_cast<int>(std::sqrt(square / w));
  if (w * h * h >= square) --h;
  return h;
}

// How large the ball at a neighbor must be to contain a ball: by the squared radius of the ball, rounded up,
// and by the axes along which the neighbor is one voxel away (bits 0 to 2).
class Containment {
 public:
  Containment(const Vec3& w, double largest, const Work& work) {
    const auto size = static_cast<std::size_t>(std::ceil(largest)) + 1;
    for (auto& table : least_) table.assign(size, 0);
    const Vec3i most(reach_of(largest, w.x()), reach_of(largest, w.y()), reach_of(largest, w.z()));
    for (int z = 0; z <= most.z(); ++z) {
      work.check();
      for (int y = 0; y <= most.y(); ++y) {
        const double rest = w.z() * z * z + w.y() * y * y;
        for (int x = 0; x <= most.x() && rest + w.x() * x * x < largest; ++x) {
          const double square = rest + w.x() * x * x;
          const double farther[] = {w.x() * (2 * x + 1), w.y() * (2 * y + 1), w.z() * (2 * z + 1)};
          for (std::size_t axes = 1; axes < 8; ++axes) {
            double away = square;
            for (std::size_t a = 0; a < 3; ++a)
              if (axes >> a & 1) away += farther[a];
            float& least = least_[axes][static_cast<std::size_t>(square) + 1];
            least = std::max(least, static_cast<float>(away));
          }
        }
      }
    }
    for (auto& table : least_)
      for (std::size_t k = 1; k < size; ++k) table[k] = std::max(table[k], table[k - 1]);
  }

  // Squared radii above which the balls at the neighbors contain one of squared radius `square`, by axes.
  // Never too small; if voxels are not cubes, rounding may make them too large.
  std::array<float, 8> least(float square) const {
    constexpr float kSafe = 1 + 4 * static_cast<float>(kRounding);
    std::array<float, 8> out{std::numeric_limits<float>::infinity()};  // no ball contains itself
    for (std::size_t axes = 1; axes < 8; ++axes)
      out[axes] = least_[axes][static_cast<std::size_t>(std::ceil(square))] * kSafe;
    return out;
  }

 private:
  std::array<std::vector<float>, 8> least_;
};

// Adds the balls of a row that no ball at a neighbor contains.
void add_balls(const Classes& classes, const std::vector<float>& square, int y, int z,
               const Containment& containment, std::vector<Ball>& balls) {
  const Vec3i& n = classes.box.size;
  // Outside a box that does not wrap, a row or voxel stands for its neighbor. It asks for more of a ball that
  // is asked anyway, or of the ball itself, which is never large enough.
  const auto near = [&](int i, int size) {
    return classes.box.periodic ? wrap_index(i, size) : std::clamp(i, 0, size - 1);
  };
  const float* rows[9];
  for (int k = 0; k < 9; ++k)
    rows[k] = &square[voxel_at(0, near(y + k % 3 - 1, n.y()), near(z + k / 3 - 1, n.z()), n)];
  constexpr std::size_t kAxes[9] = {6, 4, 6, 2, 0, 2, 6, 4, 6};  // along which the row is one away
  const std::uint8_t* of = &classes.of[voxel_at(0, y, z, n)];
  for (int x = 0; x < n.x(); ++x) {
    const float mine = rows[4][x];
    if (!classes.wanted[of[x]] || !std::isfinite(mine)) continue;
    const auto least = containment.least(mine);
    const int left = near(x - 1, n.x()), right = near(x + 1, n.x());
    bool contained = false;
    for (std::size_t k = 0; k < 9 && !contained; ++k) {
      const float* row = rows[k];
      contained = std::max(row[left], row[right]) > least[kAxes[k] | 1] || row[x] > least[kAxes[k]];
    }
    if (!contained) balls.push_back({mine, x, y, z});
  }
}

// The balls to be drawn, largest first.
std::vector<Ball> balls_of(const Classes& classes, const std::vector<float>& square, const Work& work) {
  const Vec3i& n = classes.box.size;
  const float largest = work.reduce<float>(
      square.size(), 1 << 18, 0,
      [&](std::size_t begin, std::size_t end) {
        float most = 0;
        for (std::size_t i = begin; i < end; ++i)
          if (std::isfinite(square[i])) most = std::max(most, square[i]);
        return most;
      },
      [](float a, float b) { return std::max(a, b); });
  const Containment containment(squared_edges(classes.box.spacing), largest, work);
  auto balls = work.reduce<std::vector<Ball>>(
      n.z(), 1, {},
      [&](std::size_t begin, std::size_t end) {
        std::vector<Ball> part;
        for (int z = begin; z < static_cast<int>(end); ++z)
          for (int y = 0; y < n.y(); ++y) add_balls(classes, square, y, z, containment, part);
        return part;
      },
      [](std::vector<Ball> a, const std::vector<Ball>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      });
  work.check();
  // Balls of one size give one thickness, so their order does not matter.
  std::sort(balls.begin(), balls.end(), [](const Ball& a, const Ball& b) { return a.square > b.square; });
  return balls;
}

// Some planes of the volume, on which balls are drawn by decreasing size.
class Slab {
 public:
  // `out`: the whole volume's diameters. Voxels with `skip` are not drawn.
  template <class Skip>
  Slab(const VoxelBox& box, int begin, int end, float* out, Skip&& skip)
      : box_(box), n_(box.size), w_(squared_edges(box.spacing)), begin_(begin), end_(end), out_(out) {
    words_ = n_.x() / 64 + 1;
    const std::size_t first = voxel_at(0, 0, begin, n_), rows = pixels_in(n_.y(), end - begin);
    open_.assign(rows * words_, 0);
    for (std::size_t row = 0; row < rows; ++row)
      for (int x = 0; x < n_.x(); ++x)
        if (!skip(first + row * n_.x() + x)) {
          open_[row * words_ + x / 64] |= std::uint64_t{1} << x % 64;
          ++left_;
        }
  }

  bool full() const { return left_ == 0; }

  void draw(const Ball& ball, float diameter) {
    if (!meets(ball)) return;
    for (int z = begin_; z < end_; ++z) {
      int dz = std::abs(z - ball.z);
      if (box_.periodic) dz = std::min(dz, n_.z() - dz);
      const double rest = ball.square * (1 - kRounding) - w_.z() * dz * dz;
      if (!(rest > 0)) continue;
      int reach = reach_of(rest, w_.x());
      for (int dy = 0; dy < n_.y(); ++dy) {
        const double row_rest = rest - w_.y() * dy * dy;
        if (!(row_rest > 0) || (box_.periodic && 2 * dy > n_.y())) break;
        while (w_.x() * reach * reach >= row_rest) --reach;
        draw_row(z, ball.y - dy, ball.x, reach, diameter);
        if (dy > 0) draw_row(z, ball.y + dy, ball.x, reach, diameter);
      }
    }
  }

 private:
  const VoxelBox& box_;
  Vec3i n_;
  Vec3 w_;
  int begin_, end_;
  float* out_;
  std::size_t words_;                // of a row
  std::vector<std::uint64_t> open_;  // bits of voxels that are still to be drawn
  std::size_t left_ = 0;             // number of these

  // Most balls are far from the slab.
  bool meets(const Ball& ball) const {
    if (ball.z >= begin_ && ball.z < end_) return true;
    int away = ball.z < begin_ ? begin_ - ball.z : ball.z - end_ + 1;
    if (box_.periodic) away = std::min(away, n_.z() - away - (end_ - begin_) + 1);
    return w_.z() * away * away < ball.square;
  }

  // Draws the voxels x − reach to x + reach of row y, which may be outside the box.
  void draw_row(int z, int y, int x, int reach, float diameter) {
    const int last = n_.x() - 1;
    if (y < 0 || y >= n_.y()) {
      if (!box_.periodic) return;
      y += y < 0 ? n_.y() : -n_.y();
    }
    const int low = x - reach, high = x + reach;
    if (box_.periodic && high - low >= last) return fill(z, y, 0, last, diameter);
    fill(z, y, std::max(low, 0), std::min(high, last), diameter);
    if (!box_.periodic) return;
    if (low < 0) fill(z, y, low + n_.x(), last, diameter);
    if (high > last) fill(z, y, 0, high - n_.x(), diameter);
  }

  void fill(int z, int y, int low, int high, float diameter) {
    std::uint64_t* open = &open_[pixel_at(y, z - begin_, n_.y()) * words_];
    for (int word = low / 64; word <= high / 64; ++word) {
      std::uint64_t bits = open[word];
      if (word == low / 64) bits &= ~std::uint64_t{0} << low % 64;
      if (word == high / 64) bits &= ~std::uint64_t{0} >> (63 - high % 64);
      if (bits == 0) continue;
      open[word] &= ~bits;
      left_ -= std::popcount(bits);
      float* out = out_ + voxel_at(0, y, z, n_) + word * 64;
      for (; bits != 0; bits &= bits - 1) out[std::countr_zero(bits)] = diameter;
    }
  }
};

}  // namespace

std::vector<float> local_thickness(const Classes& classes, std::uint64_t memory, const Work& work) {
  constexpr std::size_t kPlanes = 8, kBalls = 4096;
  constexpr double kVoxelBytes = 20;  // distance, thickness and, of one in three, a ball in two lists
  require_memory(kVoxelBytes * classes.of.size(), memory, "the local thickness");
  const auto square = squared_distances(classes, memory, work.part(0, 0.1));
  std::vector<float> out(square.size(), 0);
  const auto balls = balls_of(classes, square, work.part(0.1, 0.2).quiet());
  const double unit = classes.box.spacing.minCoeff();
  work.part(0.2, 1).parallel(classes.box.size.z(), kPlanes, [&](std::size_t begin, std::size_t end) {
    Slab slab(classes.box, begin, end, out.data(),
              [&](std::size_t i) { return !classes.wanted[classes.of[i]] || !std::isfinite(square[i]); });
    for (std::size_t k = 0; k < balls.size() && !slab.full(); ++k) {
      if (k % kBalls == 0) work.check();
      slab.draw(balls[k], static_cast<float>(2 * unit * std::sqrt(static_cast<double>(balls[k].square))));
    }
  });
  return out;
}

namespace {

struct ThicknessSums {
  double voxels = 0, sum = 0, squares = 0, most = 0;
};

}  // namespace

std::vector<ThicknessDistribution> thickness_distributions(const Classes& classes,
                                                           const std::vector<float>& diameter,
                                                           const Work& work) {
  constexpr std::size_t kGrain = 1 << 18, kMostBins = 40;
  using Sums = std::vector<ThicknessSums>;
  const Sums all = work.reduce<Sums>(
      diameter.size(), kGrain, Sums(classes.count()),
      [&](std::size_t begin, std::size_t end) {
        Sums part(classes.count());
        for (std::size_t i = begin; i < end; ++i) {
          const double d = diameter[i];
          ThicknessSums& s = part[classes.of[i]];
          s.voxels += d > 0;
          s.sum += d;
          s.squares += d * d;
          s.most = std::max(s.most, d);
        }
        return part;
      },
      [](Sums a, const Sums& b) {
        for (std::size_t k = 0; k < a.size(); ++k)
          a[k] = {a[k].voxels + b[k].voxels, a[k].sum + b[k].sum, a[k].squares + b[k].squares,
                  std::max(a[k].most, b[k].most)};
        return a;
      });
  std::vector<ThicknessDistribution> out(all.size());
  std::vector<double> width(all.size(), 1);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!(all[k].voxels > 0)) continue;
    out[k].mean = all[k].sum / all[k].voxels;
    out[k].deviation = std::sqrt(std::max(0.0, all[k].squares / all[k].voxels - out[k].mean * out[k].mean));
    width[k] = std::max(classes.box.spacing.minCoeff(), all[k].most / kMostBins);
    out[k].share.assign(static_cast<std::size_t>(all[k].most / width[k] + 1e-6) + 1, 0);
    for (std::size_t b = 0; b <= out[k].share.size(); ++b) out[k].edges.push_back(b * width[k]);
  }
  for (std::size_t i = 0; i < diameter.size(); ++i) {
    if (i % kGrain == 0) work.check();
    if (!(diameter[i] > 0)) continue;
    const std::size_t k = classes.of[i];
    // A diameter on an edge belongs above it whatever its rounding.
    ++out[k].share[static_cast<std::size_t>(diameter[i] / width[k] + 1e-6)];
  }
  for (std::size_t k = 0; k < all.size(); ++k)
    for (double& share : out[k].share) share /= all[k].voxels;
  return out;
}

}  // namespace terrazzo::measure3d
