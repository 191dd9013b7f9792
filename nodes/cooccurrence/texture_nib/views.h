// The nib's data structures as pictures.
#pragma once

#include "nodes/cooccurrence/texture_nib/nib.h"
#include "nodes/data/image.h"

namespace terrazzo::texture_nib {

// B_r in the levels' colors; magenta, which no texture has, where the color is not in the texture.
Image base_relative_view(const Nib&);
// O: white where the nib has painted, else black.
Image occupancy_view(const Nib&);

}  // namespace terrazzo::texture_nib
