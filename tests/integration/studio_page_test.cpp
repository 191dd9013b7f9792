// Tests the page of `terrazzo studio` in a browser, with mouse and keyboard.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "nodes/common/io/image_file.h"
#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

class StudioPage : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto page = test::run_command({program, "studio", (folder / "none.yaml").string()});
    if (page.err.find("without the page") != std::string::npos)
      GTEST_SKIP() << "the program was built without the page; ./dev studio builds it";
    if (browser.empty()) GTEST_SKIP() << "chromium is not installed";
    here.folder = test::npm_check("studio_page");
    if (here.folder.empty()) GTEST_SKIP() << "npm cannot install playwright-core and axe-core here";
  }

  const fs::path folder = test::temporary_folder();
  const std::string program = (test::build_folder() / "terrazzo").string(), browser = test::chromium();
  test::ProgramOptions here;
};

TEST_F(StudioPage, LooksEditsWiresUndoesAndSaves) {
  const fs::path graph = folder / "graph.yaml";
  Image picture(60, 40, 1, 1, Vec3f(0.1f, 0.4f, 0.2f));
  write_image(folder / "a.png", picture);
  const std::string text =
      "# first\nterrazzo: 1\nname: Test\nnodes:\n  picture: {type: LoadImage, params: {path: a.png}}  # "
      "second\n"
      "  sheet:\n    type: ContactSheet\n    inputs: {images: picture.image}\n    params:\n      cell: 300  "
      "# third\n";
  write_text_atomically(graph, text);
  const auto run =
      test::run_command({"timeout", "100", "node", "check.mjs", program, graph.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  EXPECT_EQ(r["errors_before_end"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["cards"], 2);
  EXPECT_EQ(r["address"].get<std::string>().find("token"), std::string::npos);
  EXPECT_NE(r["size_before"], r["size_after"]);
  std::string edited = text;
  edited.replace(edited.find("300"), 3, "100");
  EXPECT_EQ(r["text_after"], edited);
  EXPECT_EQ(r["size_bypassed"].get<std::string>().rfind("60 × 40", 0), 0u) << r["size_bypassed"];
  EXPECT_EQ(r["text_bypassed"], edited + "    bypass: true\n");
  EXPECT_NE(r["passes"].get<std::string>().find("picture.image for image"), std::string::npos) << r["passes"];
  EXPECT_EQ(r["bypass_ended"], true);
  EXPECT_EQ(r["line"], "  sheet:");
  EXPECT_EQ(r["broken_status"], "1 error in the graph");
  EXPECT_NE(r["message"].get<std::string>().find("ContactSheat"), std::string::npos);
  EXPECT_EQ(r["undone"], true);
  for (const char* step : {"note_undone", "move_undone", "move_redone", "stays_put"})
    EXPECT_EQ(r[step], true) << step;
  EXPECT_EQ(r["arrangement"], nlohmann::json::object());
  EXPECT_EQ(r["saved"], text + "  export:\n    type: Export\n    inputs: {image: sheet.image}\n");
  EXPECT_EQ(r["offered"], "Add a node that accepts Image");
  EXPECT_EQ(r["removed"], true);
  std::string copy = text.substr(text.find("  sheet:"));
  copy.replace(2, 5, "sheet_2");
  EXPECT_EQ(r["duplicated"], text + copy);
  EXPECT_EQ(r["duplicate_undone"], true);
  EXPECT_EQ(r["pasted"], true);
  EXPECT_EQ(r["from_elsewhere"],
            text +
                "  picture_2: {type: LoadImage, params: {path: a.png}} # again\n"
                "  wide:\n    type: ContactSheet\n    inputs: {images: picture_2.image}\n");
  EXPECT_NE(r["refused"].get<std::string>().find("contains no nodes"), std::string::npos) << r["refused"];
  EXPECT_EQ(r["offline"], true);
}

// Dark stones with concave sides between light pools of cement. The pools are more convex, so Segment takes
// the stones for the binder.
Image stones_between_pools() {
  constexpr int kCell = 40;
  constexpr double kJoint = 1.5;
  const Vec3f cement(0.55f, 0.49f, 0.38f);
  const Vec3f stones[] = {{0.092f, 0.08f, 0.076f}, {0.16f, 0.089f, 0.061f}, {0.117f, 0.122f, 0.138f}};
  std::mt19937 random(1);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::vector<Vec3> pools;  // x, y, radius
  for (int x = kCell / 2; x < 320; x += kCell)
    for (int y = 0; y <= 240; y += kCell / 2) pools.emplace_back(x, y, (y % kCell ? 5 : 8) + 3 * uniform());
  std::vector<int> colors;
  for (int k = 0; k < 9 * 6; ++k) colors.push_back(static_cast<int>(random() % 3));
  Image out(320, 240, 1, 1);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int k = 0; k < 16; ++k) {
        const double u = x + (k % 4 + 0.5) / 4, v = y + (k / 4 + 0.5) / 4;
        const double right = std::abs(std::fmod(u + kCell, kCell) - kCell / 2.0), up = std::fmod(v, kCell);
        const bool binder = right < kJoint || std::min(up, kCell - up) < kJoint ||
                            std::ranges::any_of(pools, [&](const Vec3& p) {
                              return std::hypot(u - p.x(), v - p.y()) < p.z();
                            });
        sum += binder ? cement : stones[colors[static_cast<int>((u + kCell / 2) / kCell) * 6 + y / kCell]];
      }
      out.at(x, y) = sum / 16 * static_cast<float>(0.9 + 0.2 * uniform());
    }
  return out;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> out;
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

// From a photograph whose binder is found wrongly to a saved material.
TEST_F(StudioPage, MakesAMaterialOfAPhotograph) {
  const Image picture = stones_between_pools();
  write_image(folder / "stones.png", picture);
  const auto run = test::run_command({"timeout", "280", "node", "scenario.mjs", program,
                                      (folder / "stones.png").string(), browser, folder.string()},
                                     here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_GE(r["materials"], 10);
  EXPECT_NE(r["chosen"].get<std::string>().find("particles"), std::string::npos) << r["chosen"];
  EXPECT_NE(r["recommended"].get<std::string>().find("Recommended: particles. The "), std::string::npos)
      << r["recommended"];
  const double share = std::ranges::count_if(picture.pixels, [](const Vec3f& c) { return c[0] > 0.3f; }) /
                       static_cast<double>(picture.pixels.size());
  EXPECT_GT(std::abs(r["binder_before"][3].get<double>() - share), 0.15) << share;
  EXPECT_NEAR(r["binder_after"][3].get<double>(), share, 0.05);
  EXPECT_EQ(r["split_by_mouse"], 1);
  EXPECT_EQ(r["cards_added"], 0);
  EXPECT_EQ(r["chosen_card"], nlohmann::json::array({"segment"}));
  EXPECT_EQ(r["undone"], true);
  EXPECT_EQ(r["split_by_keys"], 1);
  EXPECT_EQ(r["added"], "ignore 0 0 2 2");
  EXPECT_EQ(r["failed"], nlohmann::json::array());
  EXPECT_EQ(r["ran"], nlohmann::json({"block", "colorize", "compare", "observer", "pack", "section", "sheet",
                                      "view", "views", "voxels"}));

  // The difference to the graph of the photograph is what was done, and comments are where they were.
  const std::string after = r["after"];
  const fs::path file = r["file"].get<std::string>();
  EXPECT_EQ(file.lexically_relative(folder), "stones/stones.yaml");
  EXPECT_EQ(*read_file(file), after);
  auto now = lines_of(after);
  std::vector<std::string> changed;
  for (const auto& line : lines_of(r["before"])) {
    const auto same = std::ranges::find(now, line);
    if (same == now.end())
      changed.push_back(line.substr(0, line.find(": ")));
    else
      now.erase(same);
  }
  EXPECT_EQ(changed,
            (std::vector<std::string>{"  binder", "  size", "    inputs", "    inputs", "    inputs",
                                      "    inputs", "    inputs", "    params", "    inputs", "    inputs",
                                      "    inputs", "    inputs", "    inputs", "  labels", "  profiles"}));
  for (const auto& line : now)
    EXPECT_EQ(line.find('#') == std::string::npos || line.find("binder") != std::string::npos, true) << line;

  const fs::path report = folder / "report.json";
  const auto again = test::run_program({"run", file.string(), "--no-cache", "--out",
                                        (folder / "out").string(), "--report", report.string(), "--quiet"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  std::size_t equal = 0;
  const auto saved = nlohmann::json::parse(*read_file(report));
  for (const auto& node : saved["nodes"])
    for (const auto& [port, output] : node["outputs"].items()) {
      EXPECT_EQ(output["content"], r["contents"][node["name"].get<std::string>()][port])
          << node["name"] << port;
      ++equal;
    }
  EXPECT_GT(equal, 30u);
}

// Strokes on the photograph teach phases, one Strokes node for each, and undo takes them back one by one.
TEST_F(StudioPage, TeachesPhasesByStrokes) {
  const auto run =
      test::run_command({"timeout", "200", "node", "phases.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["in_order"], true);
  EXPECT_NE(r["says"].get<std::string>().find("mark 1 phase;"), std::string::npos) << r["says"];
  EXPECT_EQ(r["shown"], 4);
  EXPECT_EQ(r["after"], 0);
  EXPECT_EQ(r["undone"], true);
  EXPECT_EQ(r["stale"], 0);
  EXPECT_EQ(r["nodes"], nlohmann::json::array({"on_phase_0"}));
  const std::string text = r["text"];
  EXPECT_NE(text.find("strokes: [on_phase_0.strokes, on_phase_1.strokes, on_phase_2.strokes]"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("phases: 2"), std::string::npos) << text;
}

// Solids, slices, plots, linked views, the plane, prices, comparisons, subgraphs, notes, the nib, and pages
// without WebGL.
TEST_F(StudioPage, ShowsComparesAndCuts) {
  const auto run =
      test::run_command({"timeout", "280", "node", "views.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  // An empty drawing has two or three colors: background and frame.
  for (const char* drawing : {"particle_colors", "block_colors", "quantity_colors", "plane_colors"})
    EXPECT_GT(r[drawing], 12) << drawing;
  EXPECT_EQ(r["turned"], true);
  EXPECT_EQ(r["lit"], true);
  EXPECT_EQ(r["surrounded"], true);
  EXPECT_EQ(r["smooth"], true);
  EXPECT_EQ(r["light"], R"({"surrounding":1,"roughness":0.1})");
  EXPECT_EQ(r["scale"], "0  1 ");
  EXPECT_NE(r["picked"].get<std::string>().find("size"), std::string::npos);
  EXPECT_NE(r["row"].get<std::string>().find("row 3 is selected"), std::string::npos);
  EXPECT_NE(r["linked"].get<std::string>().find("1 size class"), std::string::npos);
  EXPECT_GT(r["brushed"], 0);
  EXPECT_EQ(r["free"], "computed");
  // A seed of the packing: the packing, and what follows from it.
  EXPECT_EQ(r["priced"], 4) << r["price"];
  EXPECT_EQ(r["price"].get<std::string>().rfind("4 nodes, about ", 0), 0u) << r["price"];
  EXPECT_EQ(r["not_sent"], true);
  EXPECT_EQ(r["wipe"], "40");
  EXPECT_GE(r["states"], 4);
  EXPECT_EQ(r["pictures"], r["states"]);
  EXPECT_EQ(r["inside"], "inner");
  EXPECT_EQ(r["note"], "Why marble?");
  EXPECT_EQ(r["tab"], 1);
  EXPECT_EQ(r["peek"].get<std::string>().rfind("Image", 0), 0u);
  EXPECT_EQ(r["nib"], true);
  EXPECT_EQ(r["pages"], 8);
  for (const char* view : {"particles", "shapes", "linked", "plane", "block"}) {
    const auto& shown = r["without"][view];
    EXPECT_NE(shown["says"].get<std::string>().find("no WebGL"), std::string::npos) << view;
    EXPECT_GT(shown["colors"], 6) << view;  // gray solids have few
  }
  EXPECT_EQ(r["turned_without"], true);
}

// A material that shows itself, its palette, its files, and what an evaluation does.
TEST_F(StudioPage, ShowsTheMaterialItsPaletteAndItsFiles) {
  const auto run =
      test::run_command({"timeout", "200", "node", "material.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["selected"], 0);
  EXPECT_EQ(r["typed"], "#ff0000, #806040, #c0c0b0; 1, 2, 5");
  EXPECT_EQ(r["weighted"], "#ff0000, #806040, #c0c0b0; 1, 3, 5");
  EXPECT_EQ(r["moved"], "#806040, #ff0000, #c0c0b0; 3, 1, 5");
  EXPECT_EQ(r["removed"], "#806040, #ff0000; 3, 1");
  EXPECT_EQ(r["pasted"], "#806040, #ff0000, #00ff00, #123456; 3, 1, 1, 1");
  EXPECT_EQ(r["taken"], r["under"].get<std::string>() + ", #ff0000, #00ff00, #123456; 3, 1, 1, 1");
  EXPECT_EQ(r["picture"], "stone_block.png");
  EXPECT_EQ(r["listed"], 3);
  EXPECT_NE(r["unwritten"].get<std::string>().find("not written yet"), std::string::npos) << r["unwritten"];
  EXPECT_EQ(r["block_stays"], "cached");
  EXPECT_EQ(r["same"], true);
  EXPECT_EQ(r["name"], "stone.json");
  EXPECT_EQ(r["notice"], r["expected_notice"]);
  EXPECT_EQ(r["again"], false);
  EXPECT_EQ(r["canceled"], "canceled, 0 of 3 done");
}

// A result for several values, side by side.
TEST_F(StudioPage, ShowsVariantsAndKeepsOne) {
  const auto run =
      test::run_command({"timeout", "200", "node", "variants.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["offered"], nlohmann::json({"seed", "3, 4, 5, 6, 7, 8"}));
  EXPECT_EQ(r["groups"], nlohmann::json({"Graph", "phases", "photo"}));
  EXPECT_EQ(r["different"], 6);
  EXPECT_EQ(r["kept_before"], nlohmann::json::array({"3"}));
  EXPECT_EQ(r["kept_text"], "  seed: {type: int, default: 5}");
  EXPECT_EQ(r["kept_states"], nlohmann::json({"cached", "cached"}));
  for (const char* step : {"same", "undone", "fits"}) EXPECT_EQ(r[step], true) << step;
  EXPECT_EQ(r["tried"], nlohmann::json({"done", "failed", "failed"}));
  EXPECT_NE(r["why"][0].get<std::string>().find("between 2 and 8"), std::string::npos) << r["why"];
  EXPECT_NE(r["refused"].get<std::string>().find("step"), std::string::npos) << r["refused"];
  EXPECT_EQ(r["done_at_previews"], 0);
  EXPECT_EQ(r["canceled"], nlohmann::json({"canceled", "canceled", "canceled"}));
  EXPECT_EQ(r["pictures_left"], 3);
  EXPECT_EQ(r["after_reload"], 3);
  EXPECT_EQ(r["fractions"], "0.1, 0.14, 0.2, 0.28, 0.4");
  EXPECT_EQ(r["text_at_end"], "  seed: {type: int, default: 3}");
}

// What an evaluation does, warnings, a damaged storage of the browser, half a window for the viewer, and
// small windows.
TEST_F(StudioPage, SaysWhatItDoesAndFitsSmallWindows) {
  const auto run =
      test::run_command({"timeout", "200", "node", "status.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_NEAR(r["half"], 0.5, 0.001);
  EXPECT_NEAR(r["kept"], 0.5 - 8 * 20 / 1280.0, 0.002);
  EXPECT_GT(r["missing"][0], 0);
  EXPECT_GT(r["missing"][1], r["missing"][0]);
  EXPECT_NE(r["messages"].get<std::string>().find(r["missing"][1].dump() + " of "), std::string::npos);
  EXPECT_EQ(r["paused"].get<std::string>().rfind("paused, 2 to run", 0), 0u) << r["paused"];
  EXPECT_EQ(r["stale"], "stale");
  EXPECT_EQ(r["times"], nlohmann::json({7, 7}));
  EXPECT_EQ(r["covered"], 0);
  for (const std::string text : r["running"])
    EXPECT_NE(text.find(", 0 of 2 nodes"), std::string::npos) << text;
  EXPECT_EQ(r["queued"], "queued");
  EXPECT_LT(std::stoi(r["bar"].get<std::string>()), 100);
  EXPECT_EQ(r["canceled"], "canceled, 0 of 2 done");
  for (const auto& [view, over] : r["over"].items()) EXPECT_EQ(over, nlohmann::json::array()) << view;
}

// What is wrong is said where one looks, with what can be done.
TEST_F(StudioPage, SaysWhatIsWrong) {
  write_image(folder / "found picture.png", Image(60, 40, 1, 1, Vec3f(0.1f, 0.4f, 0.2f)));
  fs::create_directory(folder / "work");
  const auto run =
      test::run_command({"timeout", "200", "node", "errors.mjs", program, (folder / "work").string(), browser,
                         (folder / "found picture.png").string()},
                        here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_NE(r["trouble"].get<std::string>().find("there is no file"), std::string::npos) << r["trouble"];
  EXPECT_EQ(r["card"].get<std::string>().rfind("There is no file", 0), 0u) << r["card"];
  EXPECT_EQ(r["warned"][0], "1 !");
  EXPECT_NE(r["warned"][1].get<std::string>().find("field of view"), std::string::npos) << r["warned"];
  EXPECT_EQ(r["warned"][2], "rgb(138, 97, 0)");
  EXPECT_EQ(r["text"], "found picture.png");
  EXPECT_EQ(r["beside"], true);
  EXPECT_EQ(r["line"].get<std::string>().rfind("  sheet: {{", 0), 0u) << r["line"];
  EXPECT_NE(r["yaml"], "");
  EXPECT_NE(r["size"].get<std::string>().find("0,05"), std::string::npos) << r["size"];
  EXPECT_EQ(r["can"], false);
}

// A material as one file, and from there to a graph to work on.
TEST_F(StudioPage, SharesAMaterialAndOpensIt) {
  write_image(folder / "photo.png", Image(60, 40, 1, 1, Vec3f(0.1f, 0.4f, 0.2f)));
  const auto run =
      test::run_command({"timeout", "200", "node", "share.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["offered"], "two.zip");
  EXPECT_NE(r["refused"].get<std::string>().find("exists already"), std::string::npos) << r["refused"];
  EXPECT_EQ(r["bundles"], nlohmann::json::array({"Two pictures"}));
  for (const char* step : {"wrote", "same", "again"}) EXPECT_EQ(r[step], true) << step;
  EXPECT_NE(r["text"].get<std::string>().find("path: files/photo.png"), std::string::npos) << r["text"];
  for (const char* word : {"License: CC BY 4.0", "Source: A quarry", "files/photo.png"})
    EXPECT_NE(r["notes"].get<std::string>().find(word), std::string::npos) << r["notes"];
  EXPECT_EQ(r["listed"], nlohmann::json({"granite", "slate", "two"}));
  EXPECT_EQ(r["dropped"], true);
  EXPECT_EQ(r["folder"], "computed");
  EXPECT_NE(r["broken"].get<std::string>().find("is no bundle"), std::string::npos) << r["broken"];
  EXPECT_EQ(r["left"], false);
}

// Values that come from parameters of the graph, and parameters made of values.
TEST_F(StudioPage, MakesParametersOfTheGraph) {
  const auto run = test::run_command(
      {"timeout", "200", "node", "parameters.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["shown"], "3");
  EXPECT_EQ(r["label"], "seed = grain");
  EXPECT_EQ(r["reads"], true);
  EXPECT_EQ(r["made"][0],
            "  width: {type: int, default: 96, doc: Width of the picture, unit: pixels, min: 1, max: 16384}");
  EXPECT_NE(r["made"][1].get<std::string>().find("width: \"${width}\""), std::string::npos) << r["made"];
  EXPECT_EQ(r["own"], "params: {kind: marble, axis: z, width: 96, height: 64, seed: 5}");
  EXPECT_EQ(r["varied"], "photo.height");
}

// Menus of nodes, a search for nodes and commands, keys, and names that other programs have for nodes.
TEST_F(StudioPage, HasTheHabitsOfEditors) {
  const auto run =
      test::run_command({"timeout", "200", "node", "habits.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["entries"], nlohmann::json({"Run to here", "Show variants", "Rename", "Duplicate", "Bypass",
                                          "Make a subgraph", "Remove"}));
  EXPECT_EQ(r["first"], "Run to here");
  EXPECT_EQ(r["found"], nlohmann::json::array({"photo"}));
  EXPECT_GT(r["keys"], 10);
  EXPECT_EQ(r["tab"], "photo");
  EXPECT_EQ(r["right"], "phases");
  EXPECT_EQ(r["left"], nlohmann::json::array({"photo"}));
  EXPECT_EQ(r["stays"], false);
  EXPECT_EQ(r["added"], nlohmann::json({{"usd", "Export"},
                                        {"gltf", "Export"},
                                        {"hsv", "Adjust"},
                                        {"voronoi", "Tessellate"},
                                        {"normal map", "Bake"},
                                        {"xyzzy", ""}}));
  EXPECT_EQ(r["tools"], nlohmann::json({"Split", "Merge", "Merge"}));
}

// A subgraph is edited in its file, becomes nodes of the graph, and is made of nodes.
TEST_F(StudioPage, EditsCopiesAndMakesSubgraphs) {
  const auto run =
      test::run_command({"timeout", "200", "node", "subgraph.mjs", program, folder.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["names"], nlohmann::json({"photo", "sheet", "veins_photo", "phases"}));
  const std::string text = r["text"];
  for (const char* part : {"# kept", "# by gray level", "seed: 4", "images: [photo.image, veins_photo.image]",
                           "outputs: {labels: phases.labels}"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  EXPECT_EQ(r["ran"], nlohmann::json::array());
  EXPECT_EQ(r["says"], "veins.yaml, saved with each change");
  EXPECT_EQ(r["price"].get<std::string>().rfind("3 nodes", 0), 0u) << r["price"];
  EXPECT_EQ(r["vary"], "photo.height");
  EXPECT_EQ(r["tiles"], nlohmann::json({"done", "done"}));
  EXPECT_EQ(r["label"], "seed = seed");
  EXPECT_EQ(r["value"], "4");
  EXPECT_NE(r["grouped"].get<std::string>().find("images: [sources.image, sources.veins_image]"),
            std::string::npos)
      << r["grouped"];
  EXPECT_NE(r["group"].get<std::string>().find(
                "outputs: {image: photo.image, veins_image: veins.image, labels: veins.labels}"),
            std::string::npos)
      << r["group"];
  EXPECT_EQ(r["computed"], 0);
  for (const char* step :
       {"same", "undone", "edited", "beside", "restored", "kept", "past", "equal", "ungrouped"})
    EXPECT_EQ(r[step], true) << step;
}

// Names that can be read, outputs and checks as one card each, a graph that stays where it is, wires, and
// files that are no photographs.
TEST_F(StudioPage, ShowsLegibleGraphs) {
  const auto run = test::run_command({"timeout", "200", "node", "graphs.mjs", program, folder.string(),
                                      browser, test::source_folder().string()},
                                     here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  ASSERT_EQ(r["errors"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  const std::map<std::string, int> seen = {{"1440×900", 14}, {"1024×700", 14}, {"200 %", 9}};
  for (const auto& [size, least] : seen) {
    const auto& shown = r["sizes"][size];
    EXPECT_GE(shown["name"], 11.99) << size;
    EXPECT_EQ(shown["cut"], nlohmann::json::array()) << size;
    EXPECT_EQ(shown["over"], 0) << size;
    EXPECT_GE(shown["seen"], least) << size;
    EXPECT_EQ(shown["folded"], "5 checks, 9 outputs") << size;
    for (const int height : shown["bars"]) EXPECT_LT(height, 44) << size;  // one row
  }
  EXPECT_EQ(r["checks"], nlohmann::json({"compare", "compare_sizes", "observer", "sections", "truth"}));
  EXPECT_EQ(r["keeps_part"], true);
  EXPECT_EQ(r["folded"], 6);
  EXPECT_EQ(r["unfolded"], 9);
  EXPECT_EQ(r["path_in_view"], true);
  EXPECT_EQ(r["inputs"][0], 1);
  EXPECT_GT(r["inputs"][1], 10);
  for (const char* change : {"moved_by_unfolding", "moved_by_folding", "moved_by_adding"})
    EXPECT_EQ(r[change], nlohmann::json::array()) << change;
  EXPECT_EQ(r["overlaps"], 0);
  EXPECT_EQ(r["grows"], false);
  EXPECT_EQ(r["wire"], nlohmann::json::array({"block.shapes.0"}));
  EXPECT_EQ(r["nodes_kept"], true);
  EXPECT_EQ(r["front"], nlohmann::json::array({"sizes"}));
  EXPECT_NE(r["refused"].get<std::string>().find("notes.jpg"), std::string::npos) << r["refused"];
  EXPECT_EQ(r["focused"],
            nlohmann::json::array({"Fold", "nodes", "Choose another picture", "Choose a photograph"}));
  EXPECT_EQ(r["can_create"], 0);
  EXPECT_EQ(r["save_as"], 0);
}

}  // namespace
}  // namespace terrazzo
