// Color spaces that picture files state, converted with Little CMS.
#pragma once

#include <memory>
#include <string>

#include "nodes/common/io/pictures/picture_metadata.h"
#include "nodes/data/linear.h"

namespace terrazzo {

class ColorProfile {
 public:
  // An ICC profile. Throws Error "bad-color-profile" if it is damaged, or not for RGB or gray.
  explicit ColorProfile(const std::string& icc);
  // Throws Error "bad-color-profile" if the chromaticities span no colors.
  explicit ColorProfile(const StatedColors&);

  // Every color is within half a level of 8 bits of sRGB.
  bool is_srgb() const { return is_srgb_; }
  bool is_linear() const { return is_linear_; }  // the same for scene-linear Rec. 709
  bool is_gray() const;                          // converts the first of the three channels
  // Converts encoded colors to scene-linear Rec. 709, in place.
  void to_linear(Vec3f* pixels, std::size_t count) const;

 private:
  struct Transform;
  void judge();
  std::shared_ptr<const Transform> transform_;
  bool is_srgb_ = false, is_linear_ = false;
};

}  // namespace terrazzo
