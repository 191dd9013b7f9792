// Checks that nodes open exactly the files whose content is in their action key, so that no edit is missed.
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>
#include <zlib.h>

#include <climits>
#include <fstream>
#include <map>
#include <regex>
#include <set>

#include "graph/graph.h"
#include "nodes/data/shapes.h"
#include "runtime/evaluate.h"
#include "runtime/files.h"
#include "tests/nodes/volumes/load_volume/nifti_file.h"
#include "tests/support/all_nodes.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// Records the files opened below a folder since construction, by any library.
class OpenedFiles {
 public:
  explicit OpenedFiles(const fs::path& folder) : handle_(::inotify_init1(IN_NONBLOCK)) {
    watch(folder);
    for (const auto& e : fs::recursive_directory_iterator(folder))
      if (e.is_directory()) watch(e.path());
  }
  ~OpenedFiles() { ::close(handle_); }
  OpenedFiles(const OpenedFiles&) = delete;
  OpenedFiles& operator=(const OpenedFiles&) = delete;

  // Returns the files opened since the last call.
  std::set<fs::path> take() {
    std::set<fs::path> opened;
    alignas(inotify_event) char buffer[64 * (sizeof(inotify_event) + NAME_MAX + 1)];
    for (ssize_t n = 0; (n = ::read(handle_, buffer, sizeof buffer)) > 0;)
      for (const char* at = buffer; at < buffer + n;) {
        const auto* event = reinterpret_cast<const inotify_event*>(at);
        if (event->mask & IN_Q_OVERFLOW) ADD_FAILURE() << "inotify events were lost";
        if (!(event->mask & IN_ISDIR) && event->len > 0) opened.insert(folders_.at(event->wd) / event->name);
        at += sizeof(inotify_event) + event->len;
      }
    return opened;
  }

 private:
  void watch(const fs::path& folder) {
    const int id = ::inotify_add_watch(handle_, folder.c_str(), IN_OPEN);
    ASSERT_GE(id, 0) << folder;
    folders_[id] = folder;
  }
  int handle_;
  std::map<int, fs::path> folders_;
};

// The input files of a graph's nodes and their companion files, which enter the action keys.
std::set<fs::path> declared(const Graph& g) {
  std::set<fs::path> all;
  for (const auto& node : g.nodes)
    for (const auto& p : node.type->parameters) {
      const auto written = node.parameters.find(p.name);
      if (p.kind != ParameterKind::InputPath || written == node.parameters.end()) continue;
      for (const auto& file : expand_glob(std::get<std::string>(written->second.value))) {
        all.insert(file);
        if (node.type->companion_files)
          for (const auto& other : node.type->companion_files(file)) all.insert(other);
      }
    }
  return all;
}

RunResult evaluate(const Graph& g, Store& store, const fs::path& out, std::vector<int> targets = {}) {
  FileHashes hashes;
  Evaluator e(test::value_types(), store, hashes);
  RunOptions o;
  o.output_folder = out;
  o.targets = std::move(targets);
  RunResult r = e.run(g, o);
  for (const auto& n : r.nodes)
    if (n.error) ADD_FAILURE() << n.error->text();
  return r;
}

Graph graph_of(const fs::path& file) {
  Diagnostics found;
  Graph g = load_graph(file, test::all_nodes(), {}, found);
  for (const auto& d : found) ADD_FAILURE() << d.text();
  return g;
}

bool reads_files(const NodeType& t) {
  for (const auto& p : t.parameters)
    if (p.kind == ParameterKind::InputPath) return true;
  return false;
}

// Adds files next to each file that a reader might open too.
void add_decoys(const fs::path& folder) {
  for (const auto& f : std::vector<fs::directory_entry>(fs::directory_iterator(folder), {}))
    for (const char* other : {".mtl", ".hdr", ".img", ".aux", ".xml", ".ocio"}) {
      const fs::path beside = fs::path(f.path()).replace_extension(other);
      if (!fs::exists(beside)) std::ofstream(beside) << "nothing";
    }
}

TEST(FilesOfNodes, ExactlyTheDeclaredOnesAreOpened) {
  const fs::path base = fs::canonical(test::temporary_folder()), source = TERRAZZO_SOURCE;
  fs::create_directories(base / "graphs");
  fs::copy(source / "graphs/samples", base / "graphs/samples", fs::copy_options::recursive);
  add_decoys(base / "graphs/samples");
  std::set<std::string> tried;
  for (const auto& folder : test::node_folders()) {
    SCOPED_TRACE(folder.filename());
    const fs::path copy = base / folder.lexically_relative(source);
    fs::create_directories(copy.parent_path());
    fs::copy(folder, copy, fs::copy_options::recursive);
    add_decoys(copy);
    const Graph g = graph_of(copy / "example.yaml");
    std::vector<int> readers;
    for (std::size_t i = 0; i < g.nodes.size(); ++i)
      if (reads_files(*g.nodes[i].type)) {
        readers.push_back(static_cast<int>(i));
        tried.insert(g.nodes[i].type->name);
      }
    if (readers.empty()) continue;
    OpenedFiles opened(base);
    Store store(test::value_types(), {});
    evaluate(g, store, base / "out", readers);
    EXPECT_EQ(opened.take(), declared(g));
  }
  std::set<std::string> all;
  for (const auto& t : test::all_nodes().all())
    if (reads_files(*t)) all.insert(t->name);
  EXPECT_EQ(tried, all);
}

// A node that reads files checks its memory budget first.
bool names_a_file(const GraphNode& node) {
  return std::any_of(node.parameters.begin(), node.parameters.end(), [&](const auto& p) {
    return node.type->find_parameter(p.first)->kind == ParameterKind::InputPath;
  });
}

TEST(FilesOfNodes, NoneIsReadBeyondTheBudget) {
  int tried = 0;
  for (const auto& folder : test::node_folders()) {
    const Graph g = graph_of(folder / "example.yaml");
    for (std::size_t i = 0; i < g.nodes.size(); ++i) {
      if (!names_a_file(g.nodes[i])) continue;
      Store store(test::value_types(), {});
      FileHashes hashes;
      Evaluator evaluator(test::value_types(), store, hashes);
      RunOptions o;
      o.output_folder = test::temporary_folder();
      o.targets = {static_cast<int>(i)};
      o.memory = 20;
      const auto result = evaluator.run(g, o).nodes[i];
      ASSERT_TRUE(result.error) << g.nodes[i].type->name;
      EXPECT_EQ(result.error->code, "too-large") << g.nodes[i].type->name;
      ++tried;
    }
  }
  EXPECT_GE(tried, 7);
}

// The shape's name is part of LoadMesh's output.
TEST(FilesOfNodes, ARenamedMeshIsCalledByItsNewName) {
  const fs::path folder = test::temporary_folder();
  Store store(test::value_types(), {});
  const auto name_of = [&](const std::string& file) {
    fs::copy_file(fs::path(TERRAZZO_SOURCE) / "nodes/shapes/load_mesh/example.off", folder / file);
    std::ofstream(folder / "g.yaml") << "terrazzo: 1\nnodes: {m: {type: LoadMesh, params: {path: '" << file
                                     << "'}}}\n";
    const Graph g = graph_of(folder / "g.yaml");
    FileHashes hashes;
    return Evaluator(test::value_types(), store, hashes)
        .value(g, evaluate(g, store, folder / "out"), {0, "shapes", {}})
        .as<Shapes>()
        .shapes.at(0)
        .name;
  };
  EXPECT_EQ(name_of("first.off"), "first");
  EXPECT_EQ(name_of("second.off"), "second");
}

class NiftiPair : public ::testing::Test {
 protected:
  fs::path graph(const std::string& file) {
    std::ofstream(folder / "g.yaml")
        << "terrazzo: 1\nnodes:\n  v:\n    type: LoadVolume\n    params: {path: '" << file
        << "', slope: 1, intercept: 0}\n";
    return folder / "g.yaml";
  }
  static void pack(const fs::path& file) {
    const auto content = read_file(file);
    gzFile f = gzopen((file.string() + ".gz").c_str(), "wb");
    gzwrite(f, content->data(), static_cast<unsigned>(content->size()));
    gzclose(f);
    fs::remove(file);
  }
  fs::path folder = fs::canonical(test::temporary_folder());
};

TEST_F(NiftiPair, BothHalvesAreInTheKey) {
  const struct {
    const char *header, *voxels;
    bool packed;
  } kinds[] = {{"a.hdr", "a.img", false}, {"b.hdr", "b.img", true}, {"C.HDR", "C.IMG", false}};
  for (const auto& kind : kinds)
    for (const bool name_header : {true, false}) {
      SCOPED_TRACE(std::string(kind.header) + (kind.packed ? ".gz" : "") +
                   (name_header ? "" : ", by its voxels"));
      for (const auto& e : std::vector<fs::directory_entry>(fs::directory_iterator(folder), {}))
        fs::remove_all(e);
      test::NiftiFile n = test::NiftiFile::counting();
      const auto write = [&] {
        n.write_pair(folder / kind.header, folder / kind.voxels);
        if (kind.packed) {
          pack(folder / kind.header);
          pack(folder / kind.voxels);
        }
      };
      write();
      const Graph g =
          graph_of(graph(std::string(name_header ? kind.header : kind.voxels) + (kind.packed ? ".gz" : "")));
      Store store(test::value_types(), {});
      OpenedFiles opened(folder);
      const RunResult first = evaluate(g, store, folder / "out");
      EXPECT_EQ(opened.take(), declared(g));
      EXPECT_EQ(declared(g).size(), 2u);
      EXPECT_EQ(evaluate(g, store, folder / "out").nodes[0].status, Status::Memory);
      n.data[0] = 99;  // changes only the voxels
      write();
      const RunResult second = evaluate(g, store, folder / "out");
      EXPECT_EQ(second.nodes[0].status, Status::Computed);
      EXPECT_NE(second.nodes[0].outputs, first.nodes[0].outputs);
      n.pixdim[1] = 7;  // changes only the header
      write();
      EXPECT_NE(evaluate(g, store, folder / "out").nodes[0].outputs, second.nodes[0].outputs);
    }
}

// ./dev new-node writes the template's example into a folder of a district.
TEST(FilesOfNodes, TheTemplateFindsItsPicture) {
  const fs::path source = TERRAZZO_SOURCE;
  const std::string example = read_file(source / "nodes/template/example.yaml.in").value_or("");
  const std::regex path("path: ([^},]+)");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(example, match, path));
  EXPECT_TRUE(fs::exists(source / "nodes/photograph/grain" / match[1].str())) << match[1];
}

}  // namespace
}  // namespace terrazzo
