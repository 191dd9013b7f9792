// The context-sensitive nib (Malzbender and Spach 1993, section 4): a picture, one texture, and the pixels
// painted with it so far.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nodes/cooccurrence/texture_nib/completion.h"
#include "nodes/cooccurrence/texture_nib/nib_texture.h"
#include "nodes/data/image.h"
#include "nodes/data/strokes.h"
#include "runtime/work.h"

namespace terrazzo::texture_nib {

// How painted levels become colors. Levels: the levels' colors, as in the paper. Colors: colors of region
// pixels with the same level and similar neighborhoods. Patches: the region's pixels, arranged so that every
// patch looks like one of the region (complete()), whatever their level; same as Colors if the region is
// smaller than a patch.
enum class Finish { Levels, Colors, Patches };

// Pairs of pixels that the working matrix counts. Touching: those with at least one painted pixel, so that a
// stroke continues its surroundings. Painted: those with two, as in the paper (section 4.1).
enum class Pairs { Touching, Painted };

// Settings for painting a dab.
struct DabOptions {
  int passes = 4;  // visits per pixel; every pixel is visited once before any is visited again
  Finish finish = Finish::Patches;
  Pairs pairs = Pairs::Touching;
  std::uint64_t seed = 1;
};

// Pixels [x0, x1) × [y0, y1); empty if x1 ≤ x0.
struct Rectangle {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

class Nib {
 public:
  // Paints on the picture's first section. Results depend only on these arguments and on the strokes.
  Nib(Image picture, NibTexture, DabOptions);

  // Paints a whole stroke: one dab per segment of its line, or one dab for an area. Painting point by point,
  // with begin_stroke and extend_stroke, has the same result. Returns the changed rectangle. Throws Error
  // "bad-stroke".
  Rectangle paint(const Stroke&, const Work& = {});
  // Paints one dab on these pixels. Pixel numbers must be rising, without duplicates.
  Rectangle paint(const std::vector<std::uint32_t>& pixels, const Work& work = {}) {
    return dab(pixels, work);
  }
  void begin_stroke(double radius);  // Throws Error "bad-stroke"
  Rectangle extend_stroke(const Vec2& point, const Work& = {});

  const Image& picture() const { return picture_; }
  const NibTexture& texture() const { return texture_; }
  // B_r: the level of each pixel, kNoLevel where its color is not in the texture.
  const std::vector<std::uint8_t>& base_relative() const { return base_; }
  // O: 1 where the nib has painted.
  const std::vector<std::uint8_t>& occupancy() const { return occupied_; }

  // Counts of pixel pairs at each offset where both have a level and one or both are painted (`pairs`),
  // [offset][home][remote]; their sums are the paper's K_d. counts() is updated incrementally; fresh_counts()
  // measures again.
  std::vector<std::int32_t> counts() const;
  std::vector<std::int32_t> fresh_counts() const;
  // E over the offsets that have pairs.
  double error() const;

 private:
  Rectangle dab(const std::vector<std::uint32_t>& footprint, const Work&);
  void clear(std::uint32_t pixel);  // removes an unpainted pixel's level
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
  DabOptions dab_settings_;
  // B_r and O with a border of `pad_` pixels on all sides that have no level and are not painted. With
  // Pairs::Painted, unpainted pixels have no level here, so that no pair counts them.
  int pad_ = 0, stride_ = 0;
  std::vector<std::uint8_t> level_, painted_;
  std::vector<std::uint8_t> base_, occupied_;
  std::vector<std::ptrdiff_t> step_;
  std::vector<std::int32_t> by_home_, by_remote_;
  std::vector<std::int64_t> pairs_;
  std::vector<Vec3f> position_;       // current colors, in the levels' space
  std::vector<std::int32_t> source_;  // the region pixel that a painted pixel's color comes from, or −1
  std::shared_ptr<const SourcePyramid> source_pyramid_;
  std::uint64_t dabs_ = 0;
  double radius_ = 0;
  bool first_point_ = true;
  Vec2 last_point_ = Vec2::Zero();
};

}  // namespace terrazzo::texture_nib
