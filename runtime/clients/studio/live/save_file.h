// Saving what a person edits: through links, and only over content that the session wrote or was allowed to
// overwrite.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace terrazzo::studio {

// Writes the text beside the file and renames it into place, with the permissions of the file that it
// replaces. A symbolic link stays a link: what it refers to is replaced, or created. Throws Error
// "write-failed", and then the file is as it was.
void save_text(const std::filesystem::path&, const std::string& text);
// The same for a path that is no link, with the permissions of the file `like`. They are set before the text
// is written, so nobody else can read it meanwhile.
void save_text(const std::filesystem::path& final, const std::string& text,
               const std::filesystem::path& like);
// Gives an open file the owner, group and permissions of the file `like`, if it exists. Where the group
// cannot be given, the group gets no access. `final`: the name in messages. Throws Error "write-failed".
void give_mode_of(int descriptor, const std::filesystem::path& like, const std::filesystem::path& final);

// The file that a paint session saves to.
// Reserves a name: creates an empty file, so that no other session chooses the same name, and removes it at
// the end if nothing was saved.
class SaveFile {
 public:
  // Reserves `name`, or the first of name_2, name_3, … that does not exist. Throws Error "write-failed" if
  // the file cannot be created.
  static SaveFile numbered(const std::filesystem::path& name);
  // Reserves `name` itself. Throws Error "usage" if it exists and `overwrite` is false or it is unreadable,
  // "write-failed" if it cannot be created.
  static SaveFile exactly(const std::filesystem::path& name, bool overwrite);

  SaveFile(SaveFile&&) noexcept;
  SaveFile& operator=(SaveFile&&) = delete;
  ~SaveFile();

  const std::filesystem::path& path() const { return path_; }

  // Writes text(path). If another program changed the file, leaves it as it is and writes to the next free
  // number, which becomes path(). Returns true if that happened. Throws Error "write-failed".
  bool write(const std::function<std::string(const std::filesystem::path&)>& text);

 private:
  explicit SaveFile(std::filesystem::path name) : name_(std::move(name)) {}
  void take_next_number();

  std::filesystem::path name_, path_;  // the requested path; the reserved path
  std::string left_;                   // content when this session last read or wrote the file
  bool claimed_ = false;               // created by this session, but nothing saved yet
};

}  // namespace terrazzo::studio
