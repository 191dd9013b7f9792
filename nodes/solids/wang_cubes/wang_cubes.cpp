#include "nodes/solids/wang_cubes/wang_cubes.h"

#include <algorithm>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::wang_cubes {
namespace {

using patch_fill::FillProblem;
using patch_fill::wrapped;

constexpr int kRamp = 2;  // length on which what is kept at faces loses its weight, in rims

// Distances from a voxel to the nearest face across each axis: 0 at the face.
Vec3i face_distances(const Vec3i& p, const Vec3i& n) { return p.cwiseMin(n - Vec3i::Ones() - p); }

// The solid `guide` where its weight is 1, within `rim` of something, and freed beyond. `distance` of a place
// is that from what is kept.
template <class Distance>
FillProblem problem_of(const Torus<Vec3f>& solid, const Torus<Vec3f>& guide, int rim, Distance&& distance) {
  FillProblem out{solid, guide, Torus<float>(solid.size, 0), guide, Torus<float>(solid.size, 0)};
  out.sources = FillProblem::Sources::Guided;
  const float ramp = kRamp * static_cast<float>(rim);
  for (std::size_t i = 0; i < solid.at.size(); ++i) {
    const int beyond = distance(solid.place(i)) - rim + 1;
    out.weight.at[i] = std::clamp(1 - beyond / ramp, 0.0f, 1.0f);
    out.free.at[i] = beyond > 0 ? 1.0f : 0.0f;
  }
  return out;
}

}  // namespace

namespace {

// The colors of the lower faces of all places, from which the upper ones follow.
struct Faces {
  Torus<std::array<int, 3>> low;

  FaceColors of(const Vec3i& p) const {
    FaceColors out;
    out.low = at(p);
    for (int a = 0; a < 3; ++a) out.high[a] = at(p + Vec3i::Unit(a))[a];
    return out;
  }
  // How many of the 26 neighbors are the same cube.
  int alike(const Vec3i& p) const {
    const FaceColors here = of(p);
    int out = 0;
    for (int k = 0; k < 27; ++k) {
      const Vec3i q = p + Vec3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (index(q) != index(p)) out += of(q) == here;
    }
    return out;
  }
  std::size_t index(const Vec3i& p) const {
    return low.index(wrapped(p.x(), low.size.x()), wrapped(p.y(), low.size.y()),
                     wrapped(p.z(), low.size.z()));
  }
  const std::array<int, 3>& at(const Vec3i& p) const { return low.at[index(p)]; }
};

}  // namespace

Lattice random_lattice(const Vec3i& cubes, int colors, std::uint64_t seed) {
  Faces faces{{cubes, {}}};
  for (std::size_t i = 0; i < faces.low.at.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a)
      faces.low.at[i][a] = Random(seed, 0x81 + a, i).below(static_cast<std::uint64_t>(colors));
  // Chance puts equal cubes side by side. Change faces of the two cubes that meet there, where that helps.
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < faces.low.at.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) {
        const Vec3i here = faces.low.place(i), below = here - Vec3i::Unit(a);
        int& color = faces.low.at[i][a];
        int best = color, least = faces.alike(here) + faces.alike(below);
        for (int k = 1; k < colors && least > 0; ++k) {
          color = (color + 1) % colors;
          if (const int now = faces.alike(here) + faces.alike(below); now < least) {
            best = color;
            least = now;
          }
        }
        color = best;
      }
  Lattice out;
  out.cubes = cubes;
  for (std::size_t i = 0; i < faces.low.at.size(); ++i) out.faces.push_back(faces.of(faces.low.place(i)));
  return out;
}

CubeSet make_cubes(const Torus<Vec3f>& solid, const Lattice& lattice, const CubeOptions& s,
                   const Work& work) {
  const Vec3i n = solid.size;
  CubeSet out;
  for (const FaceColors& f : lattice.faces) {
    const auto found = std::find(out.faces.begin(), out.faces.end(), f);
    out.at.push_back(static_cast<std::size_t>(found - out.faces.begin()));
    if (found == out.faces.end()) out.faces.push_back(f);
  }
  // All steps take about equally long.
  const std::size_t steps = (3 * (s.colors - 1)) + out.faces.size();
  std::size_t step = 0;
  const auto next = [&] {
    const double from = static_cast<double>(step++) / steps;
    return work.part(from, static_cast<double>(step) / steps);
  };
  const auto seeded = [&](std::uint64_t item) {
    patch_fill::FillOptions fill = s.fill;
    fill.seed = Random(s.fill.seed, 0x84, item).bits() >> 11;
    return fill;
  };

  // The content of a face is a whole tile that equals the solid along the edges of the face.
  std::array<std::vector<Torus<Vec3f>>, 3> content;
  for (std::size_t a = 0; a < 3; ++a)
    for (int color = 0; color < s.colors; ++color) {
      if (color == 0) {
        content[a].push_back(solid);
        continue;
      }
      const FillProblem problem = problem_of(solid, solid, s.rim, [&](const Vec3i& p) {
        const Vec3i d = face_distances(p, n);
        const Eigen::Index axis = a;
        return std::max(d[axis], std::min(d[(axis + 1) % 3], d[(axis + 2) % 3]));
      });
      content[a].push_back(fill(problem, seeded(a * 64 + color), next()).color);
    }

  for (std::size_t k = 0; k < out.faces.size(); ++k) {
    const FaceColors& f = out.faces[k];
    const Work part = next();
    if (f == FaceColors{}) {
      out.cube.push_back(solid);
      continue;
    }
    // Near a face its content, near two faces the solid.
    Torus<Vec3f> guide = solid;
    for (std::size_t i = 0; i < solid.at.size(); ++i) {
      const Vec3i p = solid.place(i), d = face_distances(p, n);
      Eigen::Index a = 0;
      d.minCoeff(&a);
      if ((d.array() < s.rim).count() > 1) continue;
      const std::size_t axis = a;
      const int color = 2 * p[a] < n[a] ? f.low[axis] : f.high[axis];
      guide.at[i] = content[axis][color].at[i];
    }
    FillProblem problem =
        problem_of(solid, guide, s.rim, [&](const Vec3i& p) { return face_distances(p, n).minCoeff(); });
    problem.tiles = false;  // opposite faces may differ
    out.cube.push_back(fill(problem, seeded(1000 + k), part).color);
  }
  return out;
}

Torus<Vec3f> assemble(const CubeSet& set, const Lattice& lattice) {
  const Vec3i n = set.cube[0].size, m = lattice.cubes;
  Torus<Vec3f> out(n.cwiseProduct(m), Vec3f::Zero());
  for (std::size_t i = 0; i < out.at.size(); ++i) {
    const Vec3i p = out.place(i), c = p.cwiseQuotient(n), q = p - c.cwiseProduct(n);
    const std::size_t place = voxel_at(c.x(), c.y(), c.z(), m);
    const Torus<Vec3f>& cube = set.cube[set.at[place]];
    out.at[i] = cube.at[cube.index(q.x(), q.y(), q.z())];
  }
  return out;
}

double repetition(const Torus<Vec3f>& colors, const Vec3i& cubes) {
  double worst = 0;
  Vec3 mean = Vec3::Zero();
  for (const Vec3f& c : colors.at) mean += c.cast<double>();
  mean /= static_cast<double>(colors.at.size());
  for (int a = 0; a < 3; ++a) {
    if (cubes[a] == 1) continue;
    double together = 0, square = 0;
    for (std::size_t i = 0; i < colors.at.size(); ++i) {
      Vec3i p = colors.place(i);
      p[a] = wrapped(p[a] + colors.size[a] / cubes[a], colors.size[a]);
      const Vec3 here = colors.at[i].cast<double>() - mean,
                 there = colors.at[colors.index(p.x(), p.y(), p.z())].cast<double>() - mean;
      together += here.dot(there);
      square += here.squaredNorm();
    }
    worst = std::max(worst, square > 0 ? together / square : 1);
  }
  return worst;
}

}  // namespace terrazzo::wang_cubes
