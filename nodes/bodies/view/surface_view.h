// Pictures of stones seen from above.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/bodies/view/bed.h"
#include "nodes/bodies/view/light.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/table.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/detail/residual/skins.h"
#include "runtime/work.h"

namespace terrazzo::view {

struct SurfaceOptions {
  std::vector<BedPlace> places;  // of one picture each
  double width = 0, height = 0;  // mm, of each picture
  int pixels_x = 0, pixels_y = 0;
  double pixel_size = 0;  // mm
  // The share of each picture that stones cover: soil fills the deepest places. Nothing: soil lies one period
  // below the cut.
  std::optional<double> area_fraction;
  bool loose = false;  // no soil: the deepest places show stones in the shadow, which have no labels
  // The mean of all channels of the photograph's stones, scene-linear; nothing: the usual light is 1.
  std::optional<float> brightness;
  // Profiles::light of the photograph, not 0; nothing: the sun has the share that `light` says.
  std::optional<Vec2> slope;
  std::vector<float> tones;  // Detail::tones of the photograph
  double softness = 0;       // of outlines, mm
  bool shaded = true;        // whether light falls on the stones; otherwise they have flat colors
  Light light;
  std::uint64_t seed = 1;
};

struct SurfaceView {
  Image image;        // scene-linear, 0 to 1
  Labels labels;      // of pixel centers; profile k of `profiles` is id k + 1
  Profiles profiles;  // one per connected visible piece of a stone
  Table table;  // one row per profile: section, particle, class, area mm², perimeter mm, whole mm², weight
  std::int64_t stones = 0;   // visible at the center of any pixel, in all pictures
  std::int64_t covered = 0;  // pixels whose center shows a stone
};

// Light is scaled so that the median stone pixel and the mean soil pixel of each picture have the colors that
// the particles and the binder give them, which a photograph's light has already changed; then that on
// stones so that they have the given brightness, and shadows of loose ones so that they are as dark as the
// photograph's tones; last, all tones become these, if they are known.
// `detail` and `skins` may be null. Throws Error "too-many-pixels" beyond 64 megapixels in all,
// "no-particles", "too-many-particles" and the errors of render_mesh.
SurfaceView show_surface(const Particles&, const Shapes&, const SurfaceOptions&,
                         const residual::ResidualField* detail, const residual::Skins* skins = nullptr,
                         const Work& = {});

}  // namespace terrazzo::view
