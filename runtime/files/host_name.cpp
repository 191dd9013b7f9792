#include "runtime/files/host_name.h"

#include <unistd.h>

#include <cctype>

namespace terrazzo {

const std::string& host_name() {
  static const std::string name = [] {
    char text[65] = {};
    ::gethostname(text, sizeof text - 1);
    std::string out;
    for (const char* c = text; *c && out.size() < 24; ++c)
      if (std::isalnum(static_cast<unsigned char>(*c)) || *c == '-') out += *c;
    return out.empty() ? "host" : out;
  }();
  return name;
}

}  // namespace terrazzo
