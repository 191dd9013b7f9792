// Mistakes of users and failures of machines: the message names node, parameter and position, no file is
// partly written, and cached work survives.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "nodes/common/io/image_file.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::run_program;

class BadInput : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return folder / name;
  }
  test::ProgramRun run(const fs::path& graph, std::vector<std::string> more = {},
                       test::ProgramOptions o = {}) {
    std::vector<std::string> arguments = {"run", graph.string(), "--out", (folder / "out").string()};
    if (std::find(more.begin(), more.end(), "--no-cache") == more.end())
      arguments.insert(arguments.end(), {"--cache", (folder / "cache").string()});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments, o);
  }
  // No file is left in the output folder, including hidden temporary files.
  std::vector<std::string> left_behind() const {
    std::vector<std::string> out;
    if (fs::exists(folder / "out"))
      for (const auto& e : fs::recursive_directory_iterator(folder / "out"))
        if (e.is_regular_file() && e.path().filename() != "report.json") out.push_back(e.path().string());
    return out;
  }
  fs::path segment_graph(const std::string& picture) {
    return write("segment.yaml", "terrazzo: 1\nnodes:\n  photo:\n    type: LoadImage\n    params: {path: '" +
                                     picture +
                                     "'}\n  segment: {type: Segment, inputs: {image: photo.image}}\n");
  }
  fs::path folder = test::temporary_folder();
};

#define EXPECT_SAYS(run, code, text)                                                \
  do {                                                                              \
    EXPECT_EQ((run).exit_code, code) << (run).err;                                  \
    EXPECT_NE((run).err.find(text), std::string::npos) << "message: " << (run).err; \
  } while (false)

TEST_F(BadInput, AMissingPicture) {
  const auto r = run(segment_graph("nowhere.png"));
  EXPECT_SAYS(r, 1, "segment.yaml:5:20: error: photo.path: there is no file");
}

TEST_F(BadInput, ACorruptPicture) {
  write("broken.png", "\x89PNG\r\n\x1a\n and then nothing of the kind");
  EXPECT_SAYS(run(segment_graph("broken.png")), 1, "segment.yaml:5:20: error: photo.path:");
}

TEST_F(BadInput, APictureOfOneColor) {
  write_image(folder / "gray.png", Image(64, 64, 1, 1, Vec3f::Constant(0.3f)));  // dithered by one 8-bit step
  EXPECT_SAYS(run(segment_graph("gray.png")), 1, "error: segment");
}

TEST_F(BadInput, AMeshWithHoles) {
  write("open.off", "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n");
  const auto graph =
      write("mesh.yaml", "terrazzo: 1\nnodes:\n  mesh: {type: LoadMesh, params: {path: open.off}}\n");
  EXPECT_SAYS(run(graph), 1, "mesh.yaml:3:41: error: mesh.path:");
}

TEST_F(BadInput, ADistributionThatCannotBePacked) {
  const auto graph = write("dense.yaml",
                           "terrazzo: 1\nnodes:\n"
                           "  ball: {type: Shape}\n"
                           "  sizes: {type: Distribution, params: {kind: uniform, min: 0.9, max: 1, "
                           "volume_fraction: 0.9}, inputs: {shapes: ball.shapes}}\n"
                           "  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: "
                           "ball.shapes}, params: {size: 5}}\n");
  EXPECT_SAYS(run(graph), 1, "error: pack");
}

TEST_F(BadInput, NumbersThatAreNone) {
  const auto graph = write("nan.yaml", "terrazzo: 1\nnodes:\n  ball: {type: Shape, params: {size: .nan}}\n");
  EXPECT_SAYS(run(graph), 2, "nan.yaml:3:38: error: ball.size:");
}

const char* export_graph =
    "terrazzo: 1\nnodes:\n  rock: {type: Shape, params: {kind: rock}}\n  file: {type: Export, inputs: "
    "{shapes: rock.shapes}, params: {path: rock.glb}}\n";

TEST_F(BadInput, AnOutputFolderThatCannotBeWritten) {
  write("out", "a file stands where the folder should be");
  EXPECT_SAYS(run(write("g.yaml", export_graph)), 1, "error: file: cannot write");
}

TEST_F(BadInput, AFullDisk) {
  const auto graph = write("g.yaml", export_graph);
  const auto r = run(graph, {"--no-cache"}, {.largest_file = 512});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_NE(r.err.find("error: file"), std::string::npos) << r.err;
  EXPECT_EQ(left_behind(), std::vector<std::string>{});
  // A cache that cannot grow does not affect results.
  const auto values =
      run(write("h.yaml", "terrazzo: 1\nnodes:\n  rock: {type: Shape, params: {kind: rock}}\n"), {},
          {.largest_file = 512});
  EXPECT_EQ(values.exit_code, 0) << values.err;
  EXPECT_NE(values.err.find("not kept"), std::string::npos) << values.err;
}

TEST_F(BadInput, CtrlCAtAnyMomentLeavesNothingHalfWritten) {
  const fs::path graph = test::source_folder() / "graphs/materials/terrazzo.yaml";
  const std::vector<std::string> small = {"--param", "size=22",           "--param", "resolution=40",
                                          "--set",   "detail.size=32",    "--set",   "section.width=28",
                                          "--set",   "section.height=28", "--set",   "block.samples=2",
                                          "--set",   "block.width=96",    "--set",   "block.height=96"};
  for (const double after : {0.05, 0.3, 0.7, 1.2}) {
    auto r = run(graph, small, {.interrupt_after = after});
    EXPECT_TRUE(r.exit_code == 130 || r.exit_code == 0) << r.exit_code << r.err;
    for (const auto& f : left_behind()) EXPECT_EQ(f.find(".tmp"), std::string::npos) << f;
  }
  const auto whole = run(graph, small);
  EXPECT_EQ(whole.exit_code, 0) << whole.err;
}

TEST_F(BadInput, WrongCommandLines) {
  EXPECT_EQ(run_program({}).exit_code, 2);
  EXPECT_EQ(run_program({"rnu"}).exit_code, 2);
  EXPECT_EQ(run_program({"check"}).exit_code, 2);
  EXPECT_EQ(run_program({"run", "nowhere.yaml"}).exit_code, 2);
  const auto graph = write("g.yaml", export_graph);
  EXPECT_SAYS(run(graph, {"--set", "rock.sede=3"}), 2, "did you mean 'seed'");
  EXPECT_SAYS(run(graph, {"--set", "rock"}), 2, "NODE.PARAM=VALUE");
  EXPECT_SAYS(run(graph, {"--target", "rokc"}), 2, "did you mean 'rock'");
  EXPECT_SAYS(run_program({"nodes", "Shpae"}), 2, "did you mean 'Shape'");
}

}  // namespace
}  // namespace terrazzo
