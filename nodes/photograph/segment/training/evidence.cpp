// terrazzo_evidence MODEL PICTURES SEED FILE [CLOSE_UPS]: writes what a network (ONNX) shows of the regions
// of synthetic pictures, and how much each region overlaps a particle. judge.py learns from it; `./dev train`
// calls both.
//
// FILE holds 16 floats for each region: its evidence, its largest intersection over union with a particle,
// and the picture's number. Regions that lie mostly on particles without a label are left out.
// CLOSE_UPS holds a record for each region that is worth a close look.
#include "nodes/photograph/segment/network/evidence.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "nodes/photograph/segment/network/judge.h"
#include "nodes/photograph/segment/network/network_particles.h"
#include "nodes/photograph/synthetic_photo/synthetic_photo.h"

namespace {

using namespace terrazzo;

constexpr int kPixels = segment::kCloseUp * segment::kCloseUp;

struct Row {
  segment::Evidence evidence;
  float overlap = 0, picture = 0;
};

// What the second network learns from: the planes and, as the last one, the particle that the region overlaps
// most, as bytes.
struct Record {
  float scale = 0;    // the planes' constant
  float outside = 0;  // area of the particle that the square does not show, in its pixels
  float overlap = 0;
  std::uint8_t planes[segment::kCloseUpPlanes][kPixels];  // the last one: the particle
};

struct Rows {
  std::vector<Row> rows;
  std::vector<Record> records;
};

void put(std::uint8_t* to, const cv::Mat& plane, double gain, double offset) {
  cv::Mat bytes(plane.rows, plane.cols, CV_8U, to);
  plane.convertTo(bytes, CV_8U, gain, offset);
}

Record record_of(const segment::CloseUp& seen, const synthetic_photo::Photo& photo, std::int32_t particle,
                 double area) {
  Record r;
  for (int k = 0; k < 3; ++k) put(r.planes[k], seen.planes[k], 32, 128);
  for (int k = 3; k < 9; ++k) put(r.planes[k], seen.planes[k], 255, 0);
  r.scale = seen.planes[9].at<float>(0, 0);
  cv::Mat mask(photo.image.height, photo.image.width, CV_32F, cv::Scalar(0));
  if (particle > 0)
    for (std::size_t i = 0; i < photo.labels.ids.size(); ++i)
      if (photo.labels.ids[i] == particle)
        mask.at<float>(static_cast<int>(i) / photo.image.width, static_cast<int>(i) % photo.image.width) = 1;
  const double shown = cv::sum(mask(seen.square & cv::Rect(0, 0, mask.cols, mask.rows)))[0];
  const double shrink = static_cast<double>(segment::kCloseUp) / seen.square.width;
  r.outside = (area - shown) * shrink * shrink;
  put(r.planes[9], segment::seen_close(mask, seen.square), 255, 0);
  return r;
}

synthetic_photo::Scene scene_of(int number) {
  using synthetic_photo::Scene;
  return number % 9 == 8 ? Scene::Alloy : number % 2 == 0 ? Scene::Any : Scene::Outcrop;
}

Rows rows_of(const segment::Network& network, std::uint64_t seed, int number, bool closely) {
  synthetic_photo::PhotoOptions options;
  options.seed = seed;
  options.scene = scene_of(number);
  const synthetic_photo::Photo photo = synthetic_photo::take_photo(options, {});
  std::vector<std::int64_t> areas(photo.labels.count() + 1, 0);
  for (const auto id : photo.labels.ids) ++areas[id];
  Rows out;
  const segment::NetworkView view(photo.image, 0, 1, network, {});
  view.visit_candidates(
      segment::NetworkOptions().min_area, {},
      [&](const segment::Cutout& region, const segment::Evidence& evidence, const segment::ScaleView& scale) {
        std::map<std::int32_t, std::int64_t> shared;
        std::int64_t unclear = 0, all = 0;
        for (const auto i : region.pixels(photo.image.width)) {
          ++all;
          unclear += photo.unclear.ids[i];
          if (photo.labels.ids[i] > 0) ++shared[photo.labels.ids[i]];
        }
        if (2 * unclear > all) return;
        double best = 0;
        std::int32_t particle = 0;
        for (const auto& [id, n] : shared)
          if (const double overlap = static_cast<double>(n) / (areas[id] + all - n); overlap > best) {
            best = overlap;
            particle = id;
          }
        out.rows.push_back({evidence, static_cast<float>(best), static_cast<float>(number)});
        if (!closely) return;
        const float score = segment::built_in_judge()(std::span(&evidence, 1))[0];
        // Many regions are versions of each other, and those that the judge rejects are mostly alike.
        if (out.rows.size() % (score < 0.2f ? 64 : 6) != 0) return;
        Record r =
            record_of(view.look_closely(region, scale), photo, particle, areas[particle] * (particle > 0));
        r.overlap = best;
        out.records.push_back(r);
      });
  return out;
}

int write_all(const char* model, int pictures, std::uint64_t seed, const char* path, const char* close_ups) {
  std::ifstream in(model, std::ios::binary);
  const segment::Network network(std::string(std::istreambuf_iterator<char>(in), {}));
  std::FILE* file = std::fopen(path, "wb");
  std::FILE* close = close_ups ? std::fopen(close_ups, "wb") : nullptr;
  if (file == nullptr || (close_ups && close == nullptr)) {
    std::perror(file ? close_ups : path);
    return 1;
  }
  bool good = true;
  std::size_t count = 0, looked = 0;
  for (int k = 0; k < pictures && good; ++k) {
    const Rows out = rows_of(network, seed + k, k, close != nullptr);
    good = std::fwrite(out.rows.data(), sizeof(Row), out.rows.size(), file) == out.rows.size();
    if (close)
      good = good &&
             std::fwrite(out.records.data(), sizeof(Record), out.records.size(), close) == out.records.size();
    count += out.rows.size();
    looked += out.records.size();
    if (k % 50 == 49)
      std::fprintf(stderr, "%d of %d pictures, %zu regions, %zu close-ups\n", k + 1, pictures, count, looked);
  }
  if (close) good = std::fclose(close) == 0 && good;
  if (std::fclose(file) != 0 || !good) {
    std::perror(path);
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5 && argc != 6) {
    std::fprintf(stderr, "usage: terrazzo_evidence MODEL PICTURES SEED FILE [CLOSE_UPS]\n");
    return 2;
  }
  try {
    return write_all(argv[1], std::atoi(argv[2]), std::strtoull(argv[3], nullptr, 10), argv[4],
                     argc == 6 ? argv[5] : nullptr);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "terrazzo_evidence: %s\n", e.what());
    return 1;
  }
}
