// Files that the program itself writes never replace what the graph reads, nor each other.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "runtime/cache/cache_folder.h"
#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::run_program;

class Overwriting : public ::testing::Test {
 protected:
  Overwriting() { fs::create_directories(out); }
  // A graph that reads `input`, a table, and writes `path`.
  fs::path graph(const std::string& input, const std::string& path = "t.csv") {
    std::ofstream(folder / "g.yaml")
        << "terrazzo: 1\nnodes:\n"
           "  table: {type: LoadTable, params: {path: \""
        << input
        << "\"}}\n"
           "  file: {type: Export, inputs: {table: table.table}, params: {path: \""
        << path << "\"}}\n";
    return folder / "g.yaml";
  }
  test::ProgramRun terrazzo(std::vector<std::string> arguments) {
    for (const std::string more : {"--no-cache", "--out"}) arguments.push_back(more);
    arguments.push_back(out.string());
    return run_program(arguments);
  }
  void put(const fs::path& file, const std::string& text = "a,b\n1,2\n") { std::ofstream(file) << text; }
  // Every file with its content.
  std::map<fs::path, std::string> files() const {
    std::map<fs::path, std::string> all;
    for (const auto& e : fs::recursive_directory_iterator(folder))
      if (e.is_regular_file()) all[e.path()] = read_file(e.path()).value_or("");
    return all;
  }
  // Expects that the command is refused and changes nothing.
  void refused(const std::vector<std::string>& arguments, const std::string& words) {
    const auto before = files();
    const auto r = terrazzo(arguments);
    EXPECT_NE(r.exit_code, 0) << arguments.back();
    EXPECT_NE(r.err.find(words), std::string::npos) << r.err;
    EXPECT_EQ(files(), before) << arguments.back();
  }
  const fs::path folder = test::temporary_folder(), out = folder / "out";
};

TEST_F(Overwriting, ByTheReportIsRefusedBeforeTheRun) {
  put(folder / "data.csv");
  const std::string g = graph("data.csv").string();
  fs::create_hard_link(folder / "data.csv", folder / "second.csv");
  fs::create_symlink("g.yaml", folder / "link.json");
  for (const char* name : {"data.csv", "./out/../data.csv", "second.csv", "g.yaml", "link.json"})
    refused({"run", g, "--report", (folder / name).string()}, "would overwrite");
  refused({"run", g, "--report", (out / "t.csv").string()}, "which 'file' writes");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  refused({"run", g, "--report", (folder / "pipe").string()}, "device or a pipe");
  EXPECT_EQ(terrazzo({"run", g, "--report", (folder / "new.json").string()}).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "new.json"));
}

TEST_F(Overwriting, ByTheReportOfTheOutputFolderIsRefused) {
  put(folder / "table.json", "{\"columns\": [\"a\"], \"rows\": [[1]]}");
  fs::create_hard_link(folder / "table.json", out / "report.json");
  refused({"run", graph("table.json").string()}, "would overwrite");
  refused({"run", graph("out/report.json").string()}, "would overwrite");
}

TEST_F(Overwriting, ByFilesOfASweepIsRefused) {
  for (const char* name : {"sweep.csv", "sweep.json", "sweep.png"}) {
    put(out / name);
    refused({"sweep", graph("out/" + std::string(name)).string(), "--vary", "file.path=a.csv,b.csv"},
            "would overwrite");
    fs::remove(out / name);
  }
}

TEST_F(Overwriting, NamesOfTheProgramsFilesAreMistakesInAGraph) {
  put(folder / "data.csv");
  for (const char* name :
       {"report.json", "./x/../report.json", "Report.JSON", "sweep.csv", "sweep.json", "sweep.png"}) {
    const auto r = run_program({"check", graph("data.csv", name).string()});
    EXPECT_EQ(r.exit_code, 2) << name;
    EXPECT_NE(r.err.find("g.yaml:4:"), std::string::npos) << r.err;
    EXPECT_NE(r.err.find("is the name of a file that terrazzo itself writes"), std::string::npos) << r.err;
  }
  EXPECT_EQ(run_program({"check", graph("data.csv", "tables/sweep.csv").string()}).exit_code, 0);
  // A user who names the file by hand means it.
  EXPECT_EQ(
      terrazzo({"show", graph("data.csv").string(), "table.table", "-o", (folder / "sweep.csv").string()})
          .exit_code,
      0);
  EXPECT_TRUE(fs::exists(folder / "sweep.csv"));
}

TEST_F(Overwriting, ByShowIsRefused) {
  put(folder / "data.csv");
  fs::create_hard_link(graph("data.csv"), folder / "second.csv");
  for (const char* name : {"data.csv", "second.csv"})
    refused({"show", (folder / "g.yaml").string(), "table.table", "-o", (folder / name).string()},
            "would overwrite");
}

TEST_F(Overwriting, ByReproduceIsRefused) {
  put(folder / "data.csv");
  ASSERT_EQ(terrazzo({"run", graph("data.csv", "strokes.json").string()}).exit_code, 0);
  fs::rename(folder / "data.csv", folder / "report.yaml");  // the graph that reproduce writes has this name
  const auto r = run_program({"reproduce", (out / "report.json").string(), "--yes", "--no-cache", "--set",
                              "table.path=" + (folder / "report.yaml").string(), "--out", folder.string()});
  EXPECT_EQ(r.exit_code, 2) << r.out;
  EXPECT_NE(r.err.find("would overwrite"), std::string::npos) << r.err;
  EXPECT_EQ(read_file(folder / "report.yaml"), "a,b\n1,2\n");
}

TEST_F(Overwriting, PipesAndFilesBeyondTheMemoryAreNotReadAsInputs) {
  ASSERT_EQ(::mkfifo((folder / "pipe.csv").c_str(), 0600), 0);
  std::ofstream(folder / "sparse.csv").flush();
  fs::resize_file(folder / "sparse.csv", std::uintmax_t{4} << 40);
  refused({"run", graph("pipe.csv").string()}, "it is a pipe");
  refused({"run", graph("sparse.csv").string()}, "of memory");
  refused({"run", graph("/dev/zero").string()}, "it is a device");
  refused({"run", (folder / "pipe.csv").string()}, "it is a pipe");
  // A header that names another file is looked into when the files of the graph are listed.
  for (const char* name : {"pipe.nrrd", "pipe.mhd"}) {
    ASSERT_EQ(::mkfifo((folder / name).c_str(), 0600), 0);
    put(folder / "v.yaml",
        "terrazzo: 1\nnodes:\n  v: {type: LoadVolume, params: {path: " + std::string(name) +
            "}}\n  file: {type: Export, inputs: {volume: v.volume}, params: {path: v.vdb}}\n");
    refused({"run", (folder / "v.yaml").string()}, "it is a pipe");
  }
  for (const char* name : {"pipe.csv", "/dev/zero"})
    EXPECT_EQ(run_program({"check", graph(name).string()}).exit_code, 2) << name;
}

TEST_F(Overwriting, ACacheWithADamagedMarkIsNotUsed) {
  put(folder / "data.csv");
  const fs::path cache = folder / "cache";
  open_cache_folder(cache);
  for (const std::string mark : {"3\n", "1\x8a", "", "text"}) {
    put(cache / "terrazzo-cache", mark);
    const auto r =
        run_program({"run", graph("data.csv").string(), "--cache", cache.string(), "--out", out.string()});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_NE(r.err.find("its mark 'terrazzo-cache'"), std::string::npos) << r.err;
    EXPECT_NE(r.err.find("not kept"), std::string::npos) << r.err;
    EXPECT_EQ(run_program({"cache", "stats", "--cache", cache.string()}).exit_code, 2);
  }
  fs::remove(cache / "terrazzo-cache");  // then it is marked again
  EXPECT_EQ(
      run_program({"run", graph("data.csv").string(), "--cache", cache.string(), "--out", out.string()}).err,
      "");
}

TEST_F(Overwriting, DamagedFilesOfASweepAreSaidInWords) {
  put(folder / "data.csv");
  ASSERT_EQ(terrazzo({"sweep", graph("data.csv").string(), "--vary", "file.path=a.csv,b.csv"}).exit_code, 0);
  put(out / "point-001/report.json", "{\"seconds\": \"x\", \"nodes\": {}}");
  put(out / "point-002/report.json", "[[[");
  fs::create_directories(out / "jobs");
  put(out / "jobs/chunk-0-of-1.jsonl",
      "{\"event\": 5}\n{\"event\": \"started\", \"point\": \"one\"}\n{\"event\": \"stopped\"}\n");
  const auto status = run_program({"status", out.string()});
  EXPECT_EQ(status.exit_code, 0) << status.err;
  EXPECT_NE(status.err.find("2 damaged lines"), std::string::npos) << status.err;
  put(out / "sweep.json", "{\"terrazzo_sweep\": 2}");
  const auto broken = run_program({"status", out.string()});
  EXPECT_EQ(broken.exit_code, 2);
  EXPECT_EQ(broken.err.find("json.exception"), std::string::npos) << broken.err;
}

}  // namespace
}  // namespace terrazzo
