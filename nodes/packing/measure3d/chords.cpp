#include "nodes/packing/measure3d/chords.h"

#include "nodes/packing/measure3d/lines.h"

namespace terrazzo::measure3d {
namespace {

// Numbers of chords along one axis, at class · (n + 1) + voxels.
struct Chords {
  std::vector<std::uint64_t> complete, cut;  // with both ends, and with one end and the other cut

  Chords() = default;
  explicit Chords(std::size_t size) : complete(size, 0), cut(size, 0) {}
};

// The line's voxels are at of[0], of[stride], …
void add_line(const std::uint8_t* of, const VoxelLines& lines, bool periodic, Chords& chords) {
  const std::size_t n = lines.n;
  const auto at = [&](std::size_t i) { return of[(i < n ? i : i - n) * lines.stride]; };
  std::size_t begin = 0;  // where a chord begins
  if (periodic) {
    while (begin < n && at(begin) == at(begin + n - 1)) ++begin;
    if (begin == n) return;
  }
  for (std::size_t i = 0; i < n;) {
    const std::size_t from = i, k = at(begin + i);
    while (i < n && at(begin + i) == k) ++i;
    const std::size_t length = i - from, slot = k * (n + 1) + length;
    const bool begins = periodic || from > 0, ends = periodic || i < n;
    if (begins && ends) ++chords.complete[slot];
    if (begins != ends) ++chords.cut[slot];
  }
}

// `voxels`: of the phase. The arrays are those of one class.
ChordLengths lengths_of(const std::uint64_t* complete, const std::uint64_t* cut, std::size_t n,
                        std::size_t voxels, double spacing, bool periodic) {
  ChordLengths out;
  double ends = 0;
  std::size_t longest = 0;
  for (std::size_t k = 1; k <= n; ++k) {
    ends += 2.0 * complete[k] + cut[k];
    if (complete[k] > 0) longest = k;
  }
  if (!(ends > 0)) return out;
  const double seen = periodic ? 1 : (n - 1.0) / n;  // of a line's length, the part in which ends can be
  out.mean = 2 * spacing * voxels * seen / ends;
  double at_risk = ends, beyond = 1;  // share of the chords that are at least k long
  out.share.assign(longest + 1, 0);
  for (std::size_t k = 1; k <= longest; ++k) {
    at_risk -= cut[k];  // where these end is not seen
    const double end = 2.0 * complete[k];
    out.share[k] = end > 0 ? beyond * end / at_risk : 0;
    beyond -= out.share[k];
    at_risk -= end;
  }
  return out;
}

}  // namespace

std::vector<std::array<ChordLengths, 3>> chord_lengths(const Classes& classes, const Work& work) {
  constexpr std::size_t kGrain = 4096;  // lines
  std::vector<std::array<ChordLengths, 3>> out(classes.count());
  for (int axis = 0; axis < 3; ++axis) {
    const VoxelLines lines(classes.box.size, axis);
    const std::size_t size = classes.count() * (lines.n + 1);
    const Chords chords =
        work.part(axis / 3.0, (axis + 1) / 3.0)
            .reduce<Chords>(
                lines.count, kGrain, Chords(size),
                [&](std::size_t begin, std::size_t end) {
                  Chords part(size);
                  for (std::size_t l = begin; l < end; ++l)
                    add_line(&classes.of[lines.start(l)], lines, classes.box.periodic, part);
                  return part;
                },
                [](Chords a, const Chords& b) {
                  for (std::size_t k = 0; k < a.cut.size(); ++k) {
                    a.complete[k] += b.complete[k];
                    a.cut[k] += b.cut[k];
                  }
                  return a;
                });
    for (std::size_t k = 0; k < classes.count(); ++k) {
      const std::size_t first = k * (lines.n + 1);
      out[k][axis] = lengths_of(&chords.complete[first], &chords.cut[first], lines.n, classes.voxels[k],
                                classes.box.spacing[axis], classes.box.periodic);
    }
  }
  return out;
}

}  // namespace terrazzo::measure3d
