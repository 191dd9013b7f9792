#include "runtime/clients/studio/paint/paint_server.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/clients/studio/live/save_file.h"
#include "runtime/clients/studio/paint/painting.h"
#include "tests/runtime/clients/studio/paint_picture.h"
#include "tests/support/code_of.h"

#include <httplib.h>  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

class Paint : public ::testing::Test {
 protected:
  Paint() : port(server.bind(0)), thread([this] { server.serve(); }), client("127.0.0.1", port) {
    const std::string address = server.address();
    token = address.substr(address.find('=') + 1);
    client.set_default_headers({{"Cookie", "terrazzo_paint_" + std::to_string(port) + "=" + token}});
  }
  ~Paint() override {
    server.stop();
    thread.join();
  }

  json post(const std::string& path, const json& body, int status = 200) {
    const auto r = client.Post(path.c_str(), body.dump(), "application/json");
    EXPECT_TRUE(r);
    EXPECT_EQ(r->status, status) << r->body;
    return json::parse(r->body);
  }
  int status_with(const httplib::Headers& headers, const std::string& path = "/api/state") {
    const auto r = client.Get(path.c_str(), headers);
    return r ? r->status : 0;
  }
  std::string code_of_post(const std::string& path, const json& body) {
    return post(path, body, 400).at("code");
  }

  studio::Painting painting{test::paint_picture()};
  const fs::path saved = test::temporary_folder() / "saved.yaml";
  studio::SaveFile save_file = studio::SaveFile::exactly(saved, false);
  studio::PaintServer server{painting, save_file};
  int port;
  std::string token;
  std::thread thread;
  httplib::Client client;
};

TEST_F(Paint, PaintsUndoesAndSaves) {
  const json before = json::parse(client.Get("/api/state")->body);
  EXPECT_EQ(before["width"], 96);
  EXPECT_TRUE(before["nib"].is_null());
  const std::string picture = client.Get("/api/view?kind=picture")->body;
  EXPECT_EQ(picture.size(), 96u * 80 * 4);
  post("/api/nib", {{"region", {2, 2, 40, 60}}});
  const json stroke = post(
      "/api/stroke",
      {{"begin", true}, {"end", true}, {"radius", 8}, {"points", {{60, 40}, {62, 44}}}, {"budget", 60000}});
  EXPECT_EQ(stroke["pending"], 0);
  EXPECT_EQ(stroke["rectangle"], json({52, 32, 70, 52}));
  EXPECT_EQ(stroke["strokes"], 1);
  EXPECT_EQ(stroke["pixels"].get<std::string>().size(), (18u * 20 * 4 + 2) / 3 * 4);
  EXPECT_NE(client.Get("/api/view?kind=picture")->body, picture);
  for (const char* kind : {"base_relative", "occupancy"})
    EXPECT_EQ(client.Get(("/api/view?kind=" + std::string(kind)).c_str())->body.size(), picture.size());
  const json written = post("/api/save", json::object());
  std::ifstream in(saved);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), written["graph"]);
  post("/api/undo", json::object());
  EXPECT_EQ(client.Get("/api/view?kind=picture")->body, picture);
}

// A stroke with a nib as large as the picture, whose dabs take longer than a frame.
json large_stroke(double budget) {
  json points = json::array();
  for (int i = 0; i < 40; ++i) points.push_back({30 + i, 40});
  return {{"begin", true}, {"end", true}, {"radius", 40}, {"points", points}, {"budget", budget}};
}

TEST_F(Paint, AnswersBeforeALargeNibIsDone) {
  post("/api/nib", {{"region", {2, 2, 40, 60}}});
  const std::string picture = client.Get("/api/view?kind=picture")->body;
  const json first = post("/api/stroke", large_stroke(0));
  EXPECT_GT(first["pending"], 0);
  EXPECT_EQ(first["strokes"], 0);
  EXPECT_EQ(first["rectangle"], json({0, 0, 96, 80}));  // drafts of all points
  EXPECT_EQ(first["pixels"].get<std::string>().size(), (96u * 80 * 4 + 2) / 3 * 4);
  json last = first;
  while (last["pending"] > 0) last = post("/api/stroke", {{"budget", 1000}});
  const json state = json::parse(client.Get("/api/state")->body);
  EXPECT_EQ(state["strokes"], 1);

  // The same bits as without a queue.
  studio::Painting direct{test::paint_picture()};
  studio::NibOptions choice;
  choice.region = {2, 2, 40, 60};
  direct.choose(choice);
  direct.begin_stroke(40);
  for (int i = 0; i < 40; ++i) direct.extend_stroke(Vec2(30 + i, 40));
  direct.end_stroke();
  EXPECT_EQ(state["content"], direct.content());
  EXPECT_NE(client.Get("/api/view?kind=picture")->body, picture);
}

TEST_F(Paint, UndoesWhatIsNotPaintedYet) {
  post("/api/nib", {{"region", {2, 2, 40, 60}}});
  const json small = {
      {"begin", true}, {"end", true}, {"radius", 8}, {"points", {{60, 40}}}, {"budget", 60000}};
  EXPECT_EQ(post("/api/stroke", small)["strokes"], 1);
  const json before = json::parse(client.Get("/api/state")->body);
  // In work: interrupted. The stroke after it, still queued: dropped.
  EXPECT_GT(post("/api/stroke", large_stroke(0))["pending"], 0);
  EXPECT_EQ(post("/api/undo", json::object())["content"], before["content"]);
  EXPECT_EQ(post("/api/stroke", small)["strokes"], 2);
  const json two = json::parse(client.Get("/api/state")->body);
  EXPECT_NE(two["content"], before["content"]);
  json longer = large_stroke(0), later = small;
  longer["points"].erase(longer["points"].begin() + 3, longer["points"].end());
  later["budget"] = 0;
  post("/api/stroke", longer);
  EXPECT_GT(post("/api/stroke", later)["pending"], 1);
  EXPECT_EQ(post("/api/undo", json::object())["strokes"], 3);
  EXPECT_EQ(post("/api/undo", json::object())["content"], two["content"]);
  EXPECT_EQ(post("/api/stroke", {{"budget", 0}})["pending"], 0);
}

TEST_F(Paint, TellsOfAStrokeThatCannotGoOn) {
  post("/api/nib", {{"region", {2, 2, 40, 60}}});
  EXPECT_EQ(code_of_post("/api/stroke", {{"points", {{60, 40}}}}), "no-stroke");
  EXPECT_EQ(code_of_post("/api/stroke", {{"begin", true}, {"radius", 8}, {"budget", -1}}), "bad-request");
  EXPECT_EQ(code_of_post("/api/stroke", {{"points", 3}}), "bad-stroke");
}

TEST_F(Paint, ServesThePageAndNothingElse) {
  for (const char* path : {"/", "/paint.js", "/paint.css"}) {
    const auto r = client.Get(path);
    EXPECT_EQ(r->status, 200) << path;
    EXPECT_GT(r->body.size(), 500u);
    EXPECT_NE(r->get_header_value("Content-Security-Policy"), "");
  }
  for (const char* path : {"/paint.html", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
                           "/api", "/etc/passwd"})
    EXPECT_EQ(client.Get(path)->status, 404) << path;
  EXPECT_EQ(json::parse(client.Get("/api/view?kind=/etc/passwd")->body)["code"], "bad-request");
}

TEST_F(Paint, AnswersItsOwnPageAlone) {
  const std::string here = "127.0.0.1:" + std::to_string(port);
  EXPECT_EQ(status_with({}), 200);
  EXPECT_EQ(status_with({{"Origin", "http://" + here}}), 200);
  EXPECT_EQ(status_with({{"Host", "localhost:" + std::to_string(port)}}), 200);
  EXPECT_EQ(status_with({{"Origin", "http://" + here}, {"Sec-Fetch-Site", "same-origin"}}), 200);
  for (const std::string origin : {"http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1"})
    EXPECT_EQ(status_with({{"Origin", origin}}), 403) << origin;
  EXPECT_EQ(status_with({{"Origin", "http://" + here + ".evil.example"}}), 403);
  EXPECT_EQ(status_with({{"Host", "evil.example:" + std::to_string(port)}}), 403);
  EXPECT_EQ(status_with({{"Host", "evil.example"}}, "/"), 403);
  EXPECT_EQ(status_with({{"Sec-Fetch-Site", "cross-site"}}), 403);
  EXPECT_EQ(status_with({{"Sec-Fetch-Site", "same-site"}}), 403);
  // A form on another page can send this without a CORS preflight request.
  EXPECT_EQ(client.Post("/api/undo", "{}", "text/plain")->status, 400);
}

TEST_F(Paint, AnswersNothingWithoutTheToken) {
  const std::string cookie = "terrazzo_paint_" + std::to_string(port) + "=", other(token.size(), '0');
  httplib::Client stranger("127.0.0.1", port);
  const auto status = [&](const std::string& path, const httplib::Headers& headers = {}) {
    const auto r = stranger.Get(path.c_str(), headers);
    return r ? r->status : 0;
  };
  for (const std::string path : {"/", "/paint.js", "/api/state", "/api/view?kind=picture", "/nothing"})
    EXPECT_EQ(status(path), 403) << path;
  EXPECT_EQ(stranger.Post("/api/save", "{}", "application/json")->status, 403);
  EXPECT_EQ(status("/?token=" + other), 403);
  EXPECT_EQ(status("/?token=" + token.substr(1)), 403);
  EXPECT_EQ(status("/", {{"Cookie", cookie + other}}), 403);
  EXPECT_EQ(status("/", {{"Cookie", cookie + token + "0"}}), 403);
  EXPECT_EQ(status("/", {{"Cookie", "x" + cookie + token}}), 403);
  EXPECT_EQ(status("/", {{"Cookie", "a=b; " + cookie + token + "; c=d"}}), 200);
  EXPECT_EQ(status("/api/state?token=" + token), 200);
  const auto page = stranger.Get(("/?token=" + token).c_str());
  EXPECT_EQ(page->status, 200);
  EXPECT_EQ(page->get_header_value("Set-Cookie"), cookie + token + "; Path=/; HttpOnly; SameSite=Strict");
  EXPECT_EQ(token.size(), 32u);
  studio::PaintServer second(painting, save_file);
  EXPECT_EQ(second.address().find(token), std::string::npos);
}

TEST_F(Paint, RefusesMalformedRequests) {
  EXPECT_EQ(code_of_post("/api/stroke", {{"begin", true}, {"radius", 5}, {"points", {{5, 5}}}}), "no-nib");
  EXPECT_EQ(code_of_post("/api/nib", {{"region", {0, 0, 2, 2}}}), "too-small");
  EXPECT_EQ(code_of_post("/api/nib", {{"region", {0, 0, 500, 20}}}), "outside-image");
  EXPECT_EQ(code_of_post("/api/nib", {{"region", "all"}}), "bad-request");
  EXPECT_EQ(code_of_post("/api/nib", json::object()), "bad-request");
  EXPECT_EQ(code_of_post("/api/nib", {{"region", {2, 2, 40, 60}}, {"finish", "gloss"}}), "bad-value");
  EXPECT_EQ(code_of_post("/api/undo", json::object()), "nothing-to-undo");
  post("/api/nib", {{"region", {2, 2, 40, 60}}});
  EXPECT_EQ(code_of_post("/api/stroke", {{"begin", true}, {"radius", 500}, {"points", json::array()}}),
            "nib-too-large");
  EXPECT_EQ(code_of_post("/api/stroke", {{"begin", true}, {"radius", 5}, {"points", {{1, 2, 3}}}}),
            "bad-stroke");
  EXPECT_EQ(code_of_post("/api/stroke",
                         {{"begin", true}, {"radius", 5}, {"points", json::array({json::array({"a", 2})})}}),
            "bad-request");
  EXPECT_EQ(code_of_post("/api/stroke", {{"begin", true}, {"radius", 5}, {"points", {{1e30, 2}}}}),
            "bad-stroke");
  EXPECT_EQ(client.Post("/api/stroke", "{", "application/json")->status, 400);
  EXPECT_EQ(client.Post("/api/stroke", std::string(2 << 20, ' '), "application/json")->status, 413);
  studio::PaintServer second(painting, save_file);
  EXPECT_EQ(test::code_of([&] { second.bind(port); }), "port-in-use");
}

// stop() also works before the server listens.
TEST(PaintServer, StopsBeforeItServes) {
  studio::Painting painting{test::paint_picture()};
  auto save_file = studio::SaveFile::numbered(test::temporary_folder() / "saved.yaml");
  studio::PaintServer server{painting, save_file};
  server.bind(0);
  server.stop();
  server.serve();
}

}  // namespace
}  // namespace terrazzo
