// How sharp a photograph is, and at which scale the network should see it.
#pragma once

#include "nodes/data/image.h"

namespace terrazzo::segment {

// Standard deviation of the blur of the strongest edges, in pixels. An edge of unit height with a Gaussian
// blur σ has a gradient of 1 / (σ √2π), and of 1 / (√(σ² + 1) √2π) after another blur of one pixel, so the
// ratio of their squares is 1 + 1 / σ² (as in Zhuo and Sim 2011). The mean squares of the 3 % of pixels with
// the largest blurred gradients are compared, less those of the half with the smallest, which are noise.
// Below one pixel, the width of the gradient itself adds up to a third.
// At most nine windows of 1024² pixels of the first section are looked at. `scale`, up to 1: of the picture
// that is measured.
double blur_of(const Image&, double scale);

// From 0 to 1: how far the picture should be reduced before the network sees it. 1 if its blur is at most 1.5
// pixels, as in most of the pictures that the network learned from. Otherwise the picture is an enlargement,
// or out of focus, and is reduced until its blur is at most 1.15 pixels, or its shorter side is 512: in
// small pictures, small particles would be lost.
double network_scale_of(const Image&);

}  // namespace terrazzo::segment
