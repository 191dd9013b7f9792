// Copies of unsaved text beside a graph file, so that a crash loses nothing.
//
// They are named .NAME.unsaved, .NAME.unsaved_2, and so on. The program that writes a copy holds a lock on it
// as long as it runs. A copy without a lock was left by a program that ended, and is offered to the user.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace terrazzo::studio {

class UnsavedCopy {
 public:
  // No copy yet. `file`: the graph file, whose permissions the copy gets.
  explicit UnsavedCopy(std::filesystem::path file) : file_(std::move(file)) {}
  UnsavedCopy(UnsavedCopy&&) noexcept;
  UnsavedCopy& operator=(UnsavedCopy&&) noexcept;
  ~UnsavedCopy();  // gives up the lock; the copy stays

  // The copy that was changed last, of those that ended programs left, which this one holds from now on.
  // Removes copies of `saved`, the text in the file, on the way. `text` is set to its text.
  static std::optional<UnsavedCopy> left_beside(const std::filesystem::path& file, const std::string& saved,
                                                std::string& text);

  // Replaces the text of the copy. The first time, makes a copy under a name that is free. Throws Error
  // "write-failed".
  void write(const std::string& text);
  void remove();
  const std::filesystem::path& path() const { return path_; }  // "" if there is no copy

 private:
  static std::optional<UnsavedCopy> take(const std::filesystem::path& file, const std::filesystem::path& copy,
                                         bool create);
  void take_free_name();
  bool is_in_place() const;
  void give_up();

  std::filesystem::path file_, path_;
  int descriptor_ = -1;  // with the lock
};

}  // namespace terrazzo::studio
