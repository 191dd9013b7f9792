// How strong light becomes a picture, always through OpenColorIO: scene-linear to what a display shows, still
// linear.
#pragma once

#include <memory>
#include <string>

#include "nodes/data/image.h"

namespace terrazzo {

class Tone {
 public:
  // neutral: neutral_curve(). aces: the Academy's rendering for displays (ACES 1.0 SDR video), strong light
  // rolls off like film and loses saturation. view: of the configuration that $OCIO names, see
  // show_through_view. none: light as it is. Throws Error "color-config" where OpenColorIO has no such
  // transform.
  explicit Tone(const std::string& kind, const std::string& view = "");
  ~Tone();

  // Linear Rec. 709 in and, but for none, out within [0, 1]; in place.
  void apply(Image&) const;

 private:
  struct Transform;
  std::unique_ptr<Transform> transform_;
  bool view_;
  std::string name_;
};

// Leaves values up to 0.85 as they are and bends those above towards 1; all channels by the same factor, so
// that the hue stays. OpenColorIO interpolates a table of it, up to 2, to 1/400.
Vec3f neutral_curve(const Vec3f& linear);

}  // namespace terrazzo
