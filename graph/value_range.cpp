#include "graph/value_range.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "graph/diagnostic.h"

namespace terrazzo {

std::optional<std::vector<std::string>> read_range(const std::string& text, std::size_t most) {
  std::array<double, 3> n{};
  const char *at = text.data(), *const end = at + text.size();
  for (std::size_t k = 0; k < n.size(); ++k) {
    const auto [stop, error] = std::from_chars(at, end, n[k]);
    if (error != std::errc() || !std::isfinite(n[k])) return {};
    if (k + 1 == n.size() ? stop != end : stop == end || *stop != ':') return {};
    at = stop + 1;
  }
  const auto [lo, hi, step] = n;
  if (step == 0 || (hi - lo) / step < 0)
    throw Error("bad-range", "the step must be nonzero and lead from LO to HI");
  const double steps = std::floor((hi - lo) / step + 1e-9);
  if (!(steps < most)) throw Error("too-large", fmt::format("the range has more than {} numbers", most));
  std::vector<std::string> out;
  // Rounds to 12 digits, so that 0.1 + 2 × 0.1 is 0.3 and not 0.30000000000000004.
  for (double k = 0; k <= steps; ++k) out.push_back(fmt::format("{:.12g}", lo + k * step));
  return out;
}

}  // namespace terrazzo
