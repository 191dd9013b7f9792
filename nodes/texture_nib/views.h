// The nib's data structures as pictures.
#pragma once

#include "nodes/data/image.h"
#include "nodes/texture_nib/nib.h"

namespace terrazzo::texture_nib {

// B_r in the levels' colours; magenta, which no texture has, where a colour is none of the nib's.
Image base_relative_view(const Nib&);
// O: white where the nib has been, else black.
Image occupancy_view(const Nib&);

}  // namespace terrazzo::texture_nib
