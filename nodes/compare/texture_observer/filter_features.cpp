#include "nodes/compare/texture_observer/filter_features.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "runtime/random.h"

namespace terrazzo::texture_observer {

namespace {

constexpr int kFilters = 40, kEdge = 5, kRow = 3 * kEdge, kPixels = kEdge * kRow;
constexpr int kPatches = 8000;  // for the covariance, half of each class
constexpr int kPerLevel = 4 * kFilters;

static_assert(sizeof(Vec3f) == 3 * sizeof(float));  // rows of pixels are copied as floats

void copy_patch(const Patch& p, int x, int y, float* out) {
  for (int v = 0; v < kEdge; ++v) std::memcpy(out + v * kRow, &p.at(x, y + v), kRow * sizeof(float));
}

// Column j comes from class j % 2. Pairs of columns share their random numbers.
Eigen::MatrixXf random_patches(const std::array<CropRows, 2>& classes, int level, std::uint64_t seed,
                               int count) {
  Eigen::MatrixXf out(kPixels, count);
  for (int j = 0; j < count; ++j) {
    const CropRows& from = classes[j % 2];
    Random random(seed, 811 + level, j / 2);
    const std::size_t row = random.uniform() * from.rows.size();
    const Crop& crop = from.set->crops[from.rows[row]];
    const std::uint64_t places = (from.set->crop >> level) - kEdge + 1;
    const int x = (crop.x >> level) + static_cast<int>(random.below(places)),
              y = (crop.y >> level) + static_cast<int>(random.below(places));
    copy_patch(from.set->cells[crop.cell].levels[level], x, y, out.col(j).data());
  }
  return out;
}

// Sums of one crop: positive responses, negative ones, squares, and roots. Roots show weak responses, such as
// noise between edges.
struct Pool {
  Eigen::Array<double, kFilters, 4> sums = Eigen::Array<double, kFilters, 4>::Zero();

  void add(const Eigen::MatrixXf& responses, int first, int count) {
    using Filters = Eigen::Array<float, kFilters, 1>;
    Filters up = Filters::Zero(), down = up, square = up, root = up;
    for (int k = first; k < first + count; ++k) {
      const Filters r = responses.col(k).array();
      up += r.max(0.0f);
      down += (-r).max(0.0f);
      square += r * r;
      root += r.abs().sqrt();
    }
    sums.col(0) += up.cast<double>();
    sums.col(1) += down.cast<double>();
    sums.col(2) += square.cast<double>();
    sums.col(3) += root.cast<double>();
  }
  Eigen::RowVectorXd features(double count) const {
    Eigen::Array<double, kFilters, 4> out = sums / count;
    out.col(2) = out.col(2).sqrt();
    return Eigen::Map<Eigen::RowVectorXd>(out.data(), out.size());
  }
};

}  // namespace

const std::vector<FeatureGroup>& filter_groups() {
  static const std::vector<FeatureGroup> groups{{"fine detail", 0, kPerLevel},
                                                {"medium detail", kPerLevel, kPerLevel},
                                                {"coarse detail", 2 * kPerLevel, kPerLevel}};
  static_assert(kLevels == 3);
  return groups;
}

FilterBank learn_filters(const std::array<CropRows, 2>& classes, std::uint64_t seed) {
  FilterBank bank;
  for (int level = 0; level < kLevels; ++level) {
    const Eigen::MatrixXd patches = random_patches(classes, level, seed, kPatches).cast<double>();
    const Eigen::VectorXd mean = patches.rowwise().mean();
    const Eigen::MatrixXd centered = patches.colwise() - mean;
    const auto axes = eigen_axes(Eigen::MatrixXd(centered * centered.transpose() / kPatches));
    // What varies less than rounding to 8 bits is not amplified.
    const Eigen::MatrixXd whiten =
        axes.eigenvectors() *
        (axes.eigenvalues().array().max(0) + kRoundingVariance).rsqrt().matrix().asDiagonal() *
        axes.eigenvectors().transpose();
    Eigen::MatrixXd filters = whiten * centered.leftCols(kFilters);
    for (int f = 0; f < kFilters; ++f) filters.col(f) /= filters.col(f).norm() + 1e-9;
    filters = whiten * filters;
    bank.weights[level] = filters.cast<float>();
    bank.offset[level] = (-filters.transpose() * mean).cast<float>();
  }
  return bank;
}

Eigen::MatrixXd filter_features(const CropSet& set, const FilterBank& bank, const Work& work) {
  Eigen::MatrixXd out(set.crops.size(), kLevels * kPerLevel);
  std::vector<std::size_t> first(set.cells.size() + 1, set.crops.size());
  for (std::size_t i = set.crops.size(); i-- > 0;) first[set.crops[i].cell] = i;
  work.parallel(set.cells.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      for (int level = 0; level < kLevels; ++level) {
        const Patch& patch = set.cells[c].levels[level];
        const Eigen::MatrixXf filters = bank.weights[level].transpose();
        const int columns = patch.width - kEdge + 1, window = (set.crop >> level) - kEdge + 1;
        Eigen::MatrixXf pixels(kPixels, columns), responses(kFilters, columns);
        std::vector<Pool> pools(first[c + 1] - first[c]);
        for (int y = 0; y + kEdge <= patch.height; ++y) {
          work.check();
          for (int x = 0; x < columns; ++x) copy_patch(patch, x, y, pixels.col(x).data());
          responses.noalias() = filters * pixels;
          responses.colwise() += bank.offset[level];
          for (std::size_t i = 0; i < pools.size(); ++i) {
            const Crop& crop = set.crops[first[c] + i];
            if (const int top = crop.y >> level; y >= top && y < top + window)
              pools[i].add(responses, crop.x >> level, window);
          }
        }
        for (std::size_t i = 0; i < pools.size(); ++i)
          out.row(first[c] + i).segment(level * kPerLevel, kPerLevel) =
              pools[i].features(static_cast<double>(window) * window);
      }
  });
  return out;
}

}  // namespace terrazzo::texture_observer
