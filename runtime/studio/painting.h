// Painting: a picture being painted on with nibs, its history, and the graph that paints it again. What the
// page shows; it knows neither server nor page.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/strokes.h"
#include "nodes/texture_nib/nib.h"

namespace terrazzo::studio {

// What the user chose of a nib; the parameters of a TextureNib node, of the same defaults.
struct NibChoice {
  std::vector<double> region;  // as in TextureNib: x, y, width, height, or a polygon
  int levels = 8, extent = 3, scales = 1, passes = 4;
  std::optional<double> threshold;
  std::string finish = "patches";
  std::uint64_t seed = 1;
};

// What takes long stops when its Work is cancelled and throws Cancelled. The painting is then half done: all
// that may be done with it is to end.
class Painting {
 public:
  // Throws what reading the picture throws.
  explicit Painting(const std::filesystem::path& picture);

  const std::filesystem::path& file() const { return file_; }
  const Image& picture() const;
  // Null before a nib was chosen.
  const texture_nib::Nib* nib() const { return nib_ ? &*nib_ : nullptr; }
  const NibChoice* choice() const { return layers_.empty() ? nullptr : &layers_.back().choice; }
  std::size_t strokes() const;  // of all nibs

  // Takes up a nib; what was painted with it before is the picture that it is learnt from, and its map is
  // empty. Throws Error "outside-image", "bad-region", "too-small", "one-color", "bad-value".
  void choose(const NibChoice&, const Work& = {});

  // A stroke, point by point; each returns what changed at once. Strokes that meet no pixel are forgotten.
  // Throws Error "no-nib", "no-stroke", "bad-stroke", "nib-too-large".
  void begin_stroke(double radius);
  texture_nib::Rectangle extend_stroke(const Vec2& point, const Work& = {});
  void end_stroke();

  // Takes the last stroke back, or the last nib where it has painted nothing. False where there is nothing.
  bool undo(const Work& = {});

  // A graph in YAML that gives this picture, bit for bit: at `file`, to which its paths are relative.
  std::string graph(const std::filesystem::path& file) const;
  // The content hash of the picture as `terrazzo run --report` tells it.
  std::string content() const;

 private:
  struct Layer {
    NibChoice choice;
    Image base;
    std::vector<Stroke> strokes;
  };
  texture_nib::Nib nib_of(const Layer&, const Work&) const;
  void repaint(const Work&);

  std::filesystem::path file_;
  Image original_;
  std::vector<Layer> layers_;
  std::optional<texture_nib::Nib> nib_;
  std::optional<Stroke> stroke_;  // going on
  bool met_ = false;              // whether it met a pixel
};

}  // namespace terrazzo::studio
