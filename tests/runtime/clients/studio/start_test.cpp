// How the Studio opens and creates graphs: from photographs, from materials, and under other names.
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "nodes/common/io/image_file.h"
#include "nodes/register_nodes.h"
#include "runtime/clients/studio/new_material.h"
#include "runtime/clients/studio/views/materials.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

#include "tests/runtime/clients/studio/studio_server_fixture.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// Opened materials have errors, since their node types are unknown, and nothing is evaluated.
class StudioStarts : public test::StudioServerTest {
 protected:
  StudioStarts() {
    write_image(folder / "photo.png", Image(30, 20, 1, 1, Vec3f(0.1f, 0.4f, 0.2f)));
    bytes = *read_file(folder / "photo.png");
    serve({.workspace = studio::Workspace(folder), .welcome = true}, false);
  }
  json post(const std::string& path, const std::string& body, const char* type) const {
    const auto r = client().Post(path.c_str(), body, type);
    return r ? json::parse(r->body) : json{{"code", "no answer"}};
  }
  json post(const std::string& path, const json& body) const {
    return post(path, body.dump(), "application/json");
  }
  json upload(const std::string& query, const std::string& body) const {
    return post("/api/photograph?" + query, body, "application/octet-stream");
  }
  json document() const { return json::parse(client().Get("/api/state")->body)["document"]; }

  std::string bytes;
};

TEST_F(StudioStarts, AnUploadedPhotographBecomesAGraphBesideIt) {
  EXPECT_EQ(json::parse(client().Get("/api/start")->body)["welcome"], true);
  const std::string query = "name=../my%20stone.png&folder=stone&pixel_size=0.05";
  EXPECT_EQ(upload(query, bytes)["file"], (folder / "stone/my stone.yaml").string());
  EXPECT_EQ(*read_file(folder / "stone/my stone.png"), bytes);
  const std::string text = document()["text"];
  EXPECT_EQ(text, *read_file(folder / "stone/my stone.yaml"));
  EXPECT_NE(text.find("photo: {type: path, default: my stone.png, "), std::string::npos) << text;
  EXPECT_NE(text.find("pixel_size: {type: number, default: 0.05, "), std::string::npos);
  EXPECT_EQ(json::parse(client().Get("/api/start")->body)["welcome"], false);
  // The same again opens the same file. Once that is another graph, it is not replaced.
  EXPECT_EQ(upload(query, bytes)["file"], (folder / "stone/my stone.yaml").string());
  write_text_atomically(folder / "stone/my stone.yaml", text + "# mine\n");
  EXPECT_EQ(upload(query, bytes)["file"], (folder / "stone/my stone_2.yaml").string());
  EXPECT_EQ(*read_file(folder / "stone/my stone.yaml"), text + "# mine\n");
  EXPECT_EQ(upload(query, bytes)["file"], (folder / "stone/my stone_2.yaml").string());
  EXPECT_FALSE(fs::exists(folder / "stone/my stone_2.png"));
}

// Wavy bands are phases; separate discs are particles.
Image drawn(bool bands) {
  Image out(128, 128, 1, 1);
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) {
      const bool in = bands ? std::sin(0.3 * x + 3 * std::sin(0.15 * y)) > 0
                            : std::hypot(x % 32 - 15.5, y % 32 - 15.5) < 11;
      out.at(x, y) = Vec3f::Constant(in ? 0.8f : 0.1f);
    }
  return out;
}

TEST_F(StudioStarts, APictureOfPhasesIsRecognizedAndBecomesAGraphOfPhases) {
  const auto recommended = [&](bool bands) {
    write_image(folder / "drawn.png", drawn(bands));
    return post("/api/recommend?name=drawn.png", *read_file(folder / "drawn.png"),
                "application/octet-stream");
  };
  EXPECT_EQ(recommended(false)["content"], "particles");
  const json phases = recommended(true);
  EXPECT_EQ(phases["content"], "phases");
  EXPECT_NE(phases["why"].get<std::string>().find("2 gray levels"), std::string::npos) << phases;
  // A flat picture has no phases, and what is no picture is refused.
  EXPECT_EQ(post("/api/recommend?name=a.png", bytes, "application/octet-stream")["content"], "particles");
  EXPECT_EQ(post("/api/recommend?name=a.png", "no picture", "application/octet-stream")["code"],
            "unreadable-image");

  const std::string drawn = *read_file(folder / "drawn.png");
  EXPECT_EQ(upload("name=a.png&folder=a&content=stripes", drawn)["code"], "bad-value");
  EXPECT_EQ(upload("name=rock.png&folder=a&pixel_size=0.05&content=phases", drawn)["file"],
            (folder / "a/rock.yaml").string());
  const std::string text = document()["text"];
  EXPECT_EQ(document()["name"], "rock");
  EXPECT_NE(text.find("photo: {type: path, default: rock.png, "), std::string::npos) << text;
  EXPECT_NE(text.find("type: MediaSolid"), std::string::npos);
}

TEST_F(StudioStarts, WhatIsNoPictureLeavesNothingBehind) {
  const json bad = upload("name=a.png&folder=new", "no picture");
  EXPECT_EQ(bad["code"], "unreadable-image");
  EXPECT_EQ(bad["message"].get<std::string>().find("/tmp/"), std::string::npos) << bad;
  EXPECT_EQ(upload("name=a.png&folder=new", bytes.substr(0, bytes.size() / 2))["code"], "unreadable-image");
  EXPECT_EQ(upload("name=a.svg&folder=new", "<svg/>")["code"], "unknown-format");
  EXPECT_EQ(upload("name=.png&folder=new", bytes)["code"], "unknown-format");
  EXPECT_EQ(upload("name=a.png&folder=../elsewhere", bytes)["code"], "outside-folder");
  EXPECT_EQ(upload("name=a.png&folder=/tmp", bytes)["code"], "outside-folder");
  EXPECT_EQ(upload("name=a.png&folder=a%00b", bytes)["code"], "bad-name");
  EXPECT_EQ(upload("name=a.png&folder=new&pixel_size=x", bytes)["code"], "bad-value");
  EXPECT_EQ(post("/api/photograph?name=a.png&folder=new", bytes, "image/png")["code"], "bad-request");
  EXPECT_EQ(upload("name=a.png&folder=new", std::string((64 << 20) + 1, ' '))["code"], "too-large");
  fs::create_directory_symlink("/tmp", folder / "link");
  EXPECT_EQ(upload("name=a.png&folder=link", bytes)["code"], "outside-folder");
  EXPECT_FALSE(fs::exists(folder / "new/a.yaml"));
  EXPECT_EQ(document()["text"], kText);
}

TEST_F(StudioStarts, UnsavedChangesAreNotLeftWithoutAsking) {
  live->change([](studio::Document& d) { d.replace(kText + "# more\n"); });
  EXPECT_EQ(upload("name=a.png&folder=a", bytes)["code"], "unsaved-changes");
  EXPECT_FALSE(fs::exists(folder / "a"));
  EXPECT_EQ(post("/api/open", {{"material", "gravel"}})["code"], "unsaved-changes");
  EXPECT_EQ(post("/api/open", {{"material", "gravl"}, {"discard", true}})["code"], "unknown-material");
  EXPECT_EQ(post("/api/open", {{"material", "../library/aggregate"}, {"discard", true}})["code"],
            "unknown-material");
  EXPECT_NE(post("/api/open", {{"material", "gravel"}, {"discard", true}})["file"], nullptr);
  EXPECT_EQ(document()["name"], "Gravel");
  EXPECT_EQ(document()["read_only"], true);
  EXPECT_TRUE(fs::exists(folder / ".graph.yaml.unsaved"));  // the other graph's changes
  EXPECT_EQ(post("/api/save", json::object())["code"], "read-only");
}

TEST_F(StudioStarts, GraphsBelowTheFolderAreListedAndOpened) {
  const auto put = [&](const char* name, const std::string& text) {
    fs::create_directories((folder / name).parent_path());
    write_text_atomically(folder / name, text);
  };
  put("sub/mine.yaml", "# a comment first\n" + kText);
  put("other.yaml", "name: no graph\nabout: \"terrazzo: 1\"\n");
  put(".hidden/x.yaml", kText);
  put("a/b/c/d/e/deep.yaml", kText);
  ASSERT_EQ(::mkfifo((folder / "pipe.yaml").c_str(), 0600), 0);
  fs::create_symlink("/proc/self/environ", folder / "away.yaml");
  const auto now = fs::last_write_time(folder / "sub/mine.yaml");
  fs::last_write_time(folder / "graph.yaml", now - std::chrono::hours(1));
  json files = json::array();
  const json start = json::parse(client().Get("/api/start")->body);
  for (const auto& g : start["graphs"]) files.push_back(g["file"]);
  EXPECT_EQ(files, (json{"sub/mine.yaml", "graph.yaml"}));  // newest first
  EXPECT_EQ(post("/api/open", {{"graph", "sub/mine.yaml"}})["file"], (folder / "sub/mine.yaml").string());
  EXPECT_EQ(document()["read_only"], false);
  EXPECT_EQ(post("/api/open", {{"graph", "../x.yaml"}})["code"], "outside-folder");
  EXPECT_EQ(post("/api/open", {{"graph", "away.yaml"}})["code"], "outside-folder");
  EXPECT_EQ(post("/api/open", {{"graph", "none.yaml"}})["code"], "no-file");
  live->change([](studio::Document& d) { d.replace(kText + "# more\n"); });
  EXPECT_EQ(post("/api/open", {{"graph", "graph.yaml"}})["code"], "unsaved-changes");
}

TEST_F(StudioStarts, AGraphIsSavedUnderAnotherName) {
  EXPECT_EQ(post("/api/save_as", {{"file", "graph.yaml"}})["code"], "file-exists");
  EXPECT_EQ(post("/api/save_as", {{"file", "../graph.yaml"}})["code"], "outside-folder");
  live->change([](studio::Document& d) { d.replace(kText + "# more\n"); });
  EXPECT_EQ(post("/api/save_as", {{"file", "sub/copy"}})["file"], (folder / "sub/copy.yaml").string());
  EXPECT_EQ(*read_file(folder / "sub/copy.yaml"), kText + "# more\n");
  EXPECT_EQ(*read_file(folder / "graph.yaml"), kText);
  EXPECT_FALSE(fs::exists(folder / ".graph.yaml.unsaved"));
  EXPECT_EQ(document()["saved"], true);
  EXPECT_EQ(document()["can_undo"], true);
}

TEST(StudioNewMaterial, ThePhotographsGraphIsCompleteAndComputesNothingElse) {
  Registry registry;
  register_nodes(registry);
  const std::string text = studio::graph_of_photograph("a b: c.png", "Stone", studio::Content::Particles,
                                                       {{"pixel_size", "0.05"}});
  Diagnostics found;
  const Graph graph = load_graph_text(text, test::source_folder() / "graphs/x.yaml", registry, {}, found);
  for (const auto& d : found) EXPECT_EQ(d.code, "no-file") << d.text();
  EXPECT_EQ(graph.name, "Stone");
  EXPECT_NE(text.find("# at the photograph's scale"), std::string::npos);
  for (const char* file : {"{path: Stone.glb}", "{path: Stone_preview.png}"})
    EXPECT_NE(text.find(file), std::string::npos) << file;
  EXPECT_GE(graph.find("segment"), 0);
  EXPECT_EQ(graph.find("voxels_2004"), -1);
  for (const int i : graph.sinks()) {
    const GraphNode& n = graph.nodes[static_cast<std::size_t>(i)];
    const bool output = std::ranges::any_of(graph.outputs, [&](const auto& o) { return o.wire.node == i; });
    EXPECT_TRUE(n.type->writes_files || output) << n.path;
  }
  const auto sections = graph.nodes[static_cast<std::size_t>(graph.find("section_file"))];
  EXPECT_EQ(graph.nodes[static_cast<std::size_t>(sections.inputs.at("image")[0].node)].path, "section");
}

TEST(StudioNewMaterial, ReferencesFollowAGraphThatMoves) {
  Registry registry;
  register_nodes(registry);
  const fs::path home = fs::canonical(test::temporary_folder());
  const studio::Workspace workspace(home);
  for (const auto& m : studio::materials()) {
    const std::string text =
        studio::relocated(*read_file(m.file), m.file, home / "x.yaml", workspace, registry);
    Diagnostics found, before;
    load_graph_text(text, home / "x.yaml", registry, {}, found);
    load_graph(m.file, registry, {}, before);
    EXPECT_EQ(found.size(), before.size()) << m.name << ": " << (found.empty() ? "" : found.front().text());
  }
  const std::string own =
      "terrazzo: 1\nparameters:\n  p: {type: path, default: b.png}\nnodes:\n"
      "  a: {type: LoadImage, params: {path: a.png}}  # kept\n"
      "  b: {type: LoadImage, params: {path: \"${p}\"}}\n";
  EXPECT_EQ(studio::relocated(own, home / "g.yaml", home / "sub/g.yaml", workspace, registry),
            "terrazzo: 1\nparameters:\n  p: {type: path, default: ../b.png}\nnodes:\n"
            "  a: {type: LoadImage, params: {path: ../a.png}}  # kept\n"
            "  b: {type: LoadImage, params: {path: \"${p}\"}}\n");
  EXPECT_EQ(studio::relocated(own, "/else/g.yaml", home / "g.yaml", workspace, registry)
                    .find("path: /else/a.png") != std::string::npos,
            true);
}

}  // namespace
}  // namespace terrazzo
