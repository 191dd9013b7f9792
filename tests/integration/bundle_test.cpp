// Bundles as other people use them: what `terrazzo bundle` writes opens anywhere, and what strangers made
// cannot reach outside its folder.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zip.h>

#include <nlohmann/json.hpp>

#include "nodes/common/io/image_file.h"
#include "runtime/bundle/bundle.h"
#include "runtime/files.h"
#include "tests/support/all_nodes.h"
#include "tests/support/code_of.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"
#include "tests/support/zip_file.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using Entries = std::vector<std::pair<std::string, std::string>>;

const std::string kManifest = R"({"terrazzo_bundle": 1, "graph": "graph.yaml"})";
const std::string kGraph =
    "terrazzo: 1\nnodes:\n  picture: {type: LoadImage, params: {path: a.png}}\n  sheet: {type: ContactSheet, "
    "inputs: {images: picture.image}}\n";

class BundleTest : public ::testing::Test {
 protected:
  // A graph with a subgraph, a picture beside it, and one elsewhere.
  void SetUp() override {
    for (const char* name : {"home/material", "home/library", "elsewhere"})
      fs::create_directories(folder / name);
    write_image(folder / "home/library/a.png", Image(6, 4, 1, 1, Vec3f(0.1f, 0.4f, 0.2f)));
    write_image(folder / "elsewhere/b.png", Image(8, 4, 1, 1, Vec3f(0.3f, 0.2f, 0.1f)));
    write_text_atomically(folder / "home/library/LICENSE.txt", "CC0");
    write_text_atomically(folder / "home/library/part.yaml",
                          "terrazzo: 1\nname: Part\nnodes:\n  picture: {type: LoadImage, params: {path: "
                          "a.png}}\noutputs: {image: picture.image}\n");
    write_text_atomically(
        graph, "# kept\nterrazzo: 1\nname: Two\nparameters:\n  photo: {type: path, default: " +
                   (folder / "elsewhere/b.png").string() +
                   "}  # elsewhere\nnodes:\n  part: {graph: ../library/part.yaml}\n  other: {type: "
                   "LoadImage, params: {path: \"${photo}\"}}\n  sheet: {type: ContactSheet, inputs: "
                   "{images: [part.image, other.image]}}\n  file: {type: Export, inputs: {image: "
                   "sheet.image}, params: {path: preview.png}}\n");
  }
  test::ProgramRun program(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--cache", (folder / "cache").string()});
    return test::run_program(arguments);
  }
  std::string preview_of(const fs::path& graph_or_bundle, const std::string& out) {
    const auto run = program({"run", graph_or_bundle.string(), "--quiet", "--out", (folder / out).string()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const auto report = nlohmann::json::parse(*read_file(folder / out / "report.json"));
    for (const auto& node : report["nodes"])
      if (node["name"] == "sheet") return node["outputs"]["image"]["content"];
    return {};
  }
  // The code with which an archive of these files is refused.
  std::string refusal(const Entries& entries) {
    return test::code_of(
        [&] { open_bundle(test::write_zip(folder / "bad.zip", entries), test::all_nodes()); });
  }

  const fs::path folder = test::temporary_folder(), graph = folder / "home/material/two.yaml";
};

TEST_F(BundleTest, OpenAnywhere) {
  const std::string expected = preview_of(graph, "out");
  for (const std::string name : {"two.zip", "two"}) {
    const auto made =
        program({"bundle", graph.string(), "--out", (folder / name).string(), "--license", "CC0"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  fs::rename(folder / "home", folder / "gone");
  fs::remove_all(folder / "elsewhere");
  EXPECT_EQ(preview_of(folder / "two.zip", "out_zip"), expected);
  EXPECT_EQ(preview_of(folder / "two", "out_folder"), expected);
  const std::string text = *read_file(folder / "two/material/two.yaml");
  EXPECT_NE(text.find("default: ../files/b.png}  # elsewhere"), std::string::npos) << text;
  EXPECT_EQ(text.rfind("# kept", 0), 0u);
  EXPECT_EQ(*read_file(folder / "two/library/LICENSE.txt"), "CC0");
  const std::string notes = *read_file(folder / "two/NOTES.md");
  for (const char* word : {"# Two", "License: CC0", "files/b.png", "LoadImage"})
    EXPECT_NE(notes.find(word), std::string::npos) << notes;
  const BundleInfo info = read_bundle_info(folder / "two.zip");
  EXPECT_EQ(info.title, "Two");
  EXPECT_EQ(info.license, "CC0");
  EXPECT_TRUE(read_bundle_preview(folder / "two.zip"));
  EXPECT_EQ(test::run_program({"check", (folder / "two.zip").string()}).exit_code, 0);
}

// A sweep unpacks the archive below its output folder once, and a second run continues it there.
TEST_F(BundleTest, CanBeSwept) {
  const fs::path bundle = folder / "two.zip", out = folder / "out";
  ASSERT_EQ(program({"bundle", graph.string(), "--out", bundle.string()}).exit_code, 0);
  fs::rename(folder / "home", folder / "gone");
  fs::remove_all(folder / "elsewhere");
  const std::vector<std::string> sweep{"sweep", bundle.string(), "--vary", "sheet.cell=60,80",
                                       "--out", out.string()};
  for (const char* counted : {"2 points", "again"}) {
    const auto run = program(sweep);
    EXPECT_EQ(run.exit_code, 0) << counted << run.err;
  }
  EXPECT_TRUE(fs::exists(out / "sweep.csv"));
  std::size_t folders = 0;
  for (const auto& entry : fs::directory_iterator(out))
    folders += entry.path().filename().string().starts_with("two-");
  EXPECT_EQ(folders, 1u);
}

TEST_F(BundleTest, EqualMaterialsGiveEqualBytes) {
  for (const std::string name : {"1.zip", "2.zip"})
    ASSERT_EQ(
        program({"bundle", graph.string(), "--no-preview", "--out", (folder / name).string()}).exit_code, 0);
  EXPECT_EQ(*read_file(folder / "1.zip"), *read_file(folder / "2.zip"));
}

TEST_F(BundleTest, ReplaceNothingAndNameWhatIsMissing) {
  fs::create_directories(folder / "there");
  const auto there =
      program({"bundle", graph.string(), "--no-preview", "--out", (folder / "there").string()});
  EXPECT_NE(there.err.find("exists already"), std::string::npos) << there.err;
  fs::remove(folder / "elsewhere/b.png");
  const auto missing =
      program({"bundle", graph.string(), "--no-preview", "--out", (folder / "x.zip").string()});
  EXPECT_NE(missing.err.find("b.png', which does not exist"), std::string::npos) << missing.err;
  EXPECT_NE(missing.exit_code, 0);
  EXPECT_FALSE(fs::exists(folder / "x.zip"));
}

TEST_F(BundleTest, NamesThatLeadOutAreRefused) {
  const std::string picture = *read_file(folder / "home/library/a.png");
  const Entries good = {{"bundle.json", kManifest}, {"graph.yaml", kGraph}, {"a.png", picture}};
  EXPECT_EQ(refusal(good), "");
  for (const std::string name :
       {"../evil", "/tmp/evil", "a/../../evil", "./evil", "a//../../evil", "..\\evil", "evil\n"}) {
    Entries entries = good;
    entries.emplace_back(name, "x");
    EXPECT_EQ(refusal(entries), "bad-bundle") << name;
  }
  Entries twice = good;
  twice.emplace_back("A.PNG", "x");
  EXPECT_EQ(refusal(twice), "bad-bundle");
  EXPECT_FALSE(fs::exists(folder / "evil"));
  EXPECT_EQ(refusal({{"graph.yaml", kGraph}}), "bad-bundle");
  EXPECT_EQ(refusal({{"bundle.json", R"({"terrazzo_bundle": 2, "graph": "graph.yaml"})"}}), "bad-bundle");
  EXPECT_EQ(refusal({{"bundle.json", R"({"terrazzo_bundle": 1, "graph": "../graph.yaml"})"}}), "bad-bundle");
}

TEST_F(BundleTest, LinksInArchivesAreRefused) {
  const fs::path file = test::write_zip(
      folder / "link.zip", {{"bundle.json", kManifest}, {"graph.yaml", kGraph}, {"a.png", "/etc/passwd"}});
  zip_t* zip = zip_open(file.c_str(), 0, nullptr);
  zip_file_set_external_attributes(zip, 2, 0, ZIP_OPSYS_UNIX, (S_IFLNK | 0777u) << 16);
  ASSERT_EQ(zip_close(zip), 0);
  EXPECT_EQ(test::code_of([&] { open_bundle(file, test::all_nodes()); }), "bad-bundle");
}

TEST_F(BundleTest, GraphsReadOnlyTheirOwnFolder) {
  const fs::path own = folder / "stranger";
  fs::create_directories(own);
  write_text_atomically(own / "bundle.json", kManifest);
  const auto code = [&](const std::string& text) {
    write_text_atomically(own / "graph.yaml", text);
    return test::code_of([&] { open_bundle(own, test::all_nodes()); });
  };
  const auto reads = [](const std::string& path) {
    return "terrazzo: 1\nparameters:\n  place: {type: text, default: ..}\nnodes:\n  picture: {type: "
           "LoadImage, params: {path: \"" +
           path + "\"}}\n";
  };
  EXPECT_EQ(code(reads("a.png")), "");
  for (const std::string path :
       {"/etc/passwd", "../elsewhere/b.png", "${place}/elsewhere/b.png", "../else*/b.png"})
    EXPECT_EQ(code(reads(path)), "outside-bundle") << path;
  EXPECT_EQ(code("terrazzo: 1\nnodes:\n  part: {graph: ../home/library/part.yaml}\n"), "outside-bundle");
  fs::create_symlink(folder / "elsewhere/b.png", own / "a.png");
  EXPECT_EQ(code(reads("a.png")), "outside-bundle");
  EXPECT_EQ(code(reads("*.png")), "outside-bundle");
}

// A file that unpacks to more than the archive says, as bombs do.
TEST_F(BundleTest, SizesAreThoseThatTheArchiveStates) {
  const fs::path file = test::write_zip(
      folder / "bomb.zip",
      {{"bundle.json", kManifest}, {"graph.yaml", kGraph}, {"a.png", std::string(100'000, 'x')}});
  std::string bytes = *read_file(file);
  const std::string size = {char(0xa0), char(0x86), 1, 0};  // 100,000
  for (auto at = bytes.find(size); at != std::string::npos; at = bytes.find(size, at + 1)) bytes[at + 1] = 1;
  write_text_atomically(file, bytes);
  EXPECT_EQ(test::code_of([&] { open_bundle(file, test::all_nodes()); }), "bad-bundle");
}

}  // namespace
}  // namespace terrazzo
