// What commands print: output that cannot be written, and text from strangers.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "nodes/common/io/provenance.h"
#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::run_program;

class OutputThatIsLost : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder / "g.yaml")
        << "terrazzo: 1\nnodes:\n  p: {type: Pattern, params: {width: 16, height: 16}}\n"
           "  w: {type: Export, inputs: {image: p.image}, params: {path: p.png}}\n";
    std::ofstream(folder / "bad.yaml") << "terrazzo: 1\nnodes:\n  p: {type: Patern}\n";
  }
  // Runs "terrazzo ARGUMENTS" in a shell, in the folder.
  test::ProgramRun shell(const std::string& arguments) {
    const std::string program = (test::build_folder() / "terrazzo").string();
    return test::run_command({"bash", "-c", "'" + program + "' " + arguments}, {.folder = folder});
  }
  const fs::path folder = test::temporary_folder();
};

TEST_F(OutputThatIsLost, IsAFailureInEveryCommand) {
  ASSERT_EQ(shell("run g.yaml --cache c").exit_code, 0);
  ASSERT_EQ(shell("sweep g.yaml --vary p.seed=1,2 --out swept --no-cache").exit_code, 0);
  for (const char* command : {"run g.yaml --no-cache",
                              "run g.yaml --no-cache --dry-run",
                              "check g.yaml",
                              "show g.yaml p.image --no-cache",
                              "show g.yaml p.image --no-cache --json",
                              "explain g.yaml --no-cache",
                              "graph g.yaml",
                              "methods g.yaml",
                              "nodes",
                              "nodes Export",
                              "nodes --json",
                              "schema",
                              "sweep g.yaml --vary p.seed=1,2 --out again --no-cache",
                              "status swept",
                              "cache stats --cache c",
                              "cache verify --cache c",
                              "cache gc --cache c",
                              "reproduce out/p.png --yes --no-cache",
                              "completion bash",
                              "manual",
                              "--version",
                              "--help",
                              "run --help",
                              "complete -- ru",
                              "studio g.yaml --no-browser --no-cache",
                              "paint out/p.png"}) {
    const auto r = shell(std::string(command) + " > /dev/full");
    EXPECT_EQ(r.exit_code, 1) << command << ": " << r.err;
    const bool silent =
        std::string(command).starts_with("complete ") || r.err.find("without the page") != r.err.npos;
    if (!silent) {
      EXPECT_NE(r.err.find("cannot write to standard output"), std::string::npos) << command << ": " << r.err;
    }
  }
}

TEST_F(OutputThatIsLost, OnAClosedFileOrTheErrorOutputToo) {
  const auto closed = shell("check g.yaml >&-");
  EXPECT_EQ(closed.exit_code, 1);
  EXPECT_NE(closed.err.find("cannot write to standard output: Bad file descriptor"), std::string::npos)
      << closed.err;
  EXPECT_EQ(shell("run g.yaml --no-cache --quiet >&- 2>&-").exit_code, 0);  // nothing was to be printed
  EXPECT_EQ(shell("check bad.yaml 2> /dev/full").exit_code, 2);
  EXPECT_EQ(shell("check bad.yaml > /dev/full").exit_code, 2);
  // Files that the program opens do not take the place of the closed ones.
  EXPECT_EQ(shell("run g.yaml --no-cache --out clean >&- <&-").exit_code, 1);
  EXPECT_EQ(read_file(folder / "clean/p.png").value_or("x").find("computed"), std::string::npos);
}

TEST_F(OutputThatIsLost, AReaderThatGoesAwayIsNoError) {
  const auto r = shell("schema | head -c 10; echo \" ${PIPESTATUS[0]}\"");
  EXPECT_TRUE(r.out.ends_with(" 141\n")) << r.out;  // ended by SIGPIPE, like other programs
  EXPECT_EQ(r.err, "");
  // Where the signal is ignored, quiet as well, but no success.
  const auto ignored = test::run_command({"bash", "-c",
                                          "trap '' PIPE; '" + (test::build_folder() / "terrazzo").string() +
                                              "' schema | true; echo ${PIPESTATUS[0]}"});
  EXPECT_EQ(ignored.out, "1\n");
  EXPECT_EQ(ignored.err, "");
}

class TextOfStrangers : public OutputThatIsLost {
 protected:
  static bool steers(const std::string& text) {
    return text.find_first_of("\x1b\r\x07\x7f") != std::string::npos ||
           text.find("\u202e") != std::string::npos || text.find("\u009b") != std::string::npos;
  }
};

TEST_F(TextOfStrangers, ErasesNothingThatReproduceShows) {
  const std::string evil = "\\e[1A\\e[2K\\r\\u202e\\x9b2K\\a";
  const json report = {
      {"document",
       "terrazzo: 1\nname: \"" + evil + "\"\nnodes:\n  p: {type: LoadImage, params: {path: \"a" + evil +
           "\\n  reads  b.png\"}}\n  w: {type: Export, inputs: {image: p.image}, params: {path: x.png}}\n"
           "outputs: {\"o" +
           evil + "\": p.image}\n"},
      {"nodes", json::array()}};
  std::ofstream(folder / "report.json") << report.dump();
  fs::copy_file(test::source_folder() / "graphs/samples/section.png",
                folder / "a\x1b[1A\x1b[2K\r\u202e\u009b2K\x07\n  reads  b.png");
  const auto r = shell("reproduce report.json --no-cache --yes");
  EXPECT_FALSE(steers(r.out)) << r.out;
  EXPECT_FALSE(steers(r.err)) << r.err;
  EXPECT_NE(
      r.out.find("\\u001b[1A\\u001b[2K\\u000d\\u202e\\u009b2K\\u0007\\u000a  reads  b.png, which is NOT"),
      std::string::npos)
      << r.out;
}

TEST_F(TextOfStrangers, SteersNoTerminalFromAGraphOrAFile) {
  std::ofstream(folder / "name.yaml") << "terrazzo: 1\nnodes:\n  \"a\\e[2K\": {type: Pattern}\n";
  std::ofstream(folder / "value.yaml")
      << "terrazzo: 1\nnodes:\n  p: {type: Pattern, params: {kind: \"x\\e[2K\\nerror: y\"}}\n";
  std::ofstream(folder / "table.csv") << "a\x1b[2K,b\nx\u202e,\"1\n2\"\n";
  std::ofstream(folder / "table.yaml")
      << "terrazzo: 1\nnodes:\n  t: {type: LoadTable, params: {path: table.csv}}\n"
         "outputs: {\"t\\e[2K\": t.table}\n";
  for (const char* command : {"check name.yaml", "check value.yaml", "run value.yaml --no-cache",
                              "run table.yaml --no-cache", "show table.yaml t.table --no-cache",
                              "graph table.yaml --format svg", "graph table.yaml --format dot"}) {
    const auto r = shell(command);
    EXPECT_FALSE(steers(r.out)) << command << ": " << r.out;
    EXPECT_FALSE(steers(r.err)) << command << ": " << r.err;
    EXPECT_EQ(r.err.find("\nerror: y"), std::string::npos) << command << ": " << r.err;
  }
  // As JSON, the text keeps its meaning.
  const auto shown = shell("show table.yaml t.table --no-cache --json");
  EXPECT_FALSE(steers(shown.out)) << shown.out;
  EXPECT_NE(json::parse(shown.out).dump().find("x\u202e"), std::string::npos) << shown.out;
}

// A file says how it was made, but not where its maker keeps files.
class ProvenanceOfFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(secret / "inside");
    fs::copy_file(test::source_folder() / "nodes/photograph/load_image/section.png",
                  secret / "inside" / "photo.png");
    std::ofstream(secret / "g.yaml") << R"(terrazzo: 1
parameters: {photo: {type: path}, from: {type: text, default: inside}}
nodes:
  photo: {type: LoadImage, params: {path: "${photo}"}}
  again: {type: LoadImage, params: {path: "${from}/photo.png"}}
  grain: {type: Grain, inputs: {image: photo.image}}
  profiles: {type: Segment, inputs: {image: again.image}, params: {method: clusters}}
  shape: {type: Shape, params: {kind: box}}
  sizes: {type: Distribution, params: {mean: 1, sd: 0.1, volume_fraction: 0.1}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {count: 5}}
  color: {type: Colorize, inputs: {particles: pack.particles, profiles: profiles.profiles}}
  voxels: {type: Voxelize, inputs: {particles: color.particles, shapes: shape.shapes}, params: {resolution: 8}}
  pictures: {type: Export, each: {path: [a.png, a.exr, a.tif, a.jpg]}, inputs: {image: grain.image}, params: {path: "${path}"}}
  bodies: {type: Export, each: {path: [a.glb, a.usda, a.xml, b.pbrt]}, inputs: {particles: color.particles, shapes: shape.shapes}, params: {path: "${path}"}}
  grids: {type: Export, each: {path: [a.vdb, a.vti, a.dream3d, a.inp, a.nii, a.nii.gz]}, inputs: {volume: voxels.volume}, params: {path: "${path}"}}
)";
    const auto r =
        run_program({"run", (secret / "g.yaml").string(), "--out", out.string(), "--no-cache", "--param",
                     "photo=" + (secret / "inside" / "photo.png").string(), "--param",
                     "from=" + (secret / "inside").string(), "--set",
                     "again.path=" + (secret / "inside" / ".." / "inside" / "photo.png").string()});
    ASSERT_EQ(r.exit_code, 0) << r.err;
  }
  const fs::path folder = test::temporary_folder(), secret = folder / "secretfolder";
  const fs::path out = secret / "deep" / "out";
};

TEST_F(ProvenanceOfFiles, NamesNoFolders) {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  const std::set<std::string> without = {".csv", ".json", ".ply"};  // formats without provenance
  int files = 0;
  for (const auto& entry : fs::directory_iterator(out)) {
    if (entry.path().filename() == "report.json") continue;
    const std::string content = read_file(entry.path()).value_or("");
    const std::string provenance = read_provenance(entry.path());
    const bool beside = entry.path().filename().string().starts_with("a_");  // a part of another file
    if (!beside && !without.contains(entry.path().extension())) {
      ++files;
      const json j = json::parse(provenance, nullptr, false);
      ASSERT_TRUE(j.is_object()) << entry.path();
      EXPECT_NE(j.at("document").get<std::string>().find("path: \"photo.png\""), std::string::npos)
          << provenance;
    }
    for (const std::string& word :
         {std::string("secretfolder"), std::string("inside"), folder.string(), std::string(host)}) {
      if (word.size() < 4) continue;  // a host's name may be part of any word
      EXPECT_EQ(provenance.find(word), std::string::npos) << entry.path() << ": " << provenance;
      EXPECT_EQ(content.find(word), std::string::npos) << entry.path() << " contains " << word;
    }
  }
  EXPECT_EQ(files, 14);
}

TEST_F(ProvenanceOfFiles, IsEnoughToReproduceThem) {
  const auto reproduced = [&](const fs::path& file, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"reproduce",  file.string(), "--yes",
                                          "--no-cache", "--out",       (folder / "again").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  };
  // The report beside the file says where the photograph was.
  const auto beside = reproduced(out / "a.png", {});
  EXPECT_EQ(beside.exit_code, 0) << beside.out << beside.err;
  EXPECT_EQ(beside.out.find("different action key"), std::string::npos) << beside.out;
  // Elsewhere its folder or the file is named, and the content is compared.
  fs::create_directories(folder / "mail");
  fs::copy_file(out / "a.glb", folder / "mail" / "a.glb");
  const auto lost = reproduced(folder / "mail" / "a.glb", {});
  EXPECT_NE(lost.exit_code, 0);
  EXPECT_NE(lost.out.find("photo.png, which was not found (--set again.path=FILE"), std::string::npos)
      << lost.out;
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--allow-read", (secret / "inside").string()},
        {"--set", "again.path=" + (secret / "inside" / "photo.png").string()}}) {
    const auto found = reproduced(folder / "mail" / "a.glb", more);
    EXPECT_EQ(found.exit_code, 0) << found.out << found.err;
    EXPECT_EQ(found.out.find("different action key"), std::string::npos) << found.out;
  }
}

// Two files of one name in different folders.
TEST_F(ProvenanceOfFiles, EachNodeFindsItsOwnFile) {
  fs::create_directories(secret / "b");
  fs::copy_file(test::source_folder() / "nodes/photograph/load_labels/mask.png", secret / "b" / "photo.png");
  std::ofstream(secret / "two.yaml") << R"(terrazzo: 1
nodes:
  a: {type: LoadImage, params: {path: inside/photo.png}}
  b: {type: LoadImage, params: {path: b/photo.png}}
  sheet: {type: ContactSheet, inputs: {images: [a.image, b.image]}}
  w: {type: Export, inputs: {image: sheet.image}, params: {path: two.png}}
)";
  ASSERT_EQ(
      run_program({"run", (secret / "two.yaml").string(), "--out", (secret / "two").string(), "--no-cache"})
          .exit_code,
      0);
  fs::remove(secret / "two" / "report.json");
  const auto r = run_program({"reproduce", (secret / "two" / "two.png").string(), "--yes", "--no-cache",
                              "--out", (folder / "again").string(), "--allow-read", (secret / "b").string(),
                              "--allow-read", (secret / "inside").string()});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  EXPECT_EQ(r.out.find("different action key"), std::string::npos) << r.out;
}

}  // namespace
}  // namespace terrazzo
