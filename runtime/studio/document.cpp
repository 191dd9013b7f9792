#include "runtime/studio/document.h"

#include <fmt/format.h>

#include <utility>

#include "graph/utf8.h"
#include "runtime/files.h"
#include "runtime/studio/save_file.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostUndoBytes = 64 << 20;

std::string read(const fs::path& file) {
  Diagnostics found;
  const auto text = read_graph_text(file, found);
  if (!text) throw Error(found.front());
  return *text;
}

void check(const std::string& text) {
  if (text.size() > max_graph_bytes)
    throw Error("too-large", fmt::format("the text has more than {} MiB", max_graph_bytes >> 20));
  if (find_invalid_utf8(text) != std::string::npos) throw Error("not-utf8", "the text is not UTF-8");
}

}  // namespace

Document::Document(fs::path file, bool read_only)
    : file_(fs::absolute(file).lexically_normal()),
      beside_(file_.parent_path() / ("." + file_.filename().string() + ".unsaved")),
      text_(read(file_)),
      disk_(text_),
      read_only_(read_only) {
  if (read_only_) return;
  if (const auto left = read_file(beside_); left && *left != text_ && left->size() <= max_graph_bytes)
    recovered_ = *left;
}

// Keeps unsaved text beside the file, so that a crash loses nothing. Removes the copy once it is saved.
void Document::keep_beside() {
  if (read_only_ || !recovered_.empty()) return;
  std::error_code error;
  if (saved()) {
    fs::remove(beside_, error);
    return;
  }
  try {
    write_text_atomically(beside_, text_);
    trouble_.clear();
  } catch (const Error& e) {
    trouble_ = "unsaved changes cannot be kept beside the file: " + e.diagnostic().message;
  }
}

void Document::step(std::string text, const std::string& group) {
  if (text == text_) return;
  if (group.empty() || group != group_ || undo_.empty()) undo_.push_back(text_);
  group_ = group;
  redo_.clear();
  text_ = std::move(text);
  std::size_t bytes = 0;
  for (std::size_t k = undo_.size(); k-- > 0;)
    if ((bytes += undo_[k].size()) > kMostUndoBytes) {
      undo_.erase(undo_.begin(), undo_.begin() + static_cast<std::ptrdiff_t>(k));
      break;
    }
  keep_beside();
}

void Document::edit(const std::vector<Edit>& edits, const std::string& group) {
  std::string text = text_;
  for (const auto& e : edits) text = edit_document(text, file_, e);
  check(text);
  step(std::move(text), group);
}

void Document::replace(std::string text) {
  check(text);
  step(std::move(text));
}

bool Document::undo() {
  if (undo_.empty()) return false;
  redo_.push_back(std::exchange(text_, std::move(undo_.back())));
  undo_.pop_back();
  group_.clear();
  keep_beside();
  return true;
}

bool Document::redo() {
  if (redo_.empty()) return false;
  undo_.push_back(std::exchange(text_, std::move(redo_.back())));
  redo_.pop_back();
  group_.clear();
  keep_beside();
  return true;
}

void Document::recover(bool use) {
  std::string left = std::exchange(recovered_, {});
  if (left.empty()) return;
  if (use)
    step(std::move(left));
  else
    keep_beside();
}

void Document::save(bool overwrite) {
  if (read_only_)
    throw Error("read-only", fmt::format("'{}' belongs to the program and is not changed", file_.string()),
                "save it as a file of your own");
  if (!overwrite && changed_on_disk())
    throw Error("file-changed", fmt::format("another program changed '{}'", file_.string()),
                "reload it, or overwrite it");
  write_text_atomically(file_, text_);
  disk_ = text_;
  recovered_.clear();
  keep_beside();
}

void Document::save_as(const fs::path& file, const std::string& text) {
  check(text);
  std::error_code error;
  if (fs::exists(file, error))
    throw Error("file-exists", fmt::format("'{}' already exists", file.string()), "choose another name");
  fs::create_directories(file.parent_path(), error);
  SaveFile place = SaveFile::exactly(file, false);
  place.write([&](const fs::path&) { return text; });
  if (!read_only_ && recovered_.empty()) fs::remove(beside_, error);  // its text is in the new file
  if (text != text_) undo_.clear(), redo_.clear();
  file_ = fs::absolute(place.path()).lexically_normal();
  beside_ = file_.parent_path() / ("." + file_.filename().string() + ".unsaved");
  text_ = disk_ = text;
  recovered_.clear(), trouble_.clear();
  read_only_ = false, group_.clear();
}

bool Document::changed_on_disk() const {
  const auto now = read_file(file_);
  return !now || *now != disk_;
}

void Document::reload() {
  std::string now = read(file_);
  check(now);
  disk_ = now;
  step(std::move(now));
  keep_beside();
}

}  // namespace terrazzo::studio
