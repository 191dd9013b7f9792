// The outsides of stones that a photograph shows from above.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

struct Outsides {
  std::vector<Detail::Skin> skins;
  Detail::Relief relief;  // of all
};

// One skin for each stone of a photographed surface that is complete, large enough and mostly visible,
// without the light and shade that its form gives it; none of other views. Where something hides or shadows
// the stone, its texture continues. Profile k is label k + 1. The photograph must have passed
// check_photograph. Throws Error "size-mismatch" if profiles and labels differ in number.
Outsides find_skins(const Image&, const Labels&, const Profiles&, std::uint64_t seed, const Work& = {});

}  // namespace terrazzo::detail_solid
