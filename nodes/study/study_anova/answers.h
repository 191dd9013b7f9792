// Answers of a study and their key, as written by its page and its node.
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

// Entries by screen number. Throws Error "malformed-row" with file:line, "no-column".
std::map<int, KeyEntry> read_key(const std::string& text, const std::string& file);
// Also throws Error "no-such-screen" for a screen that is not in the key.
std::vector<Answer> read_answers(const std::string& text, const std::string& file,
                                 const std::map<int, KeyEntry>&);

}  // namespace terrazzo::study_anova
