// The graph file that the Studio edits: its text, undo, saving, and a copy beside it until it is saved.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "graph/edit_document.h"

namespace terrazzo::studio {

class Document {
 public:
  // Reads the file. `read_only`: saving is refused. Throws Error "no-file" or "too-large".
  explicit Document(std::filesystem::path file, bool read_only = false);

  const std::filesystem::path& file() const { return file_; }
  const std::string& text() const { return text_; }
  bool read_only() const { return read_only_; }
  bool saved() const { return text_ == disk_; }
  bool can_undo() const { return !undo_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  // Unsaved text that an earlier session left beside the file; "" if there is none.
  const std::string& recovered() const { return recovered_; }
  // Why the unsaved text cannot be kept beside the file; "" if it can.
  const std::string& trouble() const { return trouble_; }

  // Applies all edits as one step of undo, or none of them. Throws what edit_document() throws. Edits with
  // the same `group` continue one step, as a slider does while it moves; "": none.
  void edit(const std::vector<Edit>&, const std::string& group = {});
  // Replaces the text, as one step. Throws Error "too-large" or "not-utf8".
  void replace(std::string text);
  bool undo();
  bool redo();
  // Uses the recovered text, as a step of undo, or discards it.
  void recover(bool use);

  // Throws Error "read-only", "write-failed", and "file-changed" if another program changed the file, unless
  // `overwrite`.
  void save(bool overwrite);
  // Writes `text`, the document for its new place, to a file that does not exist yet, and continues with that
  // file. Undo goes back beyond this only if the text is unchanged. Throws Error "file-exists" or
  // "write-failed".
  void save_as(const std::filesystem::path& file, const std::string& text);
  // Whether another program changed the file.
  bool changed_on_disk() const;
  // Reads the file again, as one step of undo.
  void reload();

 private:
  void step(std::string text, const std::string& group = {});
  void keep_beside();

  std::filesystem::path file_, beside_;
  std::string text_, disk_;  // disk_: when the file was last read or written
  std::string recovered_, trouble_;
  std::vector<std::string> undo_, redo_;
  std::string group_;  // of the last step
  bool read_only_;
};

}  // namespace terrazzo::studio
