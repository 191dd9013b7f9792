// Damage of every kind, by seed.
#pragma once

#include <string>

#include "runtime/random.h"

namespace terrazzo::torture {

// Flips bits, sets bytes, lengths and numbers, cuts, moves and repeats pieces, some taken from `other`. Half
// the time checksums and compression around what was changed are made good again, so that the damage reaches
// what lies behind.
std::string mutated(const std::string& whole, const std::string& other, Random& r);

}  // namespace terrazzo::torture
