#include "runtime/clients/studio/views/materials.h"

#include <algorithm>
#include <tuple>

#include "graph/document/raw_document.h"
#include "graph/text/nearest.h"
#include "runtime/clients/cli/default_graph.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

std::string leading_comment(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size() && text[at] == '#';) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::size_t from = std::min(text.find_first_not_of("# ", at), end);
    out += (out.empty() ? "" : " ") + text.substr(from, end - from);
    at = end + 1;
  }
  return out;
}

}  // namespace

std::vector<Material> materials() {
  std::vector<Material> out;
  const fs::path first = cli::default_graph();
  if (first.empty()) return out;
  const fs::path pictures = first.parent_path() / "../../docs/images/gallery";
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(first.parent_path(), error)) {
    if (entry.path().extension() != ".yaml") continue;
    Diagnostics found;
    const auto text = read_graph_text(entry.path(), found);
    if (!text) continue;
    const RawDocument doc = read_document(*text, entry.path(), found);
    Material m{entry.path().stem().string(), doc.name, leading_comment(*text), entry.path(), {}};
    if (m.title.empty()) m.title = m.name;
    if (const fs::path picture = pictures / (m.name + ".jpg"); fs::is_regular_file(picture, error))
      m.picture = picture;
    out.push_back(std::move(m));
  }
  std::ranges::sort(out, {}, [&](const Material& m) { return std::tuple(m.file != first, m.title, m.name); });
  return out;
}

Material material(const std::string& name) {
  std::vector<std::string> names;
  for (auto& m : materials()) {
    if (m.name == name) return m;
    names.push_back(m.name);
  }
  throw Error("unknown-material", "there is no material '" + name + "'" + did_you_mean(name, names));
}

}  // namespace terrazzo::studio
