#include "nodes/volumes/voxelize/slabs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"

namespace terrazzo::voxelize {
void check(const Particles& particles, const Shapes& shapes) {
  const auto bad = [](std::size_t i, const std::string& what) {
    throw Error("bad-particles", "particle " + std::to_string(i) + " " + what);
  };
  const std::size_t n = particles.count();
  if (particles.shape.size() != n || particles.orientation.size() != n || particles.scale.size() != n ||
      particles.color.size() != n || (!particles.voids.empty() && particles.voids.size() != n))
    throw Error("bad-particles", "the particles' columns differ in length");
  for (std::size_t i = 0; i < n; ++i) {
    if (particles.shape[i] < 0 || particles.shape[i] >= static_cast<std::int32_t>(shapes.shapes.size()))
      bad(i, fmt::format("has shape {}, but there are only {} shapes", particles.shape[i],
                         shapes.shapes.size()));
    if (!particles.position[i].allFinite()) bad(i, "has a position that is NaN or infinite");
    if (!(std::abs(particles.orientation[i].norm() - 1) < 1e-6))
      bad(i, "has an orientation that is not a unit quaternion");
    if (!(particles.scale[i] > 0) || !std::isfinite(particles.scale[i]))
      bad(i, "has a scale that is not positive and finite");
    if (!particles.color[i].allFinite()) bad(i, "has a color that is NaN or infinite");
  }
  if (!particles.binder_color.allFinite())
    throw Error("bad-particles", "the binder color is NaN or infinite");
  for (const auto& s : shapes.shapes) {
    const auto faults = mesh_faults(s.mesh);
    if (!faults.empty())
      throw Error("open-mesh", "shape '" + s.name + "': " + faults.front(),
                  "repair the mesh (LoadMesh.repair)");
  }
}

namespace {

constexpr std::size_t kBatchCells = std::size_t{1} << 21;  // stamps held at once

// The lattice cells that a particle's level set can reach.
CellBox reach(const Particles& particles, const Shape& shape, std::size_t p, double voxel) {
  const Mat3 turn = particles.orientation[p].toRotationMatrix() * (particles.scale[p] / voxel);
  Eigen::AlignedBox3d box;
  for (const auto& v : shape.mesh.vertices) box.extend(turn * v);
  const Vec3 center = particles.position[p] / voxel - Vec3::Constant(0.5);
  CellBox out;
  out.lo = (center + box.min()).array().floor().cast<int>() - static_cast<int>(kBand);
  out.size = (center + box.max()).array().ceil().cast<int>() + static_cast<int>(kBand) + 1 - out.lo.array();
  return out;
}

// Stamps for the planes of the slab: one per period in which a particle meets them.
std::vector<Stamp> stamps_of(const std::vector<CellBox>& boxes, int z0, int z1, int nz) {
  std::vector<Stamp> all;
  for (std::size_t p = 0; p < boxes.size(); ++p) {
    const int lo = boxes[p].lo.z(), hi = lo + boxes[p].size.z();
    for (int period = round_down(double(lo - z1) / nz); z0 + period * nz < hi; ++period) {
      const int a = std::max(lo, z0 + period * nz), b = std::min(hi, z1 + period * nz);
      if (a >= b) continue;
      Stamp s;
      s.particle = p;
      s.box = boxes[p];
      s.box.lo.z() = a;
      s.box.size.z() = b - a;
      all.push_back(std::move(s));
    }
  }
  return all;
}

}  // namespace

// Distance lattices by shape and octave of size. The spacing is at most a voxel for particles up to 256
// voxels long, as that of the level set; longer ones use 256 cells. A lattice that few particles would share
// takes longer to make than their distances.
class Slabs::Distances {
 public:
  Distances(const Particles& particles, const Shapes& shapes, double voxel, const Work& work) {
    std::vector<double> extent;
    for (const auto& s : shapes.shapes) {
      Eigen::AlignedBox3d box;
      for (const auto& v : s.mesh.vertices) box.extend(v);
      extent.push_back(box.sizes().maxCoeff());
    }
    for (std::size_t p = 0; p < particles.count(); ++p) {
      const double voxels = extent[particles.shape[p]] * particles.scale[p] / voxel;
      int cells = 4;
      while (cells < voxels && cells < 256) cells *= 2;
      key_.emplace_back(particles.shape[p], cells);
      double& band = band_[key_.back()];
      // The level set's band plus a margin for interpolation, limited for particles smaller than a voxel.
      band = std::max(band, std::min((kBand + 0.1) * cells / voxels + 1.8, 8.0 * kBand));
    }
    constexpr int kFew = 4;
    std::map<Key, int> uses;
    for (const Key& key : key_) ++uses[key];
    std::erase_if(band_, [&](const auto& entry) { return uses[entry.first] <= kFew; });
    double done = 0;
    for (const auto& [key, band] : band_) {
      const double next = done + 1.0 / band_.size();
      sdfs_.emplace(key, MeshSdf(shapes.shapes[key.first].mesh, key.second, band, work.part(done, next)));
      done = next;
    }
  }
  // Null if the particle's distances are to be computed from its mesh.
  const MeshSdf* of(std::size_t particle) const {
    const auto it = sdfs_.find(key_[particle]);
    return it == sdfs_.end() ? nullptr : &it->second;
  }

 private:
  using Key = std::pair<std::int32_t, int>;
  std::vector<Key> key_;
  std::map<Key, double> band_;
  std::map<Key, MeshSdf> sdfs_;
};

Slabs::Slabs(const Particles& particles, const Shapes& shapes, const Lattice& lattice,
             const Intermediates& intermediates, const Work& work)
    : particles_(particles), shapes_(shapes), lattice_(lattice), intermediates_(intermediates), work_(work) {
  if (!intermediates_) return;
  uncolored_ = particles;
  uncolored_.binder_color.setZero();
  std::ranges::fill(uncolored_.color, Vec3f::Zero().eval());
  std::ranges::fill(uncolored_.cls, 0);
}

Slabs::~Slabs() = default;

std::shared_ptr<const Slab> Slabs::get(int z0, int z1, const Work& work) {
  if (!intermediates_) return std::make_shared<const Slab>(made(z0, z1, work));
  return intermediates_.get<Slab>(key(z0, z1), [&] { return made(z0, z1, work); });
}

Hash Slabs::key(int z0, int z1) const {
  return key_of("Voxelize slab", uncolored_, shapes_, lattice_.size, lattice_.voxel, z0, z1);
}

Slab Slabs::made(int z0, int z1, const Work& work) {
  if (!distances_) {
    distances_ = std::make_unique<Distances>(particles_, shapes_, lattice_.voxel, work_);
    for (std::size_t p = 0; p < particles_.count(); ++p)
      boxes_.push_back(reach(particles_, shapes_.shapes[particles_.shape[p]], p, lattice_.voxel));
  }
  Slab slab(lattice_.size, z0, z1, particles_.void_count() > 0);
  std::vector<std::uint8_t> taken(slab.distance.size(), 0);  // cells inside a particle
  std::vector<Stamp> stamps = stamps_of(boxes_, z0, z1, lattice_.size.z());
  for (std::size_t begin = 0; begin < stamps.size();) {
    std::size_t end = begin, cells = 0;
    while (end < stamps.size() && (end == begin || cells + stamps[end].box.count() <= kBatchCells))
      cells += stamps[end++].box.count();
    std::vector<Stamp> batch(std::make_move_iterator(stamps.begin() + begin),
                             std::make_move_iterator(stamps.begin() + end));
    const Work part = work.part(double(begin) / stamps.size(), double(end) / stamps.size());
    const auto shape_of = [&](const Stamp& s) -> const Shape& {
      return shapes_.shapes[particles_.shape[s.particle]];
    };
    part.part(0, 0.2).parallel(batch.size(), 4, [&](std::size_t b, std::size_t e) {
      for (std::size_t i = b; i < e; ++i)
        scan_stamp(batch[i], particles_, shape_of(batch[i]), lattice_.voxel);
    });
    mark_inside(slab, batch, particles_, taken, part.part(0.2, 0.25));
    part.part(0.25, 0.8).parallel(batch.size(), 4, [&](std::size_t b, std::size_t e) {
      for (std::size_t i = b; i < e; ++i) {
        const std::size_t p = batch[i].particle;
        if (!particles_.is_void(batch[i].particle))
          add_distances(batch[i], slab, taken, particles_, shape_of(batch[i]), distances_->of(p),
                        lattice_.voxel);
      }
    });
    add_stamps(slab, batch, particles_, part.part(0.8, 1));
    begin = end;
  }
  return slab;
}

}  // namespace terrazzo::voxelize
