// One resolution of the solid: its phases, and by how much their patterns differ from the pictures'.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/media/annealing/anneal.h"
#include "nodes/media/annealing/patterns.h"
#include "nodes/media/annealing/phase_bits.h"
#include "runtime/work.h"

namespace terrazzo::annealing {

// What the slices across one axis should show at one spacing, for each phase that counts.
struct PatternTarget {
  int axis = 0, spacing = 1;
  std::vector<Frequencies> phase;
};

// What lies beyond the layers at both ends across z.
enum class Ends {
  Tile,   // the layers at the other end
  Open,   // nothing: patterns that would reach beyond do not count
  Frozen  // nothing: Level::kFrozen layers do not change, and only patterns over the others count
};

class Level {
 public:
  static constexpr int kFrozen = PhaseBits::kReach;  // as far as patterns reach

  // `floor`: the frequency q₀ that the smallest ones are known to, for their weight 1 / (q + q₀). With two
  // phases only the second counts, since the first has the same patterns inverted.
  Level(std::vector<std::uint8_t> field, const Vec3i& size, int phases, const std::vector<PatternTarget>&,
        double floor, Ends, const Work&);

  // Visits the voxels that touch another phase across a face, in random order, and lets them take the phase
  // of a neighbor if that costs less than −temperature · ln(random number). Costs are the changes of voxels ·
  // mismatch() as if no two patterns over a voxel were equal. Returns the number of changes, the same for any
  // number of threads.
  std::size_t sweep(std::uint64_t seed, double temperature, const Work&);

  // Changes the voxels that cost least until phase p has count[p] of the voxels that may change.
  void settle(const std::vector<std::int64_t>& count, const Work&);

  // Σ over targets, phases and patterns of (p − q)² / (q + q₀).
  double mismatch() const;
  std::size_t tables() const { return tables_.size(); }  // targets times phases that count
  std::vector<std::uint8_t> take() { return std::move(field_); }

 private:
  static constexpr int kSpan = 5;  // pixels of a line that the patterns over one voxel reach

  struct Step {
    float remove, add;  // cost of one pattern less, one more
  };
  struct PatternCounts {
    double places;                               // where patterns are counted
    std::array<std::int64_t, kPatterns> excess;  // count − target
    std::array<float, kPatterns> weight;
    std::array<Step, kPatterns> step;
    void change(int pattern, std::int64_t by);
  };
  struct Group {  // slices across one axis at one spacing
    int axis, spacing;
    int column, row;                   // axes along which columns and rows run
    std::uint32_t slice;               // lines of `Bits` from a slice to the next
    std::vector<std::uint32_t> lines;  // [position along rows][5]: lines that patterns over it reach
    Layers counted;                    // of the lower left pixels of patterns that count
    std::vector<std::uint8_t> rows;    // [z]: bit j tells whether patterns with row 2 − j there count
  };
  using Columns = std::array<std::uint32_t, 3>;  // of three rows of pixels, [first row]: bit 3·column + row
  struct Bits {                                  // of a phase, along the rows of the slices
    PhaseBits along_x, along_y;
  };
  Group group_of(int axis, int spacing) const;
  PatternCounts table_of(const Group&, const Frequencies&, double floor) const;
  Bits bits_of(int phase, const Work&) const;
  Vec3i place(std::uint32_t voxel) const;
  // Which of the 5 × 5 voxels around `at` in the group's slice are in a phase: three rows of three patterns.
  Columns around(const Group&, const Bits&, const Vec3i& at) const;
  double cost_of(const Vec3i& at, int phase) const;  // of leaving the phase, or of entering it
  double cost(std::uint32_t voxel, const Vec3i& at, int to) const;
  void move_cheapest(int from, int to, std::size_t n, const Work&);
  void set(Bits&, const Vec3i& at, bool in) const;
  void change(const Vec3i& at, int phase, bool in);
  void apply(std::uint32_t voxel, int to);
  void count_all(const Work&);
  unsigned neighbors(std::uint32_t voxel, const Vec3i& at) const;  // bit p: phase p across a face
  std::vector<std::uint32_t> interface(const Work&) const;
  // What a change lowers the cost by, more than the temperature asks at this voxel; above 0 it is made.
  double gain(std::uint32_t voxel, const Vec3i& at, int to, std::uint64_t seed, double temperature) const;
  // The best phase at this temperature, or the present one.
  int propose(std::uint32_t voxel, std::uint64_t seed, double temperature) const;

  std::vector<std::uint8_t> field_;
  Vec3i size_;
  Ends ends_;
  Layers free_;  // that may change
  std::array<std::uint32_t, 3> step_;
  int phases_, counted_, first_;  // phases, those that count, the first of these
  std::vector<Group> groups_;
  std::vector<Bits> bits_;             // of the phases that count
  std::vector<PatternCounts> tables_;  // [group][phase that counts]
};

}  // namespace terrazzo::annealing
