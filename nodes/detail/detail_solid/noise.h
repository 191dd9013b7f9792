// The camera's noise: what a photograph shows in every place, whatever lies there.
#pragma once

#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// Takes the camera's noise out of the photograph and returns its model. Noise is the camera's if it is
// - even: at each lightness, blocks of 16 × 16 pixels within profiles and binder differ in strength about as
//   little as blocks of Gaussian noise with the same spectrum;
// - fine: at least half of its power has wavelengths below 8 pixels;
// - alike at all lightnesses but black and white: its deviation changes by a factor of at most 2.
// The grain of a material seldom is all of this. Chroma must be so too, or keeps its grain. Coarse grain
// behind the noise stays for the most part. Without such noise, or with too few blocks (200 of middle
// strength), the model is empty and the photograph stays as it is.
//
// The noise is what remains after small coefficients of a sliding 16 × 16 cosine transform are set to zero
// (Yu, Sapiro 2011). `softness`: of outlines, pixels; `mask`: not 0 where pixels teach nothing, may be null;
// `gray`: the photograph has no color. It must have passed check_photograph.
Detail::Noise split_noise(Image&, const Labels&, const Labels* mask, double softness, bool gray,
                          const Work& = {});

}  // namespace terrazzo::detail_solid
