// Words and numbers of a mesh file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "graph/diagnostic.h"

namespace terrazzo::load_mesh {

// Throws Error "unreadable-mesh" with the message `what`; the caller adds the file name.
[[noreturn]] void damaged(const std::string& what);

// Throws Error "bad-mesh" if face `f` has fewer than three corners.
void require_corners(std::size_t f, std::size_t corners);

// The text in lowercase, ASCII letters only.
std::string lowercase(std::string_view);

// Iterates over text by lines and words. A word never spans two lines. The first line's end tells how lines
// end: with \n or \r\n, or with \r alone.
class Words {
 public:
  explicit Words(std::string_view text);

  // Advances to the next line; returns false at the end of the text. `comment` is the character that starts a
  // comment ('\0': none).
  bool next_line(char comment = '\0');
  // The next word of the line, or "" at its end.
  std::string_view word();
  // The next word of this or a later line. Throws if there is none.
  std::string_view word_anywhere(char comment = '\0');

  int line() const { return number_; }
  // The text after the current line.
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_, line_;
  char line_end_ = '\n';
  int number_ = 0;
};

// A finite number in the range of single precision, with all its digits; nothing if the word is no such
// number.
std::optional<double> number_in(std::string_view word);
// The same. Otherwise throws: "line 7: "nan" is not a number".
double coordinate(std::string_view word, int line);
// A whole number ≥ 0. Throws for anything else and for numbers above `most`. `what` names the number in the
// message.
std::uint64_t count(std::string_view word, std::uint64_t most, int line, const char* what);

}  // namespace terrazzo::load_mesh
