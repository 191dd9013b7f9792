#include "graph/document/patch_yaml.h"

#include <algorithm>

#include "graph/document/yaml_text.h"
#include "graph/document/yaml_tree.h"

namespace terrazzo {
namespace {

class Patch {
 public:
  explicit Patch(const std::string& text) : text_(text), root_(read_yaml_tree(text)) {}

  bool valid() const { return root_ && root_->kind == YamlNode::Kind::Map; }

  // Follows the path as far as it exists. Returns the number of keys found.
  std::size_t follow(const YamlPath& path) {
    map_ = &*root_;
    entry_ = nullptr;
    for (std::size_t k = 0; k < path.size(); ++k) {
      if (entry_) {
        if (entry_->second.kind != YamlNode::Kind::Map) return k;
        map_ = &entry_->second;
      }
      const auto at = std::find_if(map_->entries.begin(), map_->entries.end(), [&](const YamlEntry& e) {
        return e.first.text == path[k] && e.first.end > e.first.begin;
      });
      if (at == map_->entries.end()) {
        entry_ = nullptr;
        return k;
      }
      entry_ = &*at;
    }
    return path.size();
  }

  const YamlNode& map() const { return *map_; }
  const YamlEntry* entry() const { return entry_; }

  std::string replaced(std::size_t begin, std::size_t end, const std::string& by) const {
    return text_.substr(0, begin) + by + text_.substr(end);
  }

  // Whether only white space lies in the range.
  bool blank(std::size_t begin, std::size_t end) const {
    return text_.find_first_not_of(" \t\r\n", begin) >= end;
  }
  std::size_t line_start(std::size_t at) const {
    const auto before = at == 0 ? std::string::npos : text_.rfind('\n', at - 1);
    return before == std::string::npos ? 0 : before + 1;
  }
  // Behind the line break of the line that contains `at`.
  std::size_t line_end(std::size_t at) const {
    const auto end = text_.find('\n', at);
    return end == std::string::npos ? text_.size() : end + 1;
  }

  std::optional<std::string> with_value(const YamlEntry& e, const std::string& value) const {
    const YamlNode& old = e.second;
    // A value below its key moves behind the colon.
    const auto colon = text_.find(':', e.first.end);
    if (colon < old.begin && blank(colon + 1, old.begin))
      return replaced(colon + 1, std::max(old.end, colon + 1), " " + value);
    if (colon == std::string::npos || colon > old.begin) return {};
    return replaced(old.begin, std::max(old.begin, old.end), value);
  }

  // The indentation of a block map's entries, or nothing if they do not start their lines.
  std::optional<std::string> indentation() const {
    if (map_->flow || map_->entries.empty()) return {};
    const std::size_t key = map_->entries.front().first.begin, start = line_start(key);
    if (!blank(start, key)) return {};
    return text_.substr(start, key - start);
  }

  std::optional<std::string> with_entry(const std::string& key, const std::string& value) const {
    if (map_->flow) {
      const std::string text = yaml_word(key) + ": " + value;
      if (map_->entries.empty()) return replaced(map_->begin, map_->end, "{" + text + "}");
      const std::size_t end = end_of(map_->entries.back());
      return replaced(end, end, ", " + text);
    }
    return with_lines(yaml_word(key) + ": " + value);
  }

  // Adds lines behind the last entry of a block map.
  std::optional<std::string> with_lines(const std::string& lines) const {
    const auto indent = indentation();
    if (!indent) return {};
    const std::size_t end = line_end(end_of(map_->entries.back()));
    std::string added = end > 0 && text_[end - 1] != '\n' ? "\n" : "";
    for (std::size_t at = 0; at < lines.size();) {
      const auto stop = std::min(lines.find('\n', at), lines.size());
      added += *indent + lines.substr(at, stop - at) + "\n";
      at = stop + 1;
    }
    return replaced(end, end, added);
  }

  // Adds lines to an inner map.
  std::optional<std::string> with_lines_in(const YamlNode& map, const std::string& lines) {
    if (map.kind != YamlNode::Kind::Map) return {};
    if (!map.entries.empty()) {
      map_ = &map;
      return with_lines(lines);
    }
    std::string added = "\n";
    for (std::size_t at = 0; at < lines.size();) {
      const auto stop = std::min(lines.find('\n', at), lines.size());
      added += "  " + lines.substr(at, stop - at) + "\n";
      at = stop + 1;
    }
    added.pop_back();
    return replaced(map.begin, map.end, added);
  }

  std::optional<std::string> with_item(const YamlNode& list, const std::string& item) const {
    if (list.flow) {
      if (list.items.empty()) return replaced(list.begin, list.end, "[" + item + "]");
      return replaced(list.items.back().end, list.items.back().end, ", " + item);
    }
    const std::size_t start = line_start(list.begin);
    if (list.items.empty() || !blank(start, list.begin)) return {};
    const std::size_t end = line_end(list.items.back().end);
    return replaced(
        end, end,
        (text_[end - 1] == '\n' ? "" : "\n") + text_.substr(start, list.begin - start) + "- " + item + "\n");
  }

  std::optional<std::string> without_item(const YamlNode& list, std::size_t k) const {
    if (k >= list.items.size() || list.items.size() == 1) return {};
    const auto& items = list.items;
    if (list.flow)
      return k == 0 ? replaced(items[0].begin, items[1].begin, "")
                    : replaced(items[k - 1].end, items[k].end, "");
    return replaced(line_start(items[k].begin), line_end(items[k].end), "");
  }

  std::optional<std::string> without_entry() const {
    const std::size_t k = entry_ - map_->entries.data();
    if (map_->flow) {
      if (map_->entries.size() == 1) return replaced(map_->begin, map_->end, "{}");
      if (k == 0) return replaced(entry_->first.begin, map_->entries[1].first.begin, "");
      return replaced(end_of(map_->entries[k - 1]), end_of(*entry_), "");
    }
    if (map_->entries.size() == 1 || !indentation()) return {};
    return replaced(line_start(entry_->first.begin), line_end(end_of(*entry_)), "");
  }

 private:
  std::size_t end_of(const YamlEntry& e) const {
    const auto colon = text_.find(':', e.first.end);  // of an entry without a value
    return std::max({e.first.end, e.second.end, e.second.end <= e.first.end ? colon + 1 : 0});
  }

  const std::string& text_;
  std::optional<YamlNode> root_;
  const YamlNode* map_ = nullptr;     // the last map on the path
  const YamlEntry* entry_ = nullptr;  // the entry of the whole path, or the last one that is no map
};

}  // namespace

std::optional<std::string> set_yaml_entry(const std::string& text, const YamlPath& path,
                                          const std::string& value) {
  Patch patch(text);
  if (!patch.valid() || path.empty()) return {};
  const std::size_t found = patch.follow(path);
  std::string inner = value;
  for (std::size_t k = path.size(); k-- > found + (patch.entry() ? 0 : 1);)
    inner = "{" + yaml_word(path[k]) + ": " + inner + "}";
  if (!patch.entry()) return patch.with_entry(path[found], inner);
  // An entry without a value holds no mapping yet; any other value is no place for one.
  if (found < path.size() && patch.entry()->second.end > patch.entry()->second.begin) return {};
  return patch.with_value(*patch.entry(), inner);
}

std::optional<std::string> remove_yaml_entry(const std::string& text, const YamlPath& path) {
  Patch patch(text);
  if (!patch.valid() || path.empty() || patch.follow(path) < path.size()) return {};
  return patch.without_entry();
}

std::optional<std::string> add_yaml_block(const std::string& text, const YamlPath& path,
                                          const std::string& block, const std::string& value) {
  Patch patch(text);
  if (!patch.valid() || path.empty()) return {};
  if (patch.follow(path) + 1 != path.size() || patch.entry() || patch.map().flow)
    return set_yaml_entry(text, path, value);
  std::string lines = yaml_word(path.back()) + ":\n";
  for (std::size_t at = 0; at < block.size();) {
    const auto stop = std::min(block.find('\n', at), block.size());
    lines += "  " + block.substr(at, stop - at) + "\n";
    at = stop + 1;
  }
  return patch.with_lines(lines);
}

std::optional<std::string> add_yaml_lines(const std::string& text, const YamlPath& path,
                                          const std::string& lines) {
  Patch patch(text);
  if (!patch.valid() || path.empty() || patch.follow(path) < path.size()) return {};
  return patch.with_lines_in(patch.entry()->second, lines);
}

std::optional<std::string> append_yaml_item(const std::string& text, const YamlPath& path,
                                            const std::string& item) {
  Patch patch(text);
  if (!patch.valid() || path.empty() || patch.follow(path) < path.size()) return {};
  const YamlNode& list = patch.entry()->second;
  if (list.kind != YamlNode::Kind::List) return {};
  return patch.with_item(list, item);
}

std::optional<std::string> remove_yaml_item(const std::string& text, const YamlPath& path,
                                            std::size_t index) {
  Patch patch(text);
  if (!patch.valid() || path.empty() || patch.follow(path) < path.size()) return {};
  const YamlNode& list = patch.entry()->second;
  if (list.kind != YamlNode::Kind::List) return {};
  return patch.without_item(list, index);
}

std::optional<std::string> rename_yaml_entry(const std::string& text, const YamlPath& path,
                                             const std::string& key) {
  Patch patch(text);
  if (!patch.valid() || path.empty() || patch.follow(path) < path.size()) return {};
  const YamlNode& old = patch.entry()->first;
  return patch.replaced(old.begin, old.end, yaml_word(key));
}

}  // namespace terrazzo
