#include "nodes/photograph/segment/scribbles/scribbles.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <opencv2/ml.hpp>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/components.h"
#include "nodes/common/texture/footprint.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/color/lab_image.h"
#include "nodes/photograph/segment/color/split.h"
#include "runtime/random.h"

namespace terrazzo::segment {
namespace {

constexpr std::array<double, 4> kSigmas{0.7, 1.6, 3.5, 8};
constexpr int kFeatures = 4 * 9;
constexpr int kTrees = 60;
constexpr std::size_t kMostSamples = 4000;  // of each class: more strokes teach little and take long

enum Class { Binder = 0, Particle = 1, NotMaterial = 2 };

// One row per pixel.
cv::Mat features_of(const Image& image, int section, const Work& work) {
  const LabImage lab = lab_section(image, section, work);
  cv::setNumThreads(1);  // one thread per scale
  cv::Mat out(count_of(lab.pixels), kFeatures, CV_32F);
  const cv::Mat color(lab.height, lab.width, CV_32FC3, const_cast<Vec3f*>(lab.pixels.data()));
  work.parallel(kSigmas.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      const double sigma = kSigmas[s];
      const float scale = sigma;
      cv::Mat smooth, plane[3], dx, dy, xx, xy, yy, gradient, txx, txy, tyy;
      cv::GaussianBlur(color, smooth, cv::Size(0, 0), sigma, sigma, cv::BORDER_REFLECT_101);
      cv::split(smooth, plane);
      cv::Sobel(plane[0], dx, CV_32F, 1, 0, 3, 0.125);
      cv::Sobel(plane[0], dy, CV_32F, 0, 1, 3, 0.125);
      cv::Sobel(dx, xx, CV_32F, 1, 0, 3, 0.125), cv::Sobel(dx, xy, CV_32F, 0, 1, 3, 0.125),
          cv::Sobel(dy, yy, CV_32F, 0, 1, 3, 0.125);
      cv::GaussianBlur(dx.mul(dx), txx, cv::Size(0, 0), 1.5 * sigma),
          cv::GaussianBlur(dx.mul(dy), txy, cv::Size(0, 0), 1.5 * sigma),
          cv::GaussianBlur(dy.mul(dy), tyy, cv::Size(0, 0), 1.5 * sigma);
      const auto eigenvalues = [](float a, float b, float c, float* to) {
        const float middle = (a + c) / 2, apart = std::sqrt((a - c) * (a - c) / 4 + b * b);
        to[0] = middle + apart;
        to[1] = middle - apart;
      };
      for (int y = 0; y < lab.height; ++y)
        for (int x = 0; x < lab.width; ++x) {
          float* f = out.ptr<float>(y * lab.width + x) + 9 * s;
          for (int k = 0; k < 3; ++k) f[k] = plane[k].at<float>(y, x);
          const float gx = dx.at<float>(y, x), gy = dy.at<float>(y, x);
          f[3] = scale * std::sqrt(gx * gx + gy * gy);
          f[4] = scale * scale * (xx.at<float>(y, x) + yy.at<float>(y, x));
          eigenvalues(scale * scale * xx.at<float>(y, x), scale * scale * xy.at<float>(y, x),
                      scale * scale * yy.at<float>(y, x), f + 5);
          eigenvalues(txx.at<float>(y, x), txy.at<float>(y, x), tyy.at<float>(y, x), f + 7);
          f[7] = scale * std::sqrt(std::max(0.0f, f[7]));
          f[8] = scale * std::sqrt(std::max(0.0f, f[8]));
        }
    }
  });
  return out;
}

}  // namespace

struct ScribbleForest::Forest {
  cv::Ptr<cv::ml::RTrees> trees;
};

ScribbleForest::ScribbleForest(const Image& image, int of_section, const Scribbles& scribbles,
                               std::uint64_t seed, const Work& work)
    : forest_(std::make_unique<Forest>()) {
  const cv::Mat features = features_of(image, of_section, work);
  std::vector<std::pair<std::uint32_t, int>> samples;
  const std::array<std::pair<const Strokes*, Class>, 3> given{
      {{scribbles.particles, Particle}, {scribbles.binder, Binder}, {scribbles.not_material, NotMaterial}}};
  for (const auto& [strokes, cls] : given) {
    std::vector<std::uint32_t> pixels;
    if (strokes)
      for (const Stroke& s : strokes->strokes) {
        const auto covered = footprint_of(s, image.width, image.height);
        pixels.insert(pixels.end(), covered.begin(), covered.end());
      }
    std::sort(pixels.begin(), pixels.end());
    pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
    if (pixels.empty() && cls != NotMaterial)
      throw Error(
          "no-strokes", std::string("no pixel is marked as ") + (cls == Particle ? "particle" : "binder"),
          "connect strokes on particles to particle_strokes and strokes on the binder to binder_strokes");
    Random random(seed, 0x5c1b, static_cast<std::uint64_t>(cls));
    for (std::size_t k = 0; k < std::min(kMostSamples, pixels.size()); ++k) {
      std::swap(pixels[k], pixels[k + random.below(pixels.size() - k)]);
      samples.emplace_back(pixels[k], cls);
    }
  }
  cv::Mat x(count_of(samples), kFeatures, CV_32F), answers(x.rows, 1, CV_32S);
  for (int k = 0; k < x.rows; ++k) {
    features.row(static_cast<int>(samples[k].first)).copyTo(x.row(k));
    answers.at<int>(k) = samples[k].second;
  }
  auto& trees = forest_->trees;
  trees = cv::ml::RTrees::create();
  trees->setMaxDepth(14);
  trees->setMinSampleCount(3);
  trees->setActiveVarCount(6);
  trees->setTermCriteria({cv::TermCriteria::MAX_ITER, kTrees, 0});
  cv::setRNGSeed(static_cast<int>(mix64(seed) & 0x7fffffff));
  trees->train(cv::ml::TrainData::create(x, cv::ml::ROW_SAMPLE, answers));
}

ScribbleForest::~ScribbleForest() = default;

ScribbleMaps ScribbleForest::classify(const Image& image, int section, const Work& work) const {
  const cv::Mat features = features_of(image, section, work.part(0, 0.3));
  ScribbleMaps maps;
  maps.particle.assign(features.rows, 0);
  maps.not_material.assign(features.rows, 0);
  work.part(0.3, 1).parallel(features.rows, 4096, [&](std::size_t begin, std::size_t end) {
    cv::Mat votes;
    forest_->trees->getVotes(features.rowRange(static_cast<int>(begin), static_cast<int>(end)), votes, 0);
    // The first row names the class of each column.
    for (int c = 0; c < votes.cols; ++c) {
      auto* map = votes.at<int>(0, c) == Particle      ? &maps.particle
                  : votes.at<int>(0, c) == NotMaterial ? &maps.not_material
                                                       : nullptr;
      if (!map) continue;
      for (std::size_t i = begin; i < end; ++i)
        (*map)[i] = static_cast<float>(votes.at<int>(static_cast<int>(i - begin) + 1, c)) / kTrees;
    }
  });
  return maps;
}

Particles2D find_particles_by_scribbles(const ScribbleMaps& maps, int width, int height,
                                        const SplitOptions& options, const Work& work) {
  // Single pixels change sides; their neighbors know better.
  std::vector<float> share = maps.particle;
  cv::Mat m(height, width, CV_32F, share.data());
  cv::GaussianBlur(m, m, cv::Size(0, 0), 1, 1, cv::BORDER_REFLECT_101);
  Particles2D out;
  out.min_area = options.min_area >= 0 ? options.min_area : 25;
  std::vector<std::int32_t> raster(share.size(), 0);
  for (std::size_t i = 0; i < share.size(); ++i) raster[i] = share[i] > 0.5f && maps.not_material[i] < 0.5f;
  if (options.strength > 0) raster = split_at_necks(raster, width, height, options.strength, work);
  const Components parts = connected_components(raster, width, height, false);
  out.labels = parts.ids;
  for (const auto size : parts.sizes)
    if (size < out.min_area) {
      ++out.specks;
      out.speck_pixels += size;
    }
  for (auto& l : out.labels)
    if (l != 0 && parts.sizes[l - 1] < out.min_area) l = 0;
  renumber_labels(out.labels);
  out.coverage.resize(share.size());
  for (std::size_t i = 0; i < share.size(); ++i)
    out.coverage[i] = out.labels[i] > 0 ? std::max(0.5f, share[i]) : std::min(0.499f, share[i]);
  return out;
}

}  // namespace terrazzo::segment
