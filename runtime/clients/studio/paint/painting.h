// Painting: an image that is painted on with nibs, its undo history, and a graph that reproduces it. It is
// the model behind the paint page and independent of server and page.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "nodes/cooccurrence/texture_nib/nib.h"
#include "nodes/data/image.h"
#include "nodes/data/strokes.h"

namespace terrazzo::studio {

// The settings of a nib: the parameters of a TextureNib node, with the same defaults.
struct NibOptions {
  std::vector<double> region;  // as in TextureNib: x, y, width, height, or a polygon
  int levels = 8, extent = 3, scales = 1, passes = 4;
  std::optional<double> threshold;
  std::string finish = "patches";
  std::uint64_t seed = 1;
};

// Methods that take a Work throw Cancelled when it is cancelled. The painting is then incomplete: after
// extend_stroke(), drop_stroke() makes it complete again; otherwise it must only be destroyed.
class Painting {
 public:
  // Reads the image. Throws what read_image() throws.
  explicit Painting(const std::filesystem::path& picture);

  const std::filesystem::path& file() const { return file_; }
  const Image& picture() const;
  // Null if no nib is chosen.
  const texture_nib::Nib* nib() const { return nib_ ? &*nib_ : nullptr; }
  const NibOptions* choice() const { return layers_.empty() ? nullptr : &layers_.back().choice; }
  std::size_t strokes() const;  // number of strokes of all nibs

  // Starts a new nib. It learns its texture from the current image, earlier strokes included, and its own map
  // starts empty. Throws Error "outside-image", "bad-region", "too-small", "one-color", "bad-value".
  void choose(const NibOptions&, const Work& = {});

  // Paint a stroke point by point. extend_stroke() returns the rectangle that the point changed. A stroke
  // that touches no pixel is dropped. Throw Error "no-nib", "no-stroke", "bad-stroke", "nib-too-large".
  void begin_stroke(double radius);
  void check_nib(double radius) const;  // throws what begin_stroke() throws
  texture_nib::Rectangle extend_stroke(const Vec2& point, const Work& = {});
  void end_stroke();

  // Undoes the stroke in progress, of which Cancelled may have interrupted a point. False if there is none.
  bool drop_stroke(const Work& = {});
  // Undoes the last stroke, or the last nib if it has no strokes. False if there is nothing to undo.
  bool undo(const Work& = {});

  // A graph in YAML that reproduces this image bit for bit when saved as `file`. Its paths are relative to
  // the folder of `file`.
  std::string graph(const std::filesystem::path& file) const;
  // The content hash of the image, as in the report of `terrazzo run --report`.
  std::string content() const;

 private:
  struct Layer {
    NibOptions choice;
    Image base;
    std::vector<Stroke> strokes;
  };
  texture_nib::Nib nib_of(const Layer&, const Work&) const;
  void repaint(const Work&);

  std::filesystem::path file_;
  Image original_;
  std::vector<Layer> layers_;
  std::optional<texture_nib::Nib> nib_;
  std::optional<Stroke> stroke_;  // the stroke in progress
  bool met_ = false;              // whether it touched a pixel
};

}  // namespace terrazzo::studio
