#include "runtime/clients/studio/new_material.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <map>
#include <set>

#include "graph/describe.h"
#include "graph/document/edit_document.h"
#include "graph/document/patch_yaml.h"
#include "graph/document/yaml_text.h"
#include "graph/node_type.h"
#include "nodes/common/io/image_file.h"
#include "runtime/clients/cli/default_graph.h"
#include "runtime/clients/studio/live/save_file.h"
#include "runtime/files.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

struct Source {
  std::string text;
  RawDocument doc;
};

Source read_source(const fs::path& file) {
  Diagnostics found;
  const auto text = read_graph_text(file, found);
  if (!text)
    throw Error("no-library", "the graph '" + file.string() + "' is not installed with this program");
  Source out{*text, read_document(*text, file, found)};
  if (has_errors(found)) throw Error(found.front());
  return out;
}

std::string node_of(const std::string& wire) { return wire.substr(0, wire.rfind('.')); }

// Adds the nodes of `outer` to the text of the graph that it uses as the node `asset`.
class Inliner {
 public:
  Inliner(const Source& inner, const Source& outer, std::string asset)
      : inner_(inner), outer_(outer), asset_(std::move(asset)), text_(inner.text) {
    for (const auto& n : inner.doc.nodes) used_.insert(n.name);
    for (const auto& n : outer.doc.nodes)
      if (n.name != asset_) names_[n.name] = used_.count(n.name) ? n.name + "_file" : n.name;
  }

  std::string run() {
    for (const auto& n : outer_.doc.nodes) {
      if (n.name == asset_) continue;
      const std::string& name = names_[n.name];
      apply({.kind = Edit::Kind::AddNode, .node = name, .type = n.type, .graph = n.graph});
      for (const auto& [input, wires] : n.inputs) {
        std::vector<std::string> now;
        for (const auto& w : wires) now.push_back(wire(w.text));
        apply({.kind = Edit::Kind::Connect, .node = name, .name = input, .wires = now});
      }
      for (const auto& [param, value] : n.params)
        apply({Edit::Kind::SetParameter, name, param, value.written});
    }
    // The inner graph also has nodes for other uses.
    for (const auto& n : inner_.doc.nodes)
      if (!needed_.count(n.name)) apply({.kind = Edit::Kind::RemoveNode, .node = n.name});
    return std::move(text_);
  }

 private:
  void apply(const Edit& e) { text_ = edit_document(text_, inner_.doc.file, e); }

  std::string wire(const std::string& text) {
    const std::string node = node_of(text), port = text.substr(std::min(node.size() + 1, text.size()));
    if (node != asset_) return names_[node] + "." + port;
    const auto& outputs = inner_.doc.outputs;
    const auto it = std::ranges::find(outputs, port, [](const auto& o) { return o.first; });
    if (it == outputs.end()) throw Error("no-library", "the library has no output '" + port + "'");
    need(node_of(it->second.text));
    return it->second.text;
  }

  void need(const std::string& name) {
    if (!needed_.insert(name).second) return;
    for (const auto& n : inner_.doc.nodes)
      if (n.name == name)
        for (const auto& [input, wires] : n.inputs)
          for (const auto& w : wires) need(node_of(w.text));
  }

  const Source &inner_, &outer_;
  std::string asset_, text_;
  std::set<std::string> used_, needed_;
  std::map<std::string, std::string> names_;
};

Image read_picture(const fs::path& file, const std::string& name) try {
  return read_image(file);
} catch (Error& e) {
  Diagnostic d = e.diagnostic();
  if (const auto at = d.message.find(file.string()); at != std::string::npos)
    d.message.replace(at, file.string().size(), name);
  throw Error(d);
}

Image picture_of(const std::string& bytes, const std::string& name) {
  if (!is_picture_name(name))
    throw Error("unknown-format", "'" + name + "' is not a picture that can be read",
                "use JPEG, PNG, TIFF, OpenEXR, Radiance HDR, BMP or PNM");
  const TemporaryFile file(fs::temp_directory_path(), "terrazzo_picture",
                           fs::path(name).extension().string());
  if (!(std::ofstream(file.path(), std::ios::binary) << bytes << std::flush))
    throw Error("write-failed",
                "cannot write a temporary file in '" + fs::temp_directory_path().string() + "'");
  return read_picture(file.path(), name);
}

NewFile write_graph(const fs::path& photo, const fs::path& folder, Content content,
                    const Settings& settings) {
  const std::string relative = photo.lexically_proximate(fs::absolute(folder)).string();
  return write_once(folder / (photo.stem().string() + ".yaml"),
                    graph_of_photograph(relative, photo.stem().string(), content, settings));
}

// The files of a material are named after it: aggregate.glb becomes TITLE.glb, and preview.png
// TITLE_preview.png.
std::string name_files(std::string text, const fs::path& file, const std::string& title) {
  Diagnostics found;
  for (const auto& n : read_document(text, file, found).nodes)
    for (const auto& [name, value] : n.params) {
      if (n.type != "Export" || name != "path") continue;
      const fs::path path = value.written.text();
      const std::string stem = path.stem() == "aggregate" ? title : title + "_" + path.stem().string();
      const WrittenValue now = read_written(yaml_word(stem + path.extension().string()));
      text = edit_document(text, file, {Edit::Kind::SetParameter, n.name, name, now});
    }
  return text;
}

// The graph of the particles in a photograph, without the subgraph that it uses.
Source particles_graph(const fs::path& folder) {
  const Source outer = read_source(folder / "aggregate.yaml");
  const auto asset = std::ranges::find_if(outer.doc.nodes, [](const RawNode& n) { return !n.graph.empty(); });
  if (asset == outer.doc.nodes.end()) throw Error("no-library", "aggregate.yaml uses no other graph");
  Source inner = read_source((folder / asset->graph).lexically_normal());
  inner.text = Inliner(inner, outer, asset->name).run();
  return inner;
}

// The new reference to a file, or nothing if the value is no relative path.
std::optional<std::string> moved(const WrittenValue& v, const std::vector<std::string>& keywords,
                                 const fs::path& from, const fs::path& to, const Workspace& workspace) {
  const std::string text = v.text();
  if (v.is_list || text.empty() || text.find("${") != std::string::npos || fs::path(text).is_absolute() ||
      std::ranges::find(keywords, text) != keywords.end())
    return {};
  const fs::path target = (from.parent_path() / text).lexically_normal();
  return (workspace.contains(target) ? target.lexically_relative(to.parent_path()) : target).string();
}

}  // namespace

bool is_picture_name(const fs::path& path) {
  static constexpr std::array<const char*, 10> kKnown{".jpg", ".jpeg", ".png", ".tif", ".tiff",
                                                      ".exr", ".hdr",  ".bmp", ".ppm", ".pgm"};
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::find(kKnown, extension) != kKnown.end();
}

std::string graph_of_photograph(const std::string& photo, const std::string& title, Content content,
                                const Settings& settings) {
  const fs::path folder = cli::default_graph().parent_path();
  const Source source = content == Content::Particles
                            ? particles_graph(folder)
                            : read_source((folder / "../library/media.yaml").lexically_normal());
  std::string text = source.text;
  Settings all = settings;
  all.emplace_back("photo", photo);
  for (const auto& [name, value] : all)
    text = edit_document(text, source.doc.file,
                         {Edit::Kind::SetDefault, "", name, read_written(yaml_word(value))});
  text = name_files(std::move(text), source.doc.file, title);
  return set_yaml_entry(text, {"name"}, yaml_word(title)).value_or(text);
}

NewFile write_once(const fs::path& name, const std::string& content) {
  fs::path next = name;
  std::error_code error;
  for (int number = 2; fs::exists(next, error); ++number) {
    if (read_file(next) == content) return {next, false};
    next = name.parent_path() /
           (name.stem().string() + "_" + std::to_string(number) + name.extension().string());
  }
  SaveFile file = SaveFile::numbered(name);
  file.write([&](const fs::path&) { return content; });
  return {file.path(), true};
}

media::Recommendation recommend(const std::string& bytes, const std::string& name) {
  return media::recommend(picture_of(bytes, name), {});
}

NewFile create_graph(const fs::path& photo, const fs::path& folder, const Settings& settings) {
  read_picture(photo, photo.string());
  const fs::path full = fs::absolute(photo).lexically_normal();
  if (full.string().find_first_of("*?[]$") != std::string::npos)
    throw Error("bad-name", "the path '" + full.string() + "' contains one of * ? [ ] $",
                "rename the picture");
  return write_graph(full, folder, Content::Particles, settings);
}

NewFile create_graph(const std::string& bytes, const std::string& name, const fs::path& folder,
                     Content content, const Settings& settings) {
  picture_of(bytes, name);  // throws if it is none
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error("write-failed", "cannot create the folder '" + folder.string() + "': " + error.message());
  return write_graph(fs::absolute(write_once(folder / name, bytes).path), folder, content, settings);
}

std::string relocated(const std::string& text, const fs::path& from, const fs::path& to,
                      const Workspace& workspace, const Registry& registry) {
  if (from.parent_path() == to.parent_path()) return text;
  Diagnostics found;
  const RawDocument doc = read_document(text, from, found);
  std::string out = text;
  const auto apply = [&](const Edit& e) { out = edit_document(out, from, e); };
  for (const auto& p : doc.parameters)
    if (const auto& d = p.declaration; d.kind == ParameterKind::InputPath)
      if (const auto now = moved(p.value.written, d.keywords, from, to, workspace))
        apply({Edit::Kind::SetDefault, "", d.name, {false, {*now}, {}}});
  for (const auto& n : doc.nodes) {
    NodeType subgraph("", 0);
    const NodeType* type = n.graph.empty() ? registry.find(n.type) : &subgraph;
    if (!n.graph.empty()) {
      subgraph =
          describe_graph(load_graph((from.parent_path() / n.graph).lexically_normal(), registry, {}, found));
      if (const auto now = moved({false, {n.graph}, {}}, {}, from, to, workspace))
        apply({.kind = Edit::Kind::SetSubgraph, .node = n.name, .graph = *now});
    }
    for (const auto& [name, value] : n.params)
      if (const Parameter* p = type ? type->find_parameter(name) : nullptr;
          p && p->kind == ParameterKind::InputPath)
        if (const auto now = moved(value.written, p->keywords, from, to, workspace))
          apply({Edit::Kind::SetParameter, n.name, name, {false, {*now}, {}}});
  }
  return out;
}

}  // namespace terrazzo::studio
