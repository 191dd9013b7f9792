#include "nodes/photograph/segment/network/network.h"

#include <algorithm>
#include <array>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/network/model_pool.h"

// The model's bytes, in the read-only data of the library.
__asm__(
    ".section .rodata\n"
    ".balign 16\n"
    "terrazzo_segment_model:\n"
    ".incbin \"" TERRAZZO_SEGMENT_MODEL
    "\"\n"
    "terrazzo_segment_model_end:\n"
    ".previous\n");
extern "C" const char terrazzo_segment_model[], terrazzo_segment_model_end[];

namespace terrazzo::segment {
namespace {

constexpr int kMultiple = 32;  // the network halves the resolution five times
constexpr int kCore = 768;     // most rows and columns of a tile that are kept
constexpr int kMargin = 64;    // around them, so that the tile's border does not show

int up_to_multiple(int n) { return (n + kMultiple - 1) / kMultiple * kMultiple; }

struct Tile {
  int view = 0;
  cv::Rect core, seen;
};

// The picture at one scale, with mirrored margins that make each side a multiple of 32 and at least 64
// pixels.
struct View {
  int width, height;
  bool mirrored;
  cv::Mat padded, maps[4];

  View(const cv::Mat& picture, double scale)
      : width(std::max(1, round_nearest(picture.cols * scale))),
        height(std::max(1, round_nearest(picture.rows * scale))),
        mirrored(scale >= 1) {
    cv::Mat scaled = picture;
    if (width != picture.cols || height != picture.rows)
      cv::resize(picture, scaled, cv::Size(width, height), 0, 0,
                 scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
    const int w = std::max(2 * kMultiple, up_to_multiple(width)),
              h = std::max(2 * kMultiple, up_to_multiple(height));
    const int kind = width > 1 && height > 1 ? cv::BORDER_REFLECT_101 : cv::BORDER_REPLICATE;
    cv::copyMakeBorder(scaled, padded, 0, h - height, 0, w - width, kind);
    for (auto& m : maps) m.create(h, w, CV_32F);
  }
  void cut(int number, std::vector<Tile>& tiles) const {
    // As many tiles as needed, all about equally large.
    const auto side = [](int all) {
      const int count = (all + kCore - 1) / kCore;
      return up_to_multiple((all + count - 1) / count);
    };
    const int w = side(padded.cols), h = side(padded.rows);
    for (int y = 0; y < padded.rows; y += h)
      for (int x = 0; x < padded.cols; x += w) {
        const cv::Rect all(0, 0, padded.cols, padded.rows), core = cv::Rect(x, y, w, h) & all;
        tiles.push_back(
            {number, core, cv::Rect(x - kMargin, y - kMargin, w + 2 * kMargin, h + 2 * kMargin) & all});
      }
  }
  void keep(const Tile& t, const std::array<cv::Mat, 4>& of_tile) {
    const cv::Rect core(t.core.x - t.seen.x, t.core.y - t.seen.y, t.core.width, t.core.height);
    for (int k = 0; k < 4; ++k) of_tile[k](core).copyTo(maps[k](t.core));
  }
  NetworkMaps maps_of_size(int w, int h) {
    NetworkMaps result;
    result.width = w;
    result.height = h;
    std::vector<float>* planes[4] = {&result.inside, &result.border, &result.distance, &result.not_material};
    for (int k = 0; k < 4; ++k) {
      const cv::Mat m = maps[k](cv::Rect(0, 0, width, height));
      planes[k]->resize(pixels_in(w, h));
      cv::Mat out(h, w, CV_32F, planes[k]->data());
      if (m.size() == out.size())
        m.copyTo(out);
      else
        cv::resize(m, out, out.size(), 0, 0, cv::INTER_LINEAR);
      maps[k].release();
    }
    return result;
  }
};

}  // namespace

cv::Mat encoded_section(const Image& image, int section) {
  return encoded_window(image, section, {0, 0, image.width, image.height});
}

cv::Mat encoded_window(const Image& image, int section, const cv::Rect& window) {
  cv::Mat m(window.size(), CV_32FC3);
  for (int y = 0; y < m.rows; ++y)
    for (int x = 0; x < m.cols; ++x) {
      const Vec3f c =
          linear_to_srgb(image.at(window.x + x, window.y + y, section).cwiseMax(0.0f).cwiseMin(1.0f));
      m.at<cv::Vec3f>(y, x) = cv::Vec3f(c[0], c[1], c[2]);
    }
  return m;
}

std::string built_in_model() { return {terrazzo_segment_model, terrazzo_segment_model_end}; }

struct Network::Model : ModelPool {
  using ModelPool::ModelPool;

  std::array<cv::Mat, 4> maps_of(const cv::Mat& tile) {
    cv::Mat out = run(cv::dnn::blobFromImage(tile));
    if (out.dims != 4 || out.size[0] != 1 || out.size[1] != 4 || out.size[2] != tile.rows ||
        out.size[3] != tile.cols)
      refuse("its output does not have four maps of the input's size");
    std::array<cv::Mat, 4> maps;
    for (int k = 0; k < 4; ++k) maps[k] = cv::Mat(tile.rows, tile.cols, CV_32F, out.ptr<float>(0, k)).clone();
    return maps;
  }
};

Network::Network(std::string bytes)
    : model_(std::make_unique<Model>(
          std::move(bytes),
          "use an ONNX model with one input (1, 3, h, w) and one output (1, 4, h, w): inside, border, "
          "distance, not material")) {}
Network::~Network() = default;

std::vector<NetworkMaps> Network::operator()(const cv::Mat& picture, std::span<const double> scales,
                                             const Work& work) const {
  cv::setNumThreads(1);  // tiles are the unit of parallel work
  std::vector<View> views;
  std::vector<Tile> tiles;
  for (const double scale : scales) {
    views.emplace_back(picture, scale);
    views.back().cut(count_of(views) - 1, tiles);
  }
  // Large tiles first, so that no thread is left alone with one at the end.
  std::stable_sort(tiles.begin(), tiles.end(),
                   [](const Tile& a, const Tile& b) { return a.seen.area() > b.seen.area(); });
  work.parallel(tiles.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      View& view = views[tiles[t].view];
      const cv::Mat tile = view.padded(tiles[t].seen);
      std::array<cv::Mat, 4> maps = model_->maps_of(tile);
      if (view.mirrored) {
        cv::Mat mirrored;
        cv::flip(tile, mirrored, 1);
        std::array<cv::Mat, 4> other = model_->maps_of(mirrored);
        for (int k = 0; k < 4; ++k) {
          cv::flip(other[k], other[k], 1);
          maps[k] = 0.5 * (maps[k] + other[k]);
        }
      }
      view.keep(tiles[t], maps);
    }
  });
  std::vector<NetworkMaps> all(views.size());
  work.quiet().parallel(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) all[k] = views[k].maps_of_size(picture.cols, picture.rows);
  });
  return all;
}

}  // namespace terrazzo::segment
