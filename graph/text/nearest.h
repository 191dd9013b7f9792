// Suggests the nearest valid name in error messages.
#pragma once

#include <string>
#include <vector>

namespace terrazzo {

// The candidate with the smallest case-insensitive edit distance, or "" if none is near enough.
std::string nearest(const std::string& name, const std::vector<std::string>& candidates);
// "; did you mean 'segment'?" or "".
std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace terrazzo
