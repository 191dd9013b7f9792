// Ranges of numbers as text: LO:HI:STEP. Sweeps and repeated nodes read them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace terrazzo {

// The numbers of "0:511:1" or "0.3:0.5:0.1", both ends included if the steps reach them, with up to 12
// digits. Nothing if the text is not three numbers with colons between them. Throws Error "bad-range" if the
// step does not lead from LO to HI, and "too-large" if there are more than `most` numbers.
std::optional<std::vector<std::string>> read_range(const std::string& text, std::size_t most);

}  // namespace terrazzo
