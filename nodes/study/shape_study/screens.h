// The user study of Jagnow, Dorsey, Rushmeier 2008, section 4.2: its screens, and a page that shows them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/table.h"

namespace terrazzo::shape_study {

// A stack of sections of one volume.
struct Stimulus {
  std::string shape, method;  // method is "original" for the shape itself
  int sections = 0;
};

// Images by (stimulus, section). The center and one side show the original, the other side the decoy. On
// screens without a decoy all three show the original, and `decoy` is "none".
struct Screen {
  std::string shape, method;  // method is "original" without a decoy
  std::string decoy;          // "left", "right" or "none"
  struct Shown {
    int stimulus, section;
  } left, center, right;
};

// `repeats` screens per shape and decoy, and as many per shape without a decoy. The three sections on a
// screen have different numbers in their stacks. Throws Error "no-original" if a shape has no original with
// at least three sections, "too-few-sections" if another stack has fewer.
std::vector<Screen> make_screens(const std::vector<Stimulus>&, int repeats, std::uint64_t seed);

// Columns: screen (1…), shape, method, decoy, left, center, right (image names).
Table key_of(const std::vector<Screen>&, const std::vector<std::vector<std::string>>& names);

// `count` screens for practice, from stacks in random order. Their three images are those of no test screen
// and of no other training screen, in whatever arrangement. Throws Error "too-few-sections" if none are left.
// The stimuli must satisfy make_screens.
std::vector<Screen> make_training(const std::vector<Stimulus>&, const std::vector<Screen>& test, int count,
                                  std::uint64_t seed);

// A self-contained page: instructions, the training screens, then all screens, both shuffled for each
// participant and separated by a second of gray. It ends with answers to download (participant, screen,
// choice, seconds), without those to training screens. The page does not reveal which image shows the decoy.
std::string page_of(const std::vector<Screen>&, const std::vector<Screen>& training,
                    const std::vector<std::vector<std::string>>& names);

}  // namespace terrazzo::shape_study
