#include "graph/document/yaml_tree.h"

#include <yaml.h>

#include <algorithm>
#include <string_view>

namespace terrazzo {
namespace {

constexpr int kDeepest = 64;

class TreeReader {
 public:
  explicit TreeReader(const std::string& text) : text_(text) {
    // libyaml counts characters, and does not count a byte order mark.
    const std::size_t first = std::string_view(text).starts_with("\xef\xbb\xbf") ? 3 : 0;
    for (std::size_t i = first; i < text.size(); ++i)
      if ((text[i] & 0xc0) != 0x80) bytes_.push_back(i);
    bytes_.push_back(text.size());
    ::yaml_parser_initialize(&parser_);
    ::yaml_parser_set_input_string(&parser_, reinterpret_cast<const unsigned char*>(text.data()),
                                   text.size());
  }
  ~TreeReader() { ::yaml_parser_delete(&parser_); }
  TreeReader(const TreeReader&) = delete;

  std::optional<YamlNode> read() {
    YamlNode root;
    for (const auto expected : {YAML_STREAM_START_EVENT, YAML_DOCUMENT_START_EVENT}) {
      const Event e(parser_);
      if (!e.valid || e.event.type != expected) return {};
    }
    if (!next(root, 0)) return {};
    return root;
  }

 private:
  struct Event {
    yaml_event_t event;
    bool valid;
    explicit Event(yaml_parser_t& parser) : valid(::yaml_parser_parse(&parser, &event)) {}
    ~Event() {
      if (valid) ::yaml_event_delete(&event);
    }
    Event(const Event&) = delete;
  };

  std::size_t byte(const yaml_mark_t& mark) const { return bytes_[std::min(mark.index, bytes_.size() - 1)]; }

  // The first byte of a value behind its anchor and tag.
  std::size_t behind_properties(std::size_t at) const {
    while (at < text_.size() && (text_[at] == '&' || text_[at] == '!')) {
      at = std::min(text_.find_first_of(" \t\r\n", at), text_.size());
      at = std::min(text_.find_first_not_of(" \t\r\n", at), text_.size());
    }
    return at;
  }

  std::size_t without_space(std::size_t begin, std::size_t end) const {
    while (end > begin && std::string_view(" \t\r\n").find(text_[end - 1]) != std::string_view::npos) --end;
    return end;
  }

  // Reads a value into `out`. Returns false at the end of a collection and at errors; the latter set failed_.
  bool next(YamlNode& out, int depth) {
    const Event e(parser_);
    if (!e.valid || depth > kDeepest) {
      failed_ = true;
      return false;
    }
    out.begin = byte(e.event.start_mark);
    out.end = byte(e.event.end_mark);
    switch (e.event.type) {
      case YAML_ALIAS_EVENT:
        out.kind = YamlNode::Kind::Alias;
        return true;
      case YAML_SCALAR_EVENT: {
        const auto& s = e.event.data.scalar;
        out.text.assign(reinterpret_cast<const char*>(s.value), s.length);
        if (s.anchor || s.tag) out.begin = std::min(behind_properties(out.begin), out.end);
        out.end = without_space(out.begin, out.end);
        return true;
      }
      case YAML_MAPPING_START_EVENT: {
        out.kind = YamlNode::Kind::Map;
        const auto& m = e.event.data.mapping_start;
        out.flow = m.style == YAML_FLOW_MAPPING_STYLE;
        if (m.anchor || m.tag) out.begin = behind_properties(out.begin);
        return collect(out, depth);
      }
      case YAML_SEQUENCE_START_EVENT: {
        out.kind = YamlNode::Kind::List;
        const auto& l = e.event.data.sequence_start;
        out.flow = l.style == YAML_FLOW_SEQUENCE_STYLE;
        if (l.anchor || l.tag) out.begin = behind_properties(out.begin);
        return collect(out, depth);
      }
      default:
        last_end_ = byte(e.event.end_mark);
        return false;
    }
  }

  // Reads the children of a map or list. The end mark of block style lies behind the comments that follow, so
  // the last child determines the end.
  bool collect(YamlNode& out, int depth) {
    std::size_t end = out.begin;
    while (true) {
      YamlNode child;
      if (!next(child, depth + 1)) break;
      end = std::max(end, child.end);
      if (out.kind == YamlNode::Kind::List) {
        out.items.push_back(std::move(child));
        continue;
      }
      YamlNode value;
      if (!next(value, depth + 1)) {
        failed_ = true;
        return false;
      }
      end = std::max(end, value.end);
      out.entries.push_back({std::move(child), std::move(value)});
    }
    if (failed_) return false;
    out.end = out.flow ? last_end_ : end;
    return true;
  }

  const std::string& text_;
  std::vector<std::size_t> bytes_;  // where each character begins
  yaml_parser_t parser_;
  std::size_t last_end_ = 0;  // of the collection that ended last
  bool failed_ = false;
};

}  // namespace

std::optional<YamlNode> read_yaml_tree(const std::string& text) { return TreeReader(text).read(); }

}  // namespace terrazzo
