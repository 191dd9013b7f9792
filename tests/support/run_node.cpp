#include "tests/support/run_node.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <stdexcept>

#include "graph/document/raw_document.h"
#include "runtime/codec.h"
#include "runtime/compute_node.h"
#include "runtime/files.h"
#include "tests/support/all_nodes.h"

namespace terrazzo::test {
namespace fs = std::filesystem;

NodeRun run_node(const std::string& type_name, const std::multimap<std::string, Value>& inputs,
                 const std::map<std::string, std::string>& parameters, const fs::path& output_folder,
                 int threads) {
  ComputeRequest request;
  request.type = all_nodes().find(type_name);
  if (!request.type) throw Error("unknown-type", "there is no node type " + type_name);
  for (const auto& [port, value] : inputs) {
    const Port* p = request.type->find_input(port);
    if (!p || !p->accepts(value.type().name))
      throw Error("unknown-port", type_name + " has no input '" + port + "' of type " + value.type().name);
    request.inputs[port].push_back(value);
  }
  for (const auto& p : request.type->inputs)
    if (!p.optional && !request.inputs.count(p.name))
      throw Error("missing-input", type_name + " needs " + p.name);
  std::map<std::string, ParameterValue> written;
  for (const auto& [name, text] : parameters) {
    const Parameter* p = request.type->find_parameter(name);
    if (!p) throw Error("unknown-parameter", type_name + " has no parameter " + name);
    std::string why;
    const auto value = read_parameter(*p, read_written(text), why);
    if (!value) throw Error("bad-value", why).parameter(name);
    if (p->kind == ParameterKind::InputPath) {
      request.files[name] = expand_glob(fs::absolute(std::get<std::string>(*value)));
      if (request.files[name].empty())
        throw Error("no-file", "no file " + std::get<std::string>(*value)).parameter(name);
    }
    written[name] = *value;
  }
  request.parameters = effective_parameters(*request.type, written);
  request.output_folder = output_folder;
  request.provenance = "{}";
  ComputeResult result;
  const tbb::global_control limit(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(threads > 0 ? threads : tbb::this_task_arena::max_concurrency()));
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] { result = compute_node(std::move(request)); });
  for (const auto& [port, value] : result.outputs) {  // as every run does, to hash it
    BufferWriter bytes;
    value.type().encode(value.data(), bytes);
  }
  return {std::move(result.outputs), std::move(result.metrics), std::move(result.warnings)};
}

fs::path shared_data() {
  const fs::path data = fs::path(TERRAZZO_SOURCE).parent_path() / "shared" / "data";
  std::error_code error;
  return fs::is_directory(data, error) ? data : fs::path();
}

std::vector<fs::path> node_folders() {
  std::vector<fs::path> out;
  for (const auto& e : fs::recursive_directory_iterator(fs::path(TERRAZZO_SOURCE) / "nodes"))
    if (e.path().filename() == "example.yaml") out.push_back(e.path().parent_path());
  std::sort(out.begin(), out.end());
  return out;
}

fs::path node_folder(const std::string& type) {
  const auto plain = [](std::string name) {
    std::erase(name, '_');
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    return name;
  };
  for (const auto& folder : node_folders())
    if (plain(folder.filename().string()) == plain(type)) return folder;
  throw std::out_of_range("no folder below nodes/ is named after the type " + type);
}

fs::path temporary_folder() {
  struct Folder {
    fs::path path;
    Folder() {
      std::string name = (fs::temp_directory_path() / "terrazzo-test-XXXXXX").string();
      if (!::mkdtemp(name.data())) throw Error("no-folder", "cannot make a temporary folder");
      path = name;
    }
    ~Folder() {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
  };
  static const Folder root;
  static std::atomic<int> serial = 0;  // tests may call this from several threads
  const fs::path folder = root.path / std::to_string(++serial);
  fs::create_directories(folder);
  return folder;
}

}  // namespace terrazzo::test
