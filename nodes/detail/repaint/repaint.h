// The picture that a photograph's own labels give with flat colors and synthesized detail.
#pragma once

#include <cstdint>

#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::repaint {

// The photograph with each profile in its median color, the binder in its mean color, outlines blurred by the
// detail's softness, and the detail as an oblique plane through a solid shows it. Without `detail`: flat
// colors and hard outlines. `seed` chooses the plane. Throws Error "empty-image", "size-mismatch",
// "bad-labels", "bad-detail".
Image repaint(const Image& photograph, const Labels&, const Detail* detail, std::uint64_t seed,
              const Work& = {});

}  // namespace terrazzo::repaint
