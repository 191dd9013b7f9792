#include "runtime/report/methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "graph/text/utf8.h"
#include "runtime/run_result.h"

namespace terrazzo {
namespace {

constexpr std::size_t kLongestValue = 60, kMostNames = 3;  // bytes, nodes

// Of one sentence.
struct MethodStep {
  const NodeType* type = nullptr;
  std::vector<std::string> names;  // of the nodes
  std::string settings;
};

// The first sentence, without its full stop. "Rec. 709" ends none.
std::string first_sentence(const std::string& doc) {
  for (std::size_t i = doc.find(". "); i != std::string::npos; i = doc.find(". ", i + 1))
    if (!doc.substr(0, i).ends_with("Rec")) return doc.substr(0, i);
  return doc.ends_with('.') ? doc.substr(0, doc.size() - 1) : doc;
}

std::string after_a_name(std::string sentence) {
  if (!sentence.empty())
    sentence[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(sentence[0])));
  return sentence;
}

std::string value_text(const Parameter& p, const ParameterValue& value) {
  std::string text = written(value);
  if (p.kind == ParameterKind::InputPath)
    if (const auto* path = std::get_if<std::string>(&value))
      text = std::filesystem::path(*path).filename().string();
  text = printable(text, kLongestValue);
  const bool word = std::find(p.keywords.begin(), p.keywords.end(), text) != p.keywords.end();
  return p.unit.empty() || word ? text : text + " " + p.unit;
}

// Whether a person would name the parameter: it differs from its default, or is a seed, which a result
// depends on.
bool worth_naming(const Parameter& p, const ParameterValue& value) {
  if (p.kind == ParameterKind::OutputPath) return false;
  return !p.value || canonical(*p.value) != canonical(value) || p.name == "seed";
}

std::string settings_of(const GraphNode& node) {
  std::vector<std::string> all;
  for (const Parameter& p : node.type->parameters) {
    const auto set = node.parameters.find(p.name);
    const bool given = set != node.parameters.end();
    if (!given && !p.value) continue;
    const ParameterValue& value = given ? set->second.value : *p.value;
    if (worth_naming(p, value)) all.push_back(p.name + " = " + value_text(p, value));
  }
  return fmt::format("{}", fmt::join(all, ", "));
}

std::vector<MethodStep> steps_of(const Graph& graph, const std::vector<int>& targets) {
  std::vector<MethodStep> out;
  const std::vector<bool> needed = needed_nodes(graph, targets.empty() ? graph.sinks() : targets);
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const GraphNode& node = graph.nodes[i];
    if (!needed[i] || node.type->writes_files) continue;
    const std::string settings = settings_of(node);
    const auto same = std::find_if(out.begin(), out.end(), [&](const MethodStep& s) {
      return s.type == node.type && s.settings == settings;
    });
    if (same == out.end())
      out.push_back({node.type, {node.path}, settings});
    else
      same->names.push_back(node.path);
  }
  return out;
}

std::string trimmed(std::string text) {
  const auto from = text.find_first_not_of(' ');
  if (from == std::string::npos) return {};
  text = text.substr(from, text.find_last_not_of(' ') - from + 1);
  return text.ends_with('.') ? text.substr(0, text.size() - 1) : text;
}

// The parts of a declared source between semicolons that are in no parentheses.
std::vector<std::string> parts_of(const std::string& source) {
  std::vector<std::string> out(1);
  int depth = 0;
  for (const char c : source) {
    depth += (c == '(') - (c == ')');
    if (c == ';' && depth == 0)
      out.emplace_back();
    else
      out.back() += c;
  }
  return out;
}

// "See X" stands for the source of the node X.
std::vector<std::string> sources_of(const NodeType& type, const Registry& registry, int depth = 0) {
  std::vector<std::string> out;
  for (const std::string& written : parts_of(type.source)) {
    const std::string part = trimmed(written);
    if (part.empty() || part.starts_with("None") || part.find("see README") != std::string::npos) continue;
    if (!part.starts_with("See ") && !part.starts_with("see ")) {
      out.push_back(part);
      continue;
    }
    const std::string name = part.substr(4, std::min(part.find(','), part.size()) - 4);
    if (const NodeType* other = registry.find(name); other && depth < 3)
      for (const std::string& more : sources_of(*other, registry, depth + 1)) out.push_back(more);
  }
  return out;
}

// Numbers of the sources in `all`, which grows: " [1, 2]", or "" without sources.
std::string citations(const std::vector<std::string>& sources, std::vector<std::string>& all) {
  std::vector<std::size_t> numbers;
  for (const std::string& source : sources) {
    auto it = std::find(all.begin(), all.end(), source);
    if (it == all.end()) it = all.insert(all.end(), source);
    const std::size_t number = it - all.begin() + 1;
    if (std::find(numbers.begin(), numbers.end(), number) == numbers.end()) numbers.push_back(number);
  }
  return numbers.empty() ? "" : fmt::format(" [{}]", fmt::join(numbers, ", "));
}

std::string names_text(const std::vector<std::string>& names) {
  if (names.size() <= kMostNames) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{}, … {}, {} nodes", names.front(), names.back(), names.size());
}

}  // namespace

std::string methods_text(const Graph& graph, const std::vector<int>& targets, const Registry& registry,
                         const std::string& version) {
  const std::vector<MethodStep> steps = steps_of(graph, targets);
  if (steps.empty()) throw Error("nothing-to-describe", "no node computes anything", "choose other targets");
  std::vector<std::string> sources;
  std::string text = fmt::format("Results were computed with Terrazzo {}", version);
  if (!graph.name.empty()) text += fmt::format(" (graph “{}”)", printable(graph.name));
  text += " in these steps.";
  for (const MethodStep& s : steps) {
    text += fmt::format(" {} (version {}; {}) {}{}", s.type->name, s.type->version, names_text(s.names),
                        after_a_name(first_sentence(s.type->doc)),
                        citations(sources_of(*s.type, registry), sources));
    if (!s.settings.empty()) text += "; " + s.settings;
    text += '.';
  }
  text += " Other settings have the defaults of these versions.\n";
  if (sources.empty()) return text;
  text += "\nSources:\n";
  for (std::size_t i = 0; i < sources.size(); ++i) text += fmt::format("[{}] {}\n", i + 1, sources[i]);
  return text;
}

}  // namespace terrazzo
