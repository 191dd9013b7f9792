// A photograph's fine detail at any point of a packing, from the tiles of ResidualSynth or DetailSolid.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/linear.h"
#include "nodes/detail/residual/spline_tile.h"
#include "nodes/detail/residual/wave_field.h"
#include "runtime/work.h"

namespace terrazzo {
struct Particles;
struct Volume;
}  // namespace terrazzo

namespace terrazzo::residual {

constexpr float kShownSize = 0.8f;  // mean size of a sphere's profiles, relative to its own

class ResidualField {
 public:
  // ResidualSynth's grid `residual` (Vec3SGrid, offsets of sRGB-encoded colors), scaled so that a whole
  // number of periods fills each edge of `box` (mm), at the scale nearest to its own, as Voxelize does.
  // Throws Error "no-residual", "bad-residual".
  ResidualField(const Volume&, const Vec3& box, const Work& = {});
  // Tiles of each phase, at their own scale. Every particle uses the tile of the group whose color is nearest
  // in Oklab, turned and shifted at random about its center, and a slope of its own. The binder consists of
  // cells, each with its own turn and shift, that blend where they meet. `footprint`: edge of the pixels or
  // voxels that will show the field, mm; tiles are smoothed for it. Throws Error "bad-detail".
  ResidualField(const Detail&, const Particles&, double footprint, Keep = Keep::Values, const Work& = {});

  // The offset at a point in mm, within a particle or, if that is −1, within the binder. Each is a function
  // of space with the box's period. If a tile of ResidualSynth repeats in the box, every particle uses its
  // own part of the tile; in the binder the part changes along smooth surfaces, and parts blend with their
  // variance preserved, so that no repetition shows. `depth`: distance to the nearest outline, mm; `size`: of
  // the profile that has this outline, √(4A/π), mm, 0 if it is unknown; `dark`: share of the binder's dark
  // zone, −1 to take it from the depth.
  Vec3f at(const Vec3f& mm, int particle, float depth = 1e9f, float size = 0, float dark = -1) const;

  // The offset of a pixel or voxel that the particle covers by `cover`, 0 to 1, and the binder otherwise.
  // `binder`: what behind() returned for the same place, if it is known.
  Vec3f mixed(const Vec3f& mm, int particle, float cover, float depth = 1e9f, float size = 0,
              const Vec3f* binder = nullptr, float dark = -1) const;
  // The binder's offset where a particle, or none if that is −1, covers a part of the voxel. With tiles of
  // each phase it does not depend on colors.
  Vec3f behind(const Vec3f& mm, int particle, float depth = 1e9f, float size = 0, float dark = -1) const;

  // What the photograph's light adds to such a pixel of a picture. `normal`: of the nearest outline,
  // outwards, to the right and upwards in the picture, whose axes in space are `right` and `up`. Light
  // belongs to the picture, not to the solid, so `mixed` leaves it out.
  Vec3f light(const Vec3f& mm, int particle, float cover, float depth, float size,
              const Eigen::Vector2f& normal, const Vec3f& right, const Vec3f& up) const;

  bool has_zones() const { return !zones_.level.empty(); }
  // 1 in the binder's dark zone and 0 in the light one, with edges as sharp as pixels; in pictures, of which
  // binder_width is known (here in mm).
  float dark_zone(const Vec3f& mm, float width) const;
  float pixel() const { return 1 / rims_per_mm_; }  // edge of the photograph's, mm
  float softness() const { return softness_; }      // standard deviation of the photograph's blur, mm
  Vec3 scale() const { return scale_; }             // as used, relative to the residual's own
  Vec3i periods() const { return periods_; }

 private:
  struct Place {  // of a tile: voxel = turn · offset + shift
    Eigen::Matrix3f turn;
    Vec3f center;                 // mm
    Vec3f shift;                  // voxels
    Vec3f slope = Vec3f::Zero();  // offset per mm
  };
  struct Tile {
    SplineTile spline, broad;  // the binder's broad part is in its spline
    bool zones = false;        // whether there is a broad part
    Vec3f mean = Vec3f::Zero();
    std::vector<Detail::Rim> rims;
    std::vector<float> gain, grain_gain;
    float limit = 0;  // of what slopes add
    Eigen::Vector2f tilt = Eigen::Vector2f::Zero();
  };
  float size_of(int particle, float size) const;  // of the profile, if it is unknown
  Vec3f plain(const Vec3f& mm, int particle) const;
  Vec3f by_phase(const Vec3f& mm, int particle, float depth, float size, float dark) const;
  Vec3f moved(std::uint64_t stream, std::uint64_t item) const;  // a random place in the tile, mm
  Vec3f binder(const Vec3f& mm) const;
  float dark_share(const Vec3f& mm, float level, float edge) const;  // of the binder's dark zone
  void add_tile(std::vector<Vec3f> values, const Vec3i& size, double footprint, Keep, const Work&);
  void place_particles(const Detail&, const Particles&);
  void place_cells(int size, double voxel);
  Place random_place(std::uint64_t stream, std::uint64_t item, const Vec3f& center) const;
  Vec3f in_tile(const Place&, const Vec3f& mm) const;  // voxels
  Vec3f nearest_image(Vec3f offset) const;

  Vec3i periods_ = Vec3i::Ones();
  Vec3 scale_ = Vec3::Ones();
  Vec3f box_, voxels_per_mm_;
  std::vector<Tile> tiles_;  // the binder's, then the groups'
  bool phases_ = false, gray_ = false;
  std::vector<int> group_;                                  // tile of each particle
  std::vector<Place> places_;                               // of each particle
  std::vector<float> shown_;                                // mean size of the profiles of each particle, mm
  std::vector<float> scales_;                               // of the offsets of each particle
  std::vector<Eigen::Vector2f> contrast_, broad_contrast_;  // of each particle, as in Detail
  Vec3i cells_ = Vec3i::Ones();
  std::vector<Place> cell_;     // of each of the binder's cells, x fastest
  std::vector<Vec3f> centers_;  // theirs
  float rims_per_mm_ = 1;
  Detail::Zones zones_;
  WaveField waves_;
  float softness_ = 0;
  float edge_ = 0, sharp_edge_ = 0;  // of zones: how much the field changes over the blur of an edge, a pixel
};

}  // namespace terrazzo::residual
