// Damages data in many ways, reproducibly by seed.
#pragma once

#include <string>

#include "runtime/random.h"

namespace terrazzo::torture {

// Flips bits, sets bytes, lengths and numbers, and cuts, moves and repeats pieces, some taken from `other`.
// In half of the cases, it restores checksums and compression around the change, so that the damage reaches
// the code behind them.
std::string mutated(const std::string& whole, const std::string& other, Random& r);

}  // namespace terrazzo::torture
