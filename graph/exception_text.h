// Exceptions that no code of this program throws on purpose, in words for the user.
#pragma once

#include <exception>
#include <string>

namespace terrazzo {

// What happened: "not enough memory", what the operating system says, or that the program has a defect, with
// the text of the exception. Nothing else than this function shows that text to users.
std::string exception_text(const std::exception&);

}  // namespace terrazzo
