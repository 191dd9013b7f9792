#include "graph/document/write_graph.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <functional>

#include "graph/document/raw_document.h"

namespace terrazzo {
namespace {

void emit(YAML::Emitter& out, const ParameterValue& v) {
  std::visit(
      [&](const auto& x) {
        using T = std::decay_t<decltype(x)>;
        if constexpr (std::is_same_v<T, std::string>) {
          out << YAML::DoubleQuoted << x;
        } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
          out << YAML::Flow << YAML::BeginSeq;
          for (const auto& s : x) out << YAML::DoubleQuoted << s;
          out << YAML::EndSeq;
        } else if constexpr (std::is_same_v<T, std::vector<double>> ||
                             std::is_same_v<T, std::vector<std::int64_t>>) {
          out << YAML::Flow << YAML::BeginSeq;
          for (const auto n : x) out << fmt::format("{}", n);  // every digit
          out << YAML::EndSeq;
        } else {
          out << fmt::format("{}", x);
        }
      },
      v);
}

ParameterValue relative(const std::string& path, const std::filesystem::path& base) {
  const auto from = std::filesystem::absolute(base).lexically_normal();
  const auto out = std::filesystem::path(path).lexically_relative(from);
  return out.empty() ? path : out.string();
}

// `path_text`: how an input path is written.
std::string write(const Graph& graph, const std::vector<bool>& which,
                  const std::function<ParameterValue(const std::string&)>& path_text) {
  const auto wanted = [&](int i) { return which.empty() || which[i]; };
  const auto reference = [&](const Wire& w) { return graph.nodes[w.node].path + "." + w.port; };
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "terrazzo" << YAML::Value << kGraphFormat;
  out << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << graph.name;
  out << YAML::Key << "nodes" << YAML::Value << YAML::BeginMap;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    if (!wanted(static_cast<int>(i))) continue;
    const GraphNode& node = graph.nodes[i];
    out << YAML::Key << node.path << YAML::Value << YAML::BeginMap;
    out << YAML::Key << "type" << YAML::Value << node.type->name;
    if (which.empty() && !node.may_fail.empty()) out << YAML::Key << "may_fail" << YAML::Value << true;
    std::map<std::string, std::vector<std::string>> inputs;
    for (const auto& [port, wires] : node.inputs)
      for (const auto& w : wires)
        if (wanted(w.node)) inputs[port].push_back(reference(w));
    if (!inputs.empty()) {
      out << YAML::Key << "inputs" << YAML::Value << YAML::Flow << YAML::BeginMap;
      for (const auto& [port, sources] : inputs) {
        out << YAML::Key << port << YAML::Value;
        if (sources.size() == 1) {
          out << sources[0];
        } else {
          out << YAML::Flow << YAML::BeginSeq;
          for (const auto& source : sources) out << source;
          out << YAML::EndSeq;
        }
      }
      out << YAML::EndMap;
    }
    if (!node.parameters.empty()) {
      out << YAML::Key << "params" << YAML::Value << YAML::BeginMap;
      for (const auto& [name, p] : node.parameters) {
        out << YAML::Key << name << YAML::Value;
        const bool path = node.type->find_parameter(name)->kind == ParameterKind::InputPath;
        emit(out, path ? path_text(std::get<std::string>(p.value)) : p.value);
      }
      out << YAML::EndMap;
    }
    out << YAML::EndMap;
  }
  out << YAML::EndMap;
  bool any = false;
  for (const auto& o : graph.outputs) {
    if (!wanted(o.wire.node)) continue;
    if (!any) out << YAML::Key << "outputs" << YAML::Value << YAML::BeginMap;
    any = true;
    out << YAML::Key << o.name << YAML::Value << reference(o.wire);
  }
  if (any) out << YAML::EndMap;
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace

std::string write_graph(const Graph& graph, const std::vector<bool>& which,
                        const std::filesystem::path& base) {
  return write(graph, which,
               [&](const std::string& path) { return base.empty() ? path : relative(path, base); });
}

std::string write_graph_without_folders(const Graph& graph, const std::vector<bool>& which) {
  return write(graph, which,
               [](const std::string& path) { return std::filesystem::path(path).filename().string(); });
}

}  // namespace terrazzo
