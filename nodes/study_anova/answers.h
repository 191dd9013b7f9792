// Answers of a study and the key to them, as written by its page and its node.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace terrazzo::study_anova {

struct KeyEntry {
  std::string shape, method, decoy;
};

struct Answer {
  std::string participant, shape, method, decoy, choice;  // choice: "left" or "right"
  double seconds = 0;
};

// By number of the screen. Throws Error "malformed-row" with file:line, "no-column".
std::map<int, KeyEntry> read_key(const std::string& text, const std::string& file);
// Throws besides Error "no-such-screen" for a screen that the key has not.
std::vector<Answer> read_answers(const std::string& text, const std::string& file,
                                 const std::map<int, KeyEntry>&);

}  // namespace terrazzo::study_anova
