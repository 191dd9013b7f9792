// The user study of Jagnow, Dorsey, Rushmeier 2008, section 4.2: what is shown, and a page that shows it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/table.h"

namespace terrazzo::shape_study {

// A stack of sections of one volume.
struct Stimulus {
  std::string shape, method;  // method "original" for the shape itself
  int sections = 0;
};

// Pictures by (stimulus, section). Centre and one side are the original's, the other side the decoy's; on
// screens without a decoy all three are the original's, and `decoy` is "none".
struct Screen {
  std::string shape, method;  // "original" without a decoy
  std::string decoy;          // "left", "right" or "none"
  struct Shown {
    int stimulus, section;
  } left, centre, right;
};

// `repeats` screens for every shape and decoy, and as many a shape without one. Different sections where one
// stack gives two or three of a screen's pictures. Throws Error "no-original" for a shape without one, or
// without at least three sections of it.
std::vector<Screen> make_screens(const std::vector<Stimulus>&, int repeats, std::uint64_t seed);

// Columns: screen (1…), shape, method, decoy, left, centre, right (names of pictures).
Table key_of(const std::vector<Screen>&, const std::vector<std::vector<std::string>>& names);

// A page without any outside help: instructions, `training` screens, then all in another order for each
// participant, a second of grey between; ends in answers to download (participant, screen, choice, seconds).
// It holds no word of which picture is whose.
std::string page_of(const std::vector<Screen>&, const std::vector<std::vector<std::string>>& names,
                    int training);

}  // namespace terrazzo::shape_study
