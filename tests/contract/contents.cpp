#include "tests/contract/contents.h"

#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <link.h>

#include <cctype>
#include <set>
#include <stdexcept>

#include "nodes/common/io/pictures/picture_codec.h"
#include "runtime/evaluate.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo::test {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// Versions of the loaded shared libraries that compute or decode, from their file names.
std::string libraries() {
  picture_codec();  // loads those for pictures
  static const std::vector<std::string> that_matter = {
      "libopenvdb", "libOpenImageIO.", "libOpenColorIO", "libopencv_core", "libopencv_imgproc", "libembree",
      "libvoro",    "libnifti",        "libdcmdata",     "libdcmjpeg",     "libjpeg.",          "libpng",
      "libtiff.",   "libOpenEXR-",     "libImath-",      "libwebp."};
  std::set<std::string> found;
  ::dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* out) {
        std::error_code error;
        const std::string name = fs::canonical(info->dlpi_name, error).filename().string();
        for (const auto& prefix : that_matter)
          if (name.rfind(prefix, 0) == 0) static_cast<std::set<std::string>*>(out)->insert(name);
        return 0;
      },
      &found);
  return fmt::format("{}", fmt::join(found, " "));
}

// Other formats contain provenance, which is not part of the result.
const std::set<std::string> without_metadata = {".csv", ".json", ".obj", ".ply", ".stl"};

// CPU features by which compilers, libm and libraries select code.
std::string cpu() {
#if defined(__x86_64__)
  std::vector<std::string> has = {"x86_64"};
#define TERRAZZO_CPU(feature) \
  if (__builtin_cpu_supports(feature)) has.push_back(feature)
  TERRAZZO_CPU("sse4.2");
  TERRAZZO_CPU("avx");
  TERRAZZO_CPU("fma");
  TERRAZZO_CPU("avx2");
  TERRAZZO_CPU("avx512f");
  TERRAZZO_CPU("avx512bw");
  TERRAZZO_CPU("avx512dq");
  TERRAZZO_CPU("avx512vl");
  TERRAZZO_CPU("avx512vnni");
#undef TERRAZZO_CPU
  return fmt::format("{}", fmt::join(has, " "));
#elif defined(__aarch64__)
  return "aarch64";
#else
  return "unknown";
#endif
}

}  // namespace

json this_machine() {
#ifdef __clang__
  const std::string compiler = "Clang " __clang_version__;
#else
  const std::string compiler = "GCC " __VERSION__;
#endif
  return {{"compiler", compiler},
          {"libc", std::string("glibc ") + ::gnu_get_libc_version()},
          {"cpu", cpu()},
          {"libraries", libraries()}};
}

fs::path example_file(const NodeType& type) { return node_folder(type.name) / "example.yaml"; }

json example_contents(const Registry& registry, const NodeType& type, int threads, const fs::path& cache) {
  Diagnostics found;
  const Graph graph = load_graph(example_file(type), registry, {}, found);
  for (const auto& d : found) throw std::runtime_error(d.text());
  Store store(value_types(), cache);
  FileHashes hashes;
  Evaluator evaluator(value_types(), store, hashes);
  RunOptions options;
  options.threads = threads;
  options.output_folder = temporary_folder() / "out";
  const RunResult result = evaluator.run(graph, options);
  json out = json::object();
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const NodeResult& r = result.nodes[i];
    if (r.error) throw std::runtime_error(r.error->text());
    if (graph.nodes[i].type != &type) continue;
    json node = {{"version", type.version}, {"key", r.key.text()}};
    for (const auto& [port, record] : r.outputs) node["outputs"][port] = record.content.text();
    for (const auto& file : r.files)
      if (without_metadata.count(fs::path(file.path).extension().string()))
        node["files"][file.path] = file.content.text();
    out[graph.nodes[i].path] = std::move(node);
  }
  return out;
}

std::string compare_contents(const std::string& type, const json& recorded, const json& now,
                             bool* same_version) {
  const std::string renew = "run ./dev contents and commit tests/contract/contents.json";
  for (const auto& [path, node] : now.items()) {
    const auto it = recorded.find(path);
    if (it == recorded.end())
      return fmt::format("{}: the contents of '{}' are not recorded; {}", type, path, renew);
    if (it->at("version") != node.at("version"))
      return fmt::format("{} has version {}, but the recorded contents are of version {}; {}", type,
                         node.at("version").get<int>(), it->at("version").get<int>(), renew);
    if (it->at("key") != node.at("key"))
      return fmt::format("{}: the parameters or inputs of '{}' in its example changed; {}", type, path,
                         renew);
    for (const char* kind : {"outputs", "files"}) {
      const json before = it->value(kind, json::object()), after = node.value(kind, json::object());
      std::vector<std::string> changed;
      for (const auto& [name, content] : after.items())
        if (!before.contains(name) || before.at(name) != content) changed.push_back(name);
      for (const auto& [name, content] : before.items())
        if (!after.contains(name)) changed.push_back(name);
      if (changed.empty()) continue;
      if (same_version) *same_version = true;
      return fmt::format(
          "{} produces a different result from equal inputs under the same version {}: {} of '{}' changed. "
          "Raise the version in its NodeType(…), then {}. If only a library on this machine changed, first "
          "remove this machine's entry from that file",
          type, node.at("version").get<int>(), fmt::join(changed, ", "), path, renew);
    }
  }
  for (const auto& [path, node] : recorded.items())
    if (!now.contains(path))
      return fmt::format("{}: '{}' is no longer in its example; {}", type, path, renew);
  return {};
}

fs::path contents_file() { return fs::path(TERRAZZO_SOURCE) / "tests" / "contract" / "contents.json"; }

json read_contents() {
  const auto text = read_file(contents_file());
  return text ? json::parse(*text) : json::array();
}

const json* contents_on(const json& all, const json& machine) {
  for (const auto& entry : all)
    if (entry.at("machine") == machine) return &entry.at("types");
  return nullptr;
}

}  // namespace terrazzo::test
