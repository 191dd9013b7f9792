// Pixels of a micrograph that show no material.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::media {

// 1 for each pixel of the first section that lies under a label of `mask`, which may be null, or with `find`,
// in a caption or a ruler, which `warn` names; empty if there are none. Throws Error "size-mismatch",
// "empty-image".
std::vector<std::uint8_t> unobserved_pixels(const Image&, const Labels* mask, bool find,
                                            const std::function<void(const std::string&)>& warn, const Work&);

}  // namespace terrazzo::media
