#include "nodes/media/micrograph/unobserved.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/photograph/marks/objects.h"

namespace terrazzo::media {

std::vector<std::uint8_t> unobserved_pixels(const Image& image, const Labels* mask, bool find,
                                            const std::function<void(const std::string&)>& warn,
                                            const Work& work) {
  if (image.width < 1 || image.height < 1)
    throw Error("empty-image", "the image has no pixels", "connect an image");
  Image first(image.width, image.height, 1, image.pixel_size);
  std::copy_n(image.pixels.begin(), first.pixels.size(), first.pixels.begin());
  segment::IgnoredPixels ignored = segment::ignored_pixels(first, {}, mask);
  if (!find) return ignored;
  for (const segment::FoundObject& o : segment::find_objects(first, ignored, work))
    warn(fmt::format("columns {} to {}, rows {} to {} show {} and are ignored", o.left, o.right, o.top,
                     o.bottom, o.kind == segment::FoundObject::Kind::Caption ? "a caption" : "a ruler"));
  return ignored;
}

}  // namespace terrazzo::media
