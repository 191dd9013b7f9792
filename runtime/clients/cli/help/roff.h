// Text for manual pages: roff with man(7) macros.
#pragma once

#include <string>
#include <string_view>

namespace terrazzo::cli {

// Escapes everything that roff would interpret or replace by another character. The text is ASCII.
std::string roff_text(std::string_view);
std::string roff_bold(std::string_view);
std::string roff_italic(std::string_view);
// A paragraph with a title. Both are roff.
std::string roff_entry(const std::string& title, const std::string& text);

}  // namespace terrazzo::cli
