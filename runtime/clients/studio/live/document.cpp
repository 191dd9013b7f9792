#include "runtime/clients/studio/live/document.h"

#include <fmt/format.h>

#include <utility>

#include "graph/text/utf8.h"
#include "runtime/clients/studio/live/save_file.h"
#include "runtime/files.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostUndoBytes = 64 << 20;

std::string text_of(const fs::path& file) {
  Diagnostics found;
  const auto text = read_graph_text(file, found);
  if (!text) throw Error(found.front());
  return *text;
}

std::shared_ptr<const std::string> shared(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

void check(const std::string& text) {
  if (text.size() > kMaxGraphBytes)
    throw Error("too-large", fmt::format("the text has more than {} MiB", kMaxGraphBytes >> 20));
  if (find_invalid_utf8(text) != std::string::npos) throw Error("not-utf8", "the text is not UTF-8");
}

}  // namespace

Document::Document(fs::path file, bool read_only)
    : file_(fs::absolute(file).lexically_normal()),
      own_(file_),
      now_{shared(text_of(file_)), shared(read_arrangement(file_).value_or(""))},
      disk_(text()),
      arrangement_on_disk_(arrangement()),
      read_only_(read_only) {
  look_for_left();
}

void Document::look_for_left() {
  if (read_only_ || left_) return;
  left_ = UnsavedCopy::left_beside(file_, disk_, recovered_);
}

const ReadGraph& Document::read() const {
  if (!read_) read_ = read_graph(text(), file_);
  return *read_;
}

std::string Document::trouble() const {
  return trouble_ + (trouble_.empty() || arrangement_trouble_.empty() ? "" : "; ") + arrangement_trouble_;
}

// Keeps unsaved text beside the file, so that a crash loses nothing. Removes the copy once it is saved. A
// copy that an earlier session left stays as it is.
void Document::keep_beside() {
  if (read_only_) return;
  try {
    if (saved())
      own_.remove();
    else
      own_.write(text());
    trouble_.clear();
  } catch (const Error& e) {
    trouble_ = "unsaved changes cannot be kept beside the file: " + e.diagnostic().message;
  }
}

void Document::keep_arrangement() {
  if (read_only_ || arrangement() == arrangement_on_disk_) return;
  try {
    write_arrangement(file_, arrangement());
    arrangement_on_disk_ = arrangement();
    arrangement_trouble_.clear();
  } catch (const Error& e) {
    arrangement_trouble_ = "places and notes cannot be kept beside the file: " + e.diagnostic().message;
  }
}

void Document::show(Version v) {
  const bool same = *v.text == text();
  now_ = std::move(v);
  keep_arrangement();
  if (same) return;
  ++revision_;
  read_.reset();
  keep_beside();
}

void Document::step(std::string text, std::string arrangement, const std::string& group) {
  const auto kept = [](auto& before, std::string& now) {
    return *before == now ? before : shared(std::move(now));
  };
  Version next{kept(now_.text, text), kept(now_.arrangement, arrangement)};
  if (next.text == now_.text && next.arrangement == now_.arrangement) return;
  if (group.empty() || group != group_ || undo_.empty()) undo_.push_back(now_);
  group_ = group;
  redo_.clear();
  std::size_t bytes = 0;
  for (std::size_t k = undo_.size(); k-- > 0;) {
    const bool last = k + 1 == undo_.size();
    if (last || undo_[k].text != undo_[k + 1].text) bytes += undo_[k].text->size();
    if (last || undo_[k].arrangement != undo_[k + 1].arrangement) bytes += undo_[k].arrangement->size();
    if (bytes <= kMostUndoBytes) continue;
    undo_.erase(undo_.begin(), undo_.begin() + k);
    break;
  }
  show(std::move(next));
}

void Document::edit(const std::vector<Edit>& edits, const std::string& group, const Places& places) {
  if (edits.empty()) return;
  std::string arrangement = this->arrangement();
  ReadGraph now;
  for (const auto& e : edits) {
    now = edit_document(&e == &edits.front() ? read() : now, file_, e);
    if (e.kind == Edit::Kind::RenameNode) arrangement = arrangement_renamed(arrangement, e.node, e.to);
  }
  check(now.text);
  step(now.text, arrangement_placed(arrangement, places), group);
  read_ = std::move(now);
}

void Document::replace(std::string text, const Places& places) {
  check(text);
  step(std::move(text), arrangement_placed(arrangement(), places));
}

void Document::arrange(std::string arrangement, const std::string& group) {
  follow_arrangement();  // a step of its own, so that nothing that others wrote is lost
  if (!read_only_ && arrangement != this->arrangement()) {
    write_arrangement(file_, arrangement);
    arrangement_on_disk_ = arrangement;
    arrangement_trouble_.clear();
  }
  step(text(), std::move(arrangement), group);
}

bool Document::follow_arrangement() {
  if (read_only_) return false;
  auto theirs = read_arrangement(file_);
  if (!theirs || *theirs == arrangement_on_disk_) return false;
  arrangement_on_disk_ = *theirs;
  if (*theirs == arrangement()) return false;
  step(text(), std::move(*theirs));
  return true;
}

bool Document::undo() {
  if (undo_.empty()) return false;
  redo_.push_back(now_);
  Version before = std::move(undo_.back());
  undo_.pop_back();
  group_.clear();
  show(std::move(before));
  return true;
}

bool Document::redo() {
  if (redo_.empty()) return false;
  undo_.push_back(now_);
  Version after = std::move(redo_.back());
  redo_.pop_back();
  group_.clear();
  show(std::move(after));
  return true;
}

void Document::recover(bool use) {
  if (!left_) return;
  std::string left = std::exchange(recovered_, {});
  if (use) {
    UnsavedCopy mine = std::exchange(own_, std::move(*left_));
    left_.reset();
    step(std::move(left), arrangement());
    keep_beside();  // also if it is the text that is shown already
    mine.remove();
  } else {
    left_->remove();
    left_.reset();
  }
  look_for_left();
}

void Document::save(bool overwrite) {
  if (read_only_)
    throw Error("read-only", fmt::format("'{}' belongs to the program and is not changed", file_.string()),
                "save it as a file of your own");
  if (!overwrite && changed_on_disk())
    throw Error("file-changed", fmt::format("another program changed '{}'", file_.string()),
                "reload it, or overwrite it");
  save_text(file_, text());
  disk_ = text();
  keep_beside();
  if (recovered_ == disk_) recover(false);  // what an earlier session left is saved too
}

void Document::save_as(const fs::path& file, const std::string& text) {
  check(text);
  std::error_code error;
  if (fs::exists(file, error))
    throw Error("file-exists", fmt::format("'{}' already exists", file.string()), "choose another name");
  fs::create_directories(file.parent_path(), error);
  SaveFile place = SaveFile::exactly(file, false);
  place.write([&](const fs::path&) { return text; });
  own_.remove();  // its text is in the new file
  if (text != this->text()) {
    undo_.clear();
    redo_.clear();
  }
  file_ = fs::absolute(place.path()).lexically_normal();
  own_ = UnsavedCopy(file_);
  left_.reset();  // what an earlier session left stays beside the other file
  now_.text = shared(text);
  disk_ = text;
  recovered_.clear();
  trouble_.clear();
  arrangement_trouble_.clear();
  read_only_ = false;
  group_.clear();
  ++revision_;
  read_.reset();
  arrangement_on_disk_ = read_arrangement(file_).value_or("");
  keep_arrangement();
}

bool Document::changed_on_disk() const {
  const auto now = read_file(file_, kMaxGraphBytes);
  return !now || *now != disk_;
}

void Document::reload() {
  std::string now = text_of(file_);
  check(now);
  disk_ = now;
  step(std::move(now), arrangement());
  keep_beside();
}

}  // namespace terrazzo::studio
