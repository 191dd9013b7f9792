// The context-sensitive nib (Malzbender and Spach 1993, section 4): a picture, one texture, and what was
// painted with it so far.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/strokes.h"
#include "nodes/texture_nib/completion.h"
#include "nodes/texture_nib/nib_texture.h"
#include "runtime/work.h"

namespace terrazzo::texture_nib {

// What becomes of the levels painted. Levels: their colours (the paper's). Colors: those of the region's
// pixels of the same level whose surroundings look alike. Patches: the region's pixels, laid so that every
// patch looks like one of the region (complete()), whatever their level; Colors where the region is smaller
// than a patch.
enum class Finish { Levels, Colors, Patches };

// How the pixels of a dab are visited.
struct NibManner {
  int passes = 4;  // every pixel is visited once before any is visited a second time
  Finish finish = Finish::Patches;
  std::uint64_t seed = 1;
};

// Pixels [x0, x1) × [y0, y1); nothing where x1 ≤ x0.
struct Rectangle {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

class Nib {
 public:
  // Paints on the picture's first section. Everything is a function of these and of the strokes.
  Nib(Image picture, NibTexture, NibManner);

  // A stroke, whole: dabs along its line, one a segment, or one dab for an area. Strokes may be given point
  // by point as well, with the same result. Returns what changed. Throws Error "bad-stroke".
  Rectangle paint(const Stroke&, const Work& = {});
  // One dab on these pixels, by number, rising and each once.
  Rectangle paint(const std::vector<std::uint32_t>& pixels, const Work& work = {}) {
    return dab(pixels, work);
  }
  void begin_stroke(double radius);  // Throws Error "bad-stroke"
  Rectangle extend_stroke(const Vec2& point, const Work& = {});

  const Image& picture() const { return picture_; }
  const NibTexture& texture() const { return texture_; }
  // B_r: the level of each pixel, kNoLevel where its colour is none of the nib's.
  const std::vector<std::uint8_t>& base_relative() const { return base_; }
  // O: 1 where the nib has been.
  const std::vector<std::uint8_t>& occupancy() const { return occupied_; }

  // Pairs of pixels at each offset, both with a level and one at least painted, [offset][home][remote]; their
  // sums are the paper's K_d. What is kept up to date, and what a fresh measurement gives.
  std::vector<std::int32_t> counts() const;
  std::vector<std::int32_t> fresh_counts() const;
  // E over the offsets that have pairs.
  double error() const;

 private:
  Rectangle dab(const std::vector<std::uint32_t>& footprint, const Work&);
  void clear(std::uint32_t pixel);  // takes an unpainted pixel's level away
  void visit(std::uint32_t pixel, std::uint64_t item);
  void place(std::uint32_t pixel, int level);      // paints a pixel that is taken out
  void set_level(std::uint32_t pixel, int level);  // of a painted pixel
  template <int Vectors>
  int best_level(std::uint32_t pixel) const;
  void add(std::uint32_t pixel, int level, int sign, bool painted_only);
  void restore_detail(const std::vector<std::uint32_t>& footprint, const Work&);
  void complete_patches(const std::vector<std::uint32_t>& footprint, const Work&);
  void find_colors(const std::vector<std::uint32_t>& footprint, const Work&);
  Rectangle bounds(const std::vector<std::uint32_t>& pixels) const;

  Image picture_;
  NibTexture texture_;
  NibManner manner_;
  // B_r and O with a border of `pad_` pixels on all sides that have no level and are not painted.
  int pad_ = 0, stride_ = 0;
  std::vector<std::uint8_t> level_, painted_;
  std::vector<std::uint8_t> base_, occupied_;
  std::vector<std::ptrdiff_t> step_;
  std::vector<std::int32_t> by_home_, by_remote_;
  std::vector<std::int64_t> pairs_;
  std::vector<Vec3f> position_;       // colours now, in the levels' space
  std::vector<std::int32_t> source_;  // the region's pixel whose colour a painted pixel has, or −1
  std::shared_ptr<const SourcePyramid> source_pyramid_;
  std::uint64_t dabs_ = 0;
  double radius_ = 0;
  bool first_point_ = true;
  Vec2 last_point_ = Vec2::Zero();
};

}  // namespace terrazzo::texture_nib
