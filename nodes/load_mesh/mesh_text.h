// The words and numbers of a mesh file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "graph/diagnostic.h"

namespace terrazzo::mesh_files {

// Throws Error "unreadable-mesh" with `what`; the caller adds the name of the file.
[[noreturn]] void damaged(const std::string& what);

// Throws Error "bad-mesh" if face `f` has too few corners to be a face.
void require_corners(std::size_t f, std::size_t corners);

// Walks through text line by line and word by word. No word crosses the end of a line.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  // Goes to the next line; false at the end of the text. `comment` starts a remark that is left out ('\0':
  // none).
  bool next_line(char comment = '\0');
  // The next word of the line, or "" at its end.
  std::string_view word();
  // The next word of the line or of a later one. Throws if there is none.
  std::string_view word_anywhere(char comment = '\0');

  int line() const { return number_; }
  // What follows the current line.
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_, line_;
  int number_ = 0;
};

// A finite number in the range of single precision, rounded to it. Throws otherwise: "line 7: "nan" is not a
// number".
double coordinate(std::string_view word, int line);
// A whole number from 0. Throws if it is anything else or exceeds `most`.
std::uint64_t count(std::string_view word, std::uint64_t most, int line, const char* what);

}  // namespace terrazzo::mesh_files
