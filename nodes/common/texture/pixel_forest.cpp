#include "nodes/common/texture/pixel_forest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/ml.hpp>

#include "nodes/common/texture/color.h"
#include "nodes/common/texture/footprint.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

constexpr std::array<double, 4> kSigmas{0.7, 1.6, 3.5, 8};
constexpr int kFeatures = 4 * 9;
constexpr int kTrees = 60;
constexpr std::size_t kMostSamples = 4000;  // of each class: more strokes teach little and take long

// One row per pixel.
cv::Mat features_of(const Image& image, int section, const Work& work) {
  const int width = image.width, height = image.height;
  std::vector<Vec3f> lab(pixels_in(width, height));
  const Vec3f* first = image.pixels.data() + image.index(0, 0, section);
  work.quiet().parallel(lab.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) lab[i] = linear_to_oklab(first[i]);
  });
  cv::setNumThreads(1);  // one thread per scale
  cv::Mat out(count_of(lab), kFeatures, CV_32F);
  const cv::Mat color(height, width, CV_32FC3, lab.data());
  work.parallel(kSigmas.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      const double sigma = kSigmas[s];
      const float scale = sigma;
      cv::Mat smooth, plane[3], dx, dy, xx, xy, yy, txx, txy, tyy;
      cv::GaussianBlur(color, smooth, cv::Size(0, 0), sigma, sigma, cv::BORDER_REFLECT_101);
      cv::split(smooth, plane);
      cv::Sobel(plane[0], dx, CV_32F, 1, 0, 3, 0.125);
      cv::Sobel(plane[0], dy, CV_32F, 0, 1, 3, 0.125);
      cv::Sobel(dx, xx, CV_32F, 1, 0, 3, 0.125);
      cv::Sobel(dx, xy, CV_32F, 0, 1, 3, 0.125);
      cv::Sobel(dy, yy, CV_32F, 0, 1, 3, 0.125);
      cv::GaussianBlur(dx.mul(dx), txx, cv::Size(0, 0), 1.5 * sigma);
      cv::GaussianBlur(dx.mul(dy), txy, cv::Size(0, 0), 1.5 * sigma);
      cv::GaussianBlur(dy.mul(dy), tyy, cv::Size(0, 0), 1.5 * sigma);
      const auto eigenvalues = [](float a, float b, float c, float* to) {
        const float middle = (a + c) / 2, apart = std::sqrt((a - c) * (a - c) / 4 + b * b);
        to[0] = middle + apart;
        to[1] = middle - apart;
      };
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          float* f = out.ptr<float>(y * width + x) + 9 * s;
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

std::vector<std::uint32_t> stroked_pixels(const Strokes* strokes, int width, int height) {
  std::vector<std::uint32_t> pixels;
  if (strokes)
    for (const Stroke& s : strokes->strokes) {
      const auto covered = footprint_of(s, width, height);
      pixels.insert(pixels.end(), covered.begin(), covered.end());
    }
  std::sort(pixels.begin(), pixels.end());
  pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
  return pixels;
}

struct PixelForest::Forest {
  cv::Ptr<cv::ml::RTrees> trees;
};

PixelForest::PixelForest(const Image& image, int section, const std::vector<TaughtClass>& taught,
                         std::uint64_t seed, const Work& work)
    : forest_(std::make_unique<Forest>()) {
  const cv::Mat features = features_of(image, section, work);
  std::vector<std::pair<std::uint32_t, int>> samples;
  for (const TaughtClass& t : taught) {
    auto pixels = t.pixels;
    Random random(seed, 0x5c1b, static_cast<std::uint64_t>(t.number));
    for (std::size_t k = 0; k < std::min(kMostSamples, pixels.size()); ++k) {
      std::swap(pixels[k], pixels[k + random.below(pixels.size() - k)]);
      samples.emplace_back(pixels[k], t.number);
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

PixelForest::~PixelForest() = default;

std::vector<std::vector<float>> PixelForest::classify(const Image& image, int section, int classes,
                                                      const Work& work) const {
  const cv::Mat features = features_of(image, section, work.part(0, 0.3));
  std::vector<std::vector<float>> out(classes, std::vector<float>(features.rows, 0));
  work.part(0.3, 1).parallel(features.rows, 4096, [&](std::size_t begin, std::size_t end) {
    cv::Mat votes;
    forest_->trees->getVotes(features.rowRange(static_cast<int>(begin), static_cast<int>(end)), votes, 0);
    // The first row names the class of each column.
    for (int c = 0; c < votes.cols; ++c) {
      const int number = votes.at<int>(0, c);
      if (number < 0 || number >= classes) continue;
      for (std::size_t i = begin; i < end; ++i)
        out[number][i] = static_cast<float>(votes.at<int>(static_cast<int>(i - begin) + 1, c)) / kTrees;
    }
  });
  return out;
}

}  // namespace terrazzo
