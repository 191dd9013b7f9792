#include "nodes/compare/texture_observer/crops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::texture_observer {

namespace {

void check_pixels(const Image& image, const std::string& name, const Work& work) {
  if (image.width <= 0 || image.height <= 0 || image.sections <= 0 || image.pixels.empty())
    throw Error("empty-image", fmt::format("image {} has no pixels", name), "connect an image");
  const std::size_t bad = work.reduce(
      image.pixels.size(), 1 << 16, image.pixels.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          if (!image.pixels[i].allFinite()) return i;
        return image.pixels.size();
      },
      [](std::size_t first, std::size_t second) { return std::min(first, second); });
  if (bad < image.pixels.size()) {
    const std::size_t row = bad / image.width;
    throw Error("bad-pixels", fmt::format("image {} has a non-finite pixel at ({}, {}) of section {}", name,
                                          bad % image.width, row % image.height, row / image.height));
  }
}

// As an 8-bit sRGB display shows it.
Vec3f displayed(const Vec3f& linear) {
  static const std::array<float, 256> decoded = [] {
    std::array<float, 256> table;
    for (int i = 0; i < 256; ++i) table[i] = srgb_to_linear(Vec3f::Constant(static_cast<float>(i) / 255))[0];
    return table;
  }();
  const Vec3f encoded = linear_to_srgb(linear.cwiseMax(0.0f).cwiseMin(1.0f)) * 255.0f;
  Eigen::Vector3i code;
  for (int k = 0; k < 3; ++k) code[k] = std::clamp(round_nearest(encoded[k]), 0, 255);
  Vec3f lab = linear_to_oklab(Vec3f(decoded[code[0]], decoded[code[1]], decoded[code[2]]));
  if (code[0] == code[1] && code[1] == code[2]) lab[1] = lab[2] = 0;  // rounding leaves a trace of color
  return lab;
}

void read_pixels(const Image& image, int scale, int crop, CropCell& cell) {
  Patch& full = cell.levels[0];
  full.width = cell.columns * crop;
  full.height = cell.rows * crop;
  full.lab.resize(pixels_in(full.width, full.height));
  const float share = 1.0f / (scale * scale);
  for (int y = 0; y < full.height; ++y)
    for (int x = 0; x < full.width; ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int v = 0; v < scale; ++v)
        for (int u = 0; u < scale; ++u)
          sum += image.at((cell.x + x) * scale + u, (cell.y + y) * scale + v, cell.section);
      full.lab[pixel_at(x, y, full.width)] = displayed(sum * share);
    }
  for (int level = 1; level < kLevels; ++level) {
    const Patch& fine = cell.levels[level - 1];
    Patch& coarse = cell.levels[level];
    coarse.width = fine.width / 2;
    coarse.height = fine.height / 2;
    for (int y = 0; y < coarse.height; ++y)
      for (int x = 0; x < coarse.width; ++x)
        coarse.lab.push_back((fine.at(2 * x, 2 * y) + fine.at(2 * x + 1, 2 * y) + fine.at(2 * x, 2 * y + 1) +
                              fine.at(2 * x + 1, 2 * y + 1)) /
                             4);
  }
}

// All cells of one half in random order.
std::vector<CropCell> cells_of(int width, int height, int sections, bool right, const CropOptions& choice) {
  const int half = width / 2, columns = half / choice.crop, rows = height / choice.crop;
  // Few crops need cells of a single crop, so that a checkerboard has squares of both colors.
  const bool paired = (columns / 2) * (rows / 2) * static_cast<double>(sections) >= 4;
  const int across = paired ? columns / 2 : columns, down = paired ? rows / 2 : rows;
  const int left = (right ? width - half : 0) + (half - columns * choice.crop) / 2,
            top = (height - rows * choice.crop) / 2;
  std::vector<CropCell> cells;
  for (int s = 0; s < sections; ++s)
    for (int j = 0; j < down; ++j)
      for (int i = 0; i < across; ++i) {
        const int column = i * columns / across, row = j * rows / down;
        CropCell cell;
        cell.section = s;
        cell.x = left + column * choice.crop;
        cell.y = top + row * choice.crop;
        cell.columns = (i + 1) * columns / across - column;
        cell.rows = (j + 1) * rows / down - row;
        cell.strip = ((static_cast<std::int64_t>(s) * down + j) * across + i) * kStrips /
                     (static_cast<std::int64_t>(sections) * down * across);
        cell.odd = (i + j + s) % 2;
        cells.push_back(std::move(cell));
      }
  Random random(choice.seed, 801, right);
  for (std::size_t i = cells.size(); i > 1; --i) std::swap(cells[i - 1], cells[random.below(i)]);
  // Both colors of the checkerboard in turn, so that the first few cells have both.
  std::stable_partition(cells.begin(), cells.end(), [](const CropCell& c) { return !c.odd; });
  const std::size_t odd = std::count_if(cells.begin(), cells.end(), [](const CropCell& c) { return c.odd; });
  const std::size_t even = cells.size() - odd, pairs = std::min(even, odd);
  std::vector<CropCell> mixed;
  for (std::size_t i = 0; i < pairs; ++i) {
    mixed.push_back(std::move(cells[i]));
    mixed.push_back(std::move(cells[even + i]));
  }
  for (std::size_t i = pairs; i < even; ++i) mixed.push_back(std::move(cells[i]));
  for (std::size_t i = even + pairs; i < cells.size(); ++i) mixed.push_back(std::move(cells[i]));
  return mixed;
}

}  // namespace

std::array<CropSet, 2> halves_of(const Image& image, const std::string& name, const CropOptions& choice,
                                 const Work& work) {
  check_pixels(image, name, work);
  const int width = image.width / choice.scale, height = image.height / choice.scale;
  std::array<CropSet, 2> halves;
  for (int h = 0; h < 2; ++h) {
    CropSet& half = halves[h];
    half.crop = choice.crop;
    int judged = 0;
    for (CropCell& cell : cells_of(width, height, image.sections, h == 1, choice)) {
      if (judged >= choice.crops / 2 && half.cells.size() >= 2) break;
      judged += cell.columns * cell.rows;
      half.cells.push_back(std::move(cell));
    }
    if (judged < 2)
      throw Error(
          "too-small",
          fmt::format("image {} has {} × {} × {} pixels after reduction; each of its halves needs two "
                      "crops of {} × {} pixels",
                      name, width, height, image.sections, choice.crop, choice.crop),
          "use a larger image, or lower crop or scale")
          .parameter("crop");
    for (int c = 0; c < count_of(half.cells); ++c)
      for (int y = 0; y + 2 <= 2 * half.cells[c].rows; ++y)
        for (int x = 0; x + 2 <= 2 * half.cells[c].columns; ++x)
          half.crops.push_back({c, x * choice.crop / 2, y * choice.crop / 2, x % 2 == 0 && y % 2 == 0});
    work.part(0.5 * h, 0.5 * (h + 1)).parallel(half.cells.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) read_pixels(image, choice.scale, choice.crop, half.cells[i]);
    });
  }
  return halves;
}

}  // namespace terrazzo::texture_observer
