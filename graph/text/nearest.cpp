#include "graph/text/nearest.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace terrazzo {
namespace {

// Levenshtein distance that counts a swap of two neighboring letters, the most common typo, as one edit
// (optimal string alignment).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before, above(b.size() + 1), row(b.size() + 1);
  std::iota(above.begin(), above.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before = above;
    above = row;
  }
  return above[b.size()];
}

std::string lower(std::string s) {
  for (auto& c : s) c = std::tolower(static_cast<unsigned char>(c));
  return s;
}

}  // namespace

std::string nearest(const std::string& name, const std::vector<std::string>& candidates) {
  // A graph may have a hundred thousand names, and as many mistakes.
  constexpr std::size_t kLongest = 100, kMost = 1000;
  if (name.size() > kLongest || candidates.size() > kMost) return {};
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, name.size() / 2);
  for (const auto& c : candidates) {
    if (c.size() > name.size() + best_distance || name.size() > c.size() + best_distance) continue;
    const std::size_t d = edit_distance(lower(name), lower(c));
    if (d < best_distance || (d == best_distance && best.empty())) {
      best = c;
      best_distance = d;
    }
  }
  return best;
}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates) {
  const std::string n = nearest(name, candidates);
  return n.empty() ? "" : "; did you mean '" + n + "'?";
}

}  // namespace terrazzo
