// The graph file that the Studio edits: its text, the arrangement beside it, undo, saving, and a copy beside
// it until it is saved.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "graph/document/edit_document.h"
#include "runtime/clients/studio/live/arrangement.h"
#include "runtime/clients/studio/live/unsaved_copy.h"

namespace terrazzo::studio {

class Document {
 public:
  // Reads the file. `read_only`: saving is refused. Throws Error "no-file" or "too-large".
  explicit Document(std::filesystem::path file, bool read_only = false);

  const std::filesystem::path& file() const { return file_; }
  const std::string& text() const { return *now_.text; }
  // The text with what it says. Valid until the text changes.
  const ReadGraph& read() const;
  // Where nodes, notes and frames are, as a text: see arrangement.h. It is written beside the graph with
  // every change, and is no part of what is saved. That of a document that is read only stays in memory.
  const std::string& arrangement() const { return *now_.arrangement; }
  // Grows whenever the text, or the file that it belongs to, changes.
  std::uint64_t revision() const { return revision_; }
  bool read_only() const { return read_only_; }
  bool saved() const { return text() == disk_; }
  bool can_undo() const { return !undo_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  // Unsaved text that an earlier session left beside the file; "" if there is none. Sessions that still run
  // keep their text in copies of their own.
  const std::string& recovered() const { return recovered_; }
  // Why unsaved text, or the arrangement, cannot be kept beside the file; "" if they can.
  std::string trouble() const;

  // Applies all edits as one step of undo, or none of them. Throws what edit_document() throws. Edits with
  // the same `group` continue one step, as a slider does while it moves; "": none. `places`: where nodes go
  // that the edits add. A node that is renamed keeps its place.
  void edit(const std::vector<Edit>&, const std::string& group = {}, const Places& places = {});
  // Replaces the text, as one step. Throws Error "too-large" or "not-utf8".
  void replace(std::string text, const Places& places = {});
  // Replaces the arrangement by a text of arrangement_text(), as a step of undo. Throws Error "file-exists"
  // or "write-failed", and changes nothing then.
  void arrange(std::string arrangement, const std::string& group = {});
  bool undo();
  bool redo();
  // Uses the recovered text, as a step of undo, or discards it. Nothing else removes it. If an earlier
  // session left another one, that follows.
  void recover(bool use);
  // Looks again for text that earlier sessions left, after another document of the file has ended.
  void look_for_left();

  // A symbolic link stays one, and the file that it refers to is replaced. Throws Error "read-only",
  // "write-failed", and "file-changed" if another program changed the file, unless `overwrite`.
  void save(bool overwrite);
  // Writes `text`, the document for its new place, to a file that does not exist yet, and continues with that
  // file. Undo goes back beyond this only if the text is unchanged. Throws Error "file-exists" or
  // "write-failed".
  void save_as(const std::filesystem::path& file, const std::string& text);
  // Whether another program changed the file.
  bool changed_on_disk() const;
  // Reads the file again, as one step of undo.
  void reload();
  // Reads the arrangement again if another program changed it, as one step of undo. Whether it did.
  bool follow_arrangement();

 private:
  struct Version {
    std::shared_ptr<const std::string> text, arrangement;  // steps share what they do not change
  };

  void step(std::string text, std::string arrangement, const std::string& group = {});
  void show(Version);
  void keep_beside();
  void keep_arrangement();

  std::filesystem::path file_;
  UnsavedCopy own_;                  // of this document's text
  std::optional<UnsavedCopy> left_;  // by an earlier session; its text is recovered_
  Version now_;
  std::string disk_, arrangement_on_disk_;  // when these files were last read or written
  std::string recovered_, trouble_, arrangement_trouble_;
  std::vector<Version> undo_, redo_;
  std::string group_;  // of the last step
  std::uint64_t revision_ = 0;
  mutable std::optional<ReadGraph> read_;
  bool read_only_;
};

}  // namespace terrazzo::studio
