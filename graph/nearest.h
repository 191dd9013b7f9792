// The nearest valid name, for error messages.
#pragma once

#include <string>
#include <vector>

namespace terrazzo {

// The candidate with the smallest edit distance (case ignored), or "" where none is near enough to be meant.
std::string nearest(const std::string& name, const std::vector<std::string>& candidates);
// ", did you mean 'segment'?" or "".
std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace terrazzo
