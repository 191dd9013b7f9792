// The file that a paint session saves to. It replaces only what this session wrote.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace terrazzo::studio {

// Holds a name from the start: the file is created empty, so that no other session takes the same name, and
// removed at the end if nothing was saved.
class SaveFile {
 public:
  // `name`, or the first of name_2, name_3, ... that does not exist.
  // Throws Error "write-failed" if the file cannot be created.
  static SaveFile numbered(const std::filesystem::path& name);
  // `name` itself. Throws Error "usage" if it exists and `overwrite` is false, "write-failed" if it cannot be
  // created.
  static SaveFile exactly(const std::filesystem::path& name, bool overwrite);

  SaveFile(SaveFile&&) noexcept;
  SaveFile& operator=(SaveFile&&) = delete;
  ~SaveFile();

  const std::filesystem::path& path() const { return path_; }

  // Writes text(path). If the file is not as this session left it, its content stays and the text goes to the
  // next free number, which is path() from then on. Returns whether that happened. Throws Error
  // "write-failed".
  bool write(const std::function<std::string(const std::filesystem::path&)>& text);

 private:
  explicit SaveFile(std::filesystem::path name) : name_(std::move(name)) {}
  void take_next_number();

  std::filesystem::path name_, path_;  // as asked for; the one held
  std::string left_;                   // what the file held when this session last looked at it or wrote it
  bool claimed_ = false;               // created by this session, with nothing saved yet
};

}  // namespace terrazzo::studio
