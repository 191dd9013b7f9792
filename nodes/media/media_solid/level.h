// One resolution of the solid: its phases, and by how much their patterns differ from the pictures'.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/media/media_solid/patterns.h"
#include "runtime/work.h"

namespace terrazzo::media_solid {

// What the slices across one axis should show at one spacing, for each phase that counts.
struct PatternTarget {
  int axis = 0, spacing = 1;
  std::vector<Frequencies> phase;
};

class Level {
 public:
  // `floor`: the frequency q₀ that the smallest ones are known to, for their weight 1 / (q + q₀). With two
  // phases only the second counts, since the first has the same patterns inverted.
  Level(std::vector<std::uint8_t> field, const Vec3i& size, int phases, const std::vector<PatternTarget>&,
        double floor, const Work&);

  // Visits the voxels that touch another phase across a face, in random order, and lets them take the phase
  // of a neighbor if that costs less than −temperature · ln(random number). Costs are the changes of voxels ·
  // mismatch() as if no two patterns over a voxel were equal. Returns the number of changes, the same for any
  // number of threads.
  std::size_t sweep(std::uint64_t seed, double temperature, const Work&);

  // Changes the voxels that cost least until phase p has count[p] voxels.
  void settle(const std::vector<std::int64_t>& count, const Work&);

  // Σ over targets, phases and patterns of (p − q)² / (q + q₀).
  double mismatch() const;
  std::vector<std::uint8_t> take() { return std::move(field_); }

 private:
  static constexpr int kSpan = 5;  // pixels of a line that the patterns over one voxel reach

  struct Step {
    float remove, add;  // cost of one pattern less, one more
  };
  struct PatternCounts {
    std::array<std::int64_t, kPatterns> excess;  // count − target
    std::array<float, kPatterns> weight;
    std::array<Step, kPatterns> step;
    void change(int pattern, std::int64_t by);
  };
  struct Group {                 // slices across one axis at one spacing
    int columns, rows, spacing;  // axes along which columns and rows run
    int reach;                   // index into reach_
  };
  // The phases around a voxel in every group, 5 × 5 each, padded.
  using Around = std::array<std::uint8_t, 32>;

  Vec3i place(std::uint32_t voxel) const;
  void gather(std::uint32_t voxel, std::vector<Around>&) const;
  std::uint32_t bits(const Around&, int phase) const;
  double cost_of(const std::vector<Around>&, int phase) const;
  double cost(const std::vector<Around>&, int from, int to) const;
  void move_cheapest(int from, int to, std::size_t n, const Work&);
  void apply(std::uint32_t voxel, const std::vector<Around>&, int to);
  void count_all(const Work&);
  unsigned neighbors(std::uint32_t voxel) const;  // bit p: phase p across a face
  std::vector<std::uint32_t> interface(const Work&) const;
  // What a change lowers the cost by, more than the temperature asks at this voxel; above 0 it is made.
  double gain(std::uint32_t voxel, const std::vector<Around>&, int to, std::uint64_t seed,
              double temperature) const;
  // The best phase at this temperature, or the present one.
  int propose(std::uint32_t voxel, const std::vector<Around>&, std::uint64_t seed, double temperature) const;

  std::vector<std::uint8_t> field_;
  Vec3i size_;
  std::array<std::uint32_t, 3> step_;
  int phases_, counted_, first_;  // phases, those that count, the first of these
  std::vector<Group> groups_;
  std::vector<std::vector<std::uint32_t>> reach_;  // [spacing and axis][position][5]: where in field_
  std::vector<PatternCounts> tables_;              // [group][phase that counts]
};

}  // namespace terrazzo::media_solid
