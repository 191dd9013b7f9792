// terrazzo_evidence MODEL PICTURES SEED FILE: writes what a network (ONNX) shows of the regions of synthetic
// pictures, and how much each region overlaps a particle. judge.py learns from it; `./dev train` calls both.
//
// FILE holds 16 floats for each region: its evidence, its largest intersection over union with a particle,
// and the picture's number. Regions that lie mostly on particles without a label are left out.
#include "nodes/segment/evidence.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <vector>

#include "nodes/segment/network_particles.h"
#include "nodes/synthetic_photo/synthetic_photo.h"

namespace {

using namespace terrazzo;

struct Row {
  segment::Evidence evidence;
  float overlap = 0, picture = 0;
};

std::vector<Row> rows_of(const segment::Network& network, std::uint64_t seed, int number) {
  synthetic_photo::PhotoOptions options;
  options.seed = seed;
  options.scene = number % 2 == 0 ? synthetic_photo::Scene::Any : synthetic_photo::Scene::Outcrop;
  const synthetic_photo::Photo photo = synthetic_photo::take_photo(options, {});
  std::vector<std::int64_t> areas(photo.labels.count() + 1, 0);
  for (const auto id : photo.labels.ids) ++areas[id];
  std::vector<Row> rows;
  const segment::NetworkView view(photo.image, 0, network, {});
  view.visit_candidates(segment::NetworkOptions().min_area, {},
                        [&](const segment::Cutout& region, const segment::Evidence& evidence) {
                          std::map<std::int32_t, std::int64_t> shared;
                          std::int64_t unclear = 0, all = 0;
                          for (const auto i : region.pixels(photo.image.width)) {
                            ++all;
                            unclear += photo.unclear.ids[i];
                            if (photo.labels.ids[i] > 0) ++shared[photo.labels.ids[i]];
                          }
                          if (2 * unclear > all) return;
                          double best = 0;
                          for (const auto& [id, n] : shared)
                            best = std::max(
                                best, static_cast<double>(n) / static_cast<double>(areas[id] + all - n));
                          rows.push_back({evidence, static_cast<float>(best), static_cast<float>(number)});
                        });
  return rows;
}

int write_all(const char* model, int pictures, std::uint64_t seed, const char* path) {
  std::ifstream in(model, std::ios::binary);
  const segment::Network network(std::string(std::istreambuf_iterator<char>(in), {}));
  std::FILE* file = std::fopen(path, "wb");
  if (file == nullptr) {
    std::perror(path);
    return 1;
  }
  bool good = true;
  std::size_t count = 0;
  for (int k = 0; k < pictures && good; ++k) {
    const auto rows = rows_of(network, seed + k, k);
    good = std::fwrite(rows.data(), sizeof(Row), rows.size(), file) == rows.size();
    count += rows.size();
    if (k % 50 == 49) std::fprintf(stderr, "%d of %d pictures, %zu regions\n", k + 1, pictures, count);
  }
  if (std::fclose(file) != 0 || !good) {
    std::perror(path);
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: terrazzo_evidence MODEL PICTURES SEED FILE\n");
    return 2;
  }
  try {
    return write_all(argv[1], std::atoi(argv[2]), std::strtoull(argv[3], nullptr, 10), argv[4]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "terrazzo_evidence: %s\n", e.what());
    return 1;
  }
}
