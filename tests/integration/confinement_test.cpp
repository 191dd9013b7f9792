// A graph writes only below the output folder and never overwrites its inputs.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::run_program;

class Confinement : public ::testing::Test {
 protected:
  fs::path graph(const std::string& path, const std::string& more = {}) {
    std::ofstream(folder / "graph.yaml")
        << "terrazzo: 1\nparameters: {name: {type: text, default: x}}\nnodes:\n"
           "  shape: {type: Shape}\n"
           "  file: {type: Export, inputs: {shapes: shape.shapes}, params: {path: \""
        << path << "\"}}\n"
        << more;
    return folder / "graph.yaml";
  }
  test::ProgramRun run(const fs::path& graph, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"run", graph.string(), "--no-cache", "--out",
                                          (folder / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  // Every file outside `out`, with its content.
  std::map<std::string, std::string> outside() const {
    std::map<std::string, std::string> found;
    for (const auto& e : fs::recursive_directory_iterator(folder))
      if (e.is_regular_file() && !e.path().string().starts_with((folder / "out/").string()))
        found[e.path().string()] = read_file(e.path()).value_or("");
    return found;
  }
  fs::path folder = test::temporary_folder();
};

TEST_F(Confinement, APathThatLeavesTheFolderIsAMistakeWithItsPlace) {
  for (const std::string path : {"../x.obj", "../../x.obj", "a/../../x.obj", "/tmp/terrazzo-escape.obj",
                                 "./../x.obj", "a/b/../../../out2/x.obj"}) {
    const fs::path g = graph(path);
    const auto before = outside();
    const auto checked = run_program({"check", g.string()});
    EXPECT_EQ(checked.exit_code, 2) << path;
    EXPECT_NE(checked.err.find("graph.yaml:5:"), std::string::npos) << checked.err;
    EXPECT_NE(checked.err.find("outside the output folder"), std::string::npos) << checked.err;
    EXPECT_EQ(run(g).exit_code, 2) << path;
    EXPECT_EQ(outside(), before) << path;
    EXPECT_FALSE(fs::exists("/tmp/terrazzo-escape.obj"));
  }
  // The same with the path in a parameter of the graph, and from the command line.
  EXPECT_EQ(run(graph("${name}.obj"), {"--param", "name=../x"}).exit_code, 2);
  EXPECT_EQ(run(graph("x.obj"), {"--set", "file.path=../x.obj"}).exit_code, 2);
}

TEST_F(Confinement, PathsBelowTheFolderAreFree) {
  for (const std::string path : {"x.obj", "deep/er/x.obj", "a/../x.obj", "..x.obj", "a..b/x.obj"}) {
    EXPECT_EQ(run(graph(path)).exit_code, 0) << path;
    EXPECT_TRUE(fs::exists(folder / "out" / path)) << path;
    fs::remove_all(folder / "out");
  }
}

TEST_F(Confinement, ALinkDoesNotLeadOut) {
  const fs::path elsewhere = folder / "elsewhere";
  fs::create_directories(elsewhere);
  fs::create_directories(folder / "out" / "in");
  std::ofstream(elsewhere / "x.obj") << "mine";
  fs::create_directory_symlink(elsewhere, folder / "out" / "link");
  fs::create_directory_symlink(elsewhere, folder / "out" / "in" / "link");
  for (const std::string path : {"link/x.obj", "link/new/x.obj", "in/link/x.obj"}) {
    const auto r = run(graph(path));
    EXPECT_EQ(r.exit_code, 1) << path;
    EXPECT_NE(r.err.find("error: file.path: '" + path + "' leads out of the output folder"),
              std::string::npos)
        << r.err;
  }
  EXPECT_EQ(read_file(elsewhere / "x.obj"), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(elsewhere), {}), 1);
  // A link with the file's name is replaced; its target stays unchanged.
  fs::create_symlink(elsewhere / "x.obj", folder / "out" / "y.obj");
  EXPECT_EQ(run(graph("y.obj")).exit_code, 0);
  EXPECT_EQ(read_file(elsewhere / "x.obj"), "mine");
  EXPECT_FALSE(fs::is_symlink(folder / "out" / "y.obj"));
}

TEST_F(Confinement, TheOutputFolderItselfMayBeALink) {
  fs::create_directories(folder / "disk");
  fs::create_directory_symlink(folder / "disk", folder / "out");
  EXPECT_EQ(run(graph("sub/x.obj")).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "disk" / "sub" / "x.obj"));
}

TEST_F(Confinement, WhatTheGraphReadsIsNotOverwritten) {
  fs::create_directories(folder / "out");
  fs::copy_file(test::source_folder() / "graphs/samples/section.png", folder / "out" / "photo.png");
  const std::string before = read_file(folder / "out" / "photo.png").value();
  std::ofstream(folder / "g.yaml")
      << "terrazzo: 1\nnodes:\n"
         "  photo: {type: LoadImage, params: {path: out/photo.png}}\n"
         "  copy: {type: Export, inputs: {image: photo.image}, params: {path: photo.png}}\n";
  const auto r = run(folder / "g.yaml");
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_NE(r.err.find("error: copy.path: 'photo.png' would overwrite"), std::string::npos) << r.err;
  EXPECT_EQ(read_file(folder / "out" / "photo.png"), before);
}

TEST_F(Confinement, SweepsAndStudiesAreHeldToTheSame) {
  const auto before = outside();
  const auto swept = run_program({"sweep", graph("${name}.obj").string(), "--vary", "name=a,../../b",
                                  "--no-cache", "--out", (folder / "out").string()});
  EXPECT_EQ(swept.exit_code, 2);
  EXPECT_NE(swept.err.find("outside the output folder"), std::string::npos) << swept.err;
  std::ofstream(folder / "study.yaml")
      << "terrazzo: 1\nnodes:\n  shape: {type: Shape}\n"
         "  study: {type: ShapeStudy, inputs: {shapes: shape.shapes}, params: "
         "{path: ../study.html}}\n";
  const auto study = run_program({"check", (folder / "study.yaml").string()});
  EXPECT_EQ(study.exit_code, 2);
  EXPECT_NE(study.err.find("outside the output folder"), std::string::npos) << study.err;
}

}  // namespace
}  // namespace terrazzo
