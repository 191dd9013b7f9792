// An output file whose every write failure becomes an Error.
#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace terrazzo {

class CheckedFile {
 public:
  // Opens and truncates the file. Throws Error "write-failed".
  explicit CheckedFile(const std::filesystem::path&);
  // Throws std::ios_base::failure if a write fails; `guard` converts it to Error "write-failed".
  std::ostream& stream() { return stream_; }
  // Calls `write(stream)`, then flushes and closes the file. Throws Error "write-failed" with the system's
  // reason.
  template <class Write>
  void guard(Write&& write) {
    try {
      write(stream());
      close();
    } catch (const std::ios_base::failure&) {
      fail();
    }
  }

 private:
  void close();
  [[noreturn]] void fail() const;
  std::ofstream stream_;
};

// Writes the whole content.
void write_bytes(const std::filesystem::path&, std::string_view content);

}  // namespace terrazzo
