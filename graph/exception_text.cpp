#include "graph/exception_text.h"

#include <filesystem>
#include <new>
#include <system_error>

#include "graph/diagnostic.h"

namespace terrazzo {

std::string exception_text(const std::exception& e) {
  if (const auto* known = dynamic_cast<const Error*>(&e)) return known->diagnostic().message;
  if (dynamic_cast<const std::bad_alloc*>(&e)) return "not enough memory";
  if (const auto* file = dynamic_cast<const std::filesystem::filesystem_error*>(&e))
    return file->path1().empty() ? file->code().message()
                                 : "'" + file->path1().string() + "': " + file->code().message();
  if (const auto* system = dynamic_cast<const std::system_error*>(&e)) return system->code().message();
  return std::string("this is a defect in terrazzo; please report it with this text: ") + e.what();
}

}  // namespace terrazzo
