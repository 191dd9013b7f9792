// Opening files for reading. Everything that reads a file by its name opens it here, so that no name makes
// the program wait for a pipe or read from a device without end.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace terrazzo {

// A regular file that is open for reading.
class InputFile {
 public:
  // Opens the file without waiting. Anything else than a regular file with a size stays closed: a pipe, a
  // device, a folder, a socket, or a file whose content the kernel makes up, as in /proc.
  explicit InputFile(const std::filesystem::path&);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  explicit operator bool() const { return descriptor_ >= 0; }
  // Why it is not open or a read failed, such as "it is a pipe"; "" if there is no problem.
  const std::string& trouble() const { return trouble_; }
  const struct stat& status() const { return status_; }  // when it was opened
  std::uint64_t size() const { return static_cast<std::uint64_t>(status_.st_size); }
  int descriptor() const { return descriptor_; }

  // Reads on from where the last call ended. Returns fewer bytes only at the end of the file or after an
  // error.
  std::size_t read(char* to, std::size_t bytes);

 private:
  bool has_content_without_size();

  int descriptor_ = -1;
  struct stat status_ {};
  std::string trouble_;
};

// The content of a file, or why there is none.
struct FileText {
  std::string text;
  std::string trouble;     // "" if the file was read
  bool too_large = false;  // the file has more bytes than allowed, and was not read
  explicit operator bool() const { return trouble.empty(); }
};

// Reads a regular file. Its size is checked before anything is read or allocated.
FileText read_input_file(const std::filesystem::path&, std::uint64_t most_bytes);

// At most the first `bytes` bytes of a regular file; "" if it cannot be read.
std::string read_beginning(const std::filesystem::path&, std::size_t bytes);

}  // namespace terrazzo
