// Tone mapping, always with OpenColorIO: from scene-linear light to display light, still in linear values.
#pragma once

#include <memory>
#include <string>

#include "nodes/data/image.h"

namespace terrazzo::render_solid {

enum class ToneKind { Neutral, Aces, View, None };

class Tone {
 public:
  // neutral: neutral_curve(). aces: the Academy's rendering for displays (ACES 1.0 SDR video), where strong
  // light rolls off like film and loses saturation. view: a view of the configuration in $OCIO, see
  // show_through_view. none: no tone mapping. Throws Error "color-config" if OpenColorIO has no such
  // transform.
  explicit Tone(ToneKind, const std::string& view = "");
  ~Tone();

  // Maps linear Rec. 709 in place, to [0, 1] except for none.
  void apply(Image&) const;

 private:
  struct Transform;
  std::unique_ptr<Transform> transform_;
  bool view_;
  std::string name_;
};

// Keeps values up to 0.85 and compresses those above towards 1, by the same factor for all channels so that
// the hue stays. OpenColorIO interpolates a table of it, for values up to 2, to 1/400.
Vec3f neutral_curve(const Vec3f& linear);

}  // namespace terrazzo::render_solid
