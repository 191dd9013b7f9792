#include "nodes/export/color_classes.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::exporting {
namespace {

using Cell = std::array<std::int64_t, 3>;

// Numbers equal cells equally, in the order of their first occurrence. Returns the number of different cells.
int number_cells(const std::vector<Cell>& cells, std::vector<int>& of) {
  std::map<Cell, int> numbers;
  of.clear();
  for (const Cell& c : cells) of.push_back(numbers.emplace(c, count_of(numbers)).first->second);
  return numbers.size();
}

}  // namespace

ColorClasses color_classes(const std::vector<Vec3f>& colors, int most) {
  constexpr int kFinestSteps = 255;  // per unit of the encoded channel
  ColorClasses out;
  std::vector<Cell> cells(colors.size());
  const auto fill = [&](auto&& cell_of) {
    for (std::size_t i = 0; i < colors.size(); ++i) cells[i] = cell_of(colors[i]);
    return number_cells(cells, out.of);
  };
  int classes = fill([](const Vec3f& c) {
    Cell cell;
    for (int k = 0; k < 3; ++k) {
      // The bits of the float; −0 counts as 0.
      std::uint32_t bits = 0;
      const float v = c[k] == 0 ? 0.0f : c[k];
      std::memcpy(&bits, &v, sizeof bits);
      cell[k] = bits;
    }
    return cell;
  });
  for (int steps = kFinestSteps; classes > most && steps >= 1; --steps)
    classes = fill([&](const Vec3f& c) {
      const Vec3f encoded = linear_to_srgb(c.cwiseMax(0.0f).cwiseMin(1.0f)) * static_cast<float>(steps);
      Cell cell;
      for (int k = 0; k < 3; ++k)
        cell[k] = std::min<std::int64_t>(std::llround(std::floor(encoded[k])), steps - 1);
      return cell;
    });
  std::vector<Vec3> sum(classes, Vec3::Zero());
  std::vector<std::size_t> members(sum.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    sum[out.of[i]] += colors[i].cast<double>();
    ++members[out.of[i]];
  }
  for (std::size_t c = 0; c < sum.size(); ++c)
    out.color.push_back((sum[c] / static_cast<double>(members[c])).cast<float>());
  return out;
}

}  // namespace terrazzo::exporting
