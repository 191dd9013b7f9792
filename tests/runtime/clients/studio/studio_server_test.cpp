// The HTTP interface of the Studio, as a page and as others use it.
#include "runtime/clients/studio/server/studio_server.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <sys/socket.h>

#include <atomic>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/clients/studio/views/value_views.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

#include "tests/runtime/clients/studio/studio_server_fixture.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

class Studio : public test::StudioServerTest {
 protected:
  Studio() { serve({}, true); }
  json get(const std::string& path) const { return json::parse(client().Get(path.c_str())->body); }
  int post(const std::string& path, const json& body, json* answer = nullptr) const {
    const auto r = client().Post(path.c_str(), body.dump(), "application/json");
    if (answer) *answer = json::parse(r->body);
    return r->status;
  }
  // The first `count` events of the stream, or those that came within 30 s. Calls `each` after each part of
  // the stream with the number of events so far.
  std::vector<std::string> events(std::size_t count, const httplib::Headers& headers = {},
                                  const std::function<void(std::size_t)>& each = {}) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    std::string text;
    const auto seen = [&] {
      std::vector<std::string> out;
      for (std::size_t at = 0, end; (end = text.find("\n\n", at)) != std::string::npos; at = end + 2)
        if (text.compare(at, 1, ":") != 0) out.push_back(text.substr(at, end - at));
      return out;
    };
    client().Get("/api/events", headers, [&](const char* data, std::size_t n) {
      text.append(data, n);
      const std::size_t now = seen().size();
      if (each) each(now);
      return now < count && std::chrono::steady_clock::now() < end;
    });
    auto out = seen();
    out.resize(std::min(count, out.size()));
    return out;
  }
};

const json kSet = {{"edits", {{{"op", "set"}, {"node", "a"}, {"name", "value"}, {"value", "6"}}}}};

TEST_F(Studio, EditsUndoesAndSaves) {
  EXPECT_EQ(get("/api/types").size(), test::arithmetic().all().size());
  EXPECT_EQ(post("/api/edit", kSet), 200);
  json s = get("/api/state");
  EXPECT_EQ(s["document"]["text"],
            "terrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 6}}  # kept\n");
  EXPECT_FALSE(s["document"]["saved"]);
  EXPECT_EQ(post("/api/undo", {}), 200);
  json answer;
  EXPECT_EQ(post("/api/undo", {}, &answer), 400);
  EXPECT_EQ(answer["code"], "nothing-to-undo");
  EXPECT_EQ(post("/api/redo", {}), 200);
  EXPECT_EQ(post("/api/save", json::object()), 200);
  EXPECT_EQ(*read_file(file), s["document"]["text"]);
  EXPECT_EQ(post("/api/text", {{"text", "terrazzo: 1\nnodes: {b: {type: Constant}}\n"}}), 200);
  EXPECT_EQ(get("/api/state")["document"]["nodes"][0]["name"], "b");
}

TEST_F(Studio, ValuesHaveAnETag) {
  json s = get("/api/state");
  for (int k = 0; k < 500 && s["nodes"]["a"]["outputs"].empty(); ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    s = get("/api/state");
  }
  const std::string path =
      "/api/value/" + s["nodes"]["a"]["outputs"]["out"]["hash"].get<std::string>() + "?as=json";
  const auto first = client().Get(path.c_str());
  EXPECT_EQ(json::parse(first->body)["rows"], json::parse("[[5.0]]"));
  EXPECT_EQ(first->get_header_value_count("Cache-Control"), 1u);
  const auto again = client().Get(path.c_str(), {{"If-None-Match", first->get_header_value("ETag")}});
  EXPECT_EQ(again->status, 304);
  const auto wrong = client().Get((path.substr(0, path.find('?')) + "?as=pixels").c_str());
  EXPECT_EQ(wrong->status, 400);
  EXPECT_EQ(wrong->get_header_value("Cache-Control"), "no-store");
  for (const char* number : {"azimuth=1e308", "azimuth=-361", "azimuth=5e-324x", "lo=1e300", "hi=-1e300",
                             "hi=nan", "most=99999999999", "axis=-1", "section=1e5"})
    EXPECT_EQ(client().Get((path + "&" + number).c_str())->status, 400) << number;
  EXPECT_EQ(client().Get("/api/value/0123456789abcdef?as=json")->status, 400);
}

// Compressing takes much longer than sending to this machine.
TEST_F(Studio, NothingIsCompressedOnTheWay) {
  for (const char* path : {"/", "/events.js", "/api/types", "/api/state"}) {
    const auto r = client().Get(path, {{"Accept-Encoding", "gzip, deflate, br"}});
    EXPECT_EQ(r->status, 200) << path;
    EXPECT_FALSE(r->has_header("Content-Encoding")) << path << " " << r->get_header_value("Content-Encoding");
  }
}

TEST_F(Studio, PreviewsAreServedUntilTheyAreReplaced) {
  EXPECT_EQ(
      post("/api/text", {{"text", "terrazzo: 1\nnodes: {a: {type: Sketch, params: {value: 8, wait: 1}}}\n"}}),
      200);
  json s = get("/api/state");
  for (int k = 0; k < 500 && s["nodes"]["a"]["previews"].empty(); ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    s = get("/api/state");
  }
  const std::string path =
      "/api/preview/" + std::to_string(s["nodes"]["a"]["previews"]["out"]["number"].get<int>());
  const auto r = client().Get((path + "?as=json").c_str());
  ASSERT_EQ(r->status, 200);
  EXPECT_EQ(json::parse(r->body)["rows"], json::parse("[[4.0]]"));
  EXPECT_EQ(r->get_header_value("Cache-Control"), "no-store");
  EXPECT_EQ(client().Get((path + "?as=pixels").c_str())->status, 400);
  EXPECT_EQ(client().Get("/api/preview/999?as=json")->status, 204);
  EXPECT_EQ(client().Get("/api/preview/9999999999999999999999?as=json")->status, 404);
}

TEST_F(Studio, TheStreamStartsWithTheStateAndResumes) {
  const auto first = events(1);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_NE(first[0].find("event: state\n"), std::string::npos);
  const std::string number = std::to_string(live->events().last());
  EXPECT_EQ(post("/api/edit", kSet), 200);
  const auto more = events(1, {{"Last-Event-ID", number}});
  ASSERT_EQ(more.size(), 1u);
  EXPECT_EQ(more[0].rfind("id: " + std::to_string(std::stoull(number) + 1) + "\n", 0), 0u)
      << more[0].substr(0, 60);
  EXPECT_NE(events(1, {{"Last-Event-ID", "99999999"}})[0].find("event: state\n"), std::string::npos);
}

TEST_F(Studio, TwelveClientsSeeAnEdit) {
  std::atomic<int> started{0}, seen{0};
  std::vector<std::thread> all;
  for (int k = 0; k < 12; ++k)
    all.emplace_back([&] {
      bool first = true;
      const auto got = events(2, {}, [&](std::size_t n) { started += n > 0 && std::exchange(first, false); });
      seen += got.size() == 2;
    });
  // A client that starts after the edit gets it with the state and no event of its own.
  for (int k = 0; k < 2000 && started < 12; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(started, 12);
  EXPECT_EQ(post("/api/edit", kSet), 200);
  for (auto& t : all) t.join();
  EXPECT_EQ(seen, 12);
  // Clients that left hold no stream, once the server has noticed.
  for (int k = 0, tries = 0; k < 100 && tries < 1000; ++tries) {
    if (!events(1).empty())
      ++k;
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_LT(tries, 999) << k;
  }
}

// Some clients open a stream and never read it. The server still answers all others.
TEST_F(Studio, ClientsThatDoNotReadStopNobody) {
  std::vector<int> slow;
  const std::string ask = "GET /api/events HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: terrazzo_studio_" +
                          std::to_string(port) + "=" + token + "\r\n\r\n";
  for (int k = 0; k < 8; ++k) {
    const int s = ::socket(AF_INET, SOCK_STREAM, 0), small = 4096;
    ::setsockopt(s, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(::connect(s, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    ASSERT_EQ(::send(s, ask.data(), ask.size(), MSG_NOSIGNAL), static_cast<ssize_t>(ask.size()));
    slow.push_back(s);
  }
  const std::string large =
      "terrazzo: 1\ndoc: " + std::string(400'000, 'x') + "\nnodes:\n  a: {type: Constant, params: {value: ";
  for (int k = 0; k < 30; ++k)
    ASSERT_EQ(post("/api/text", {{"text", large + std::to_string(k) + "}}\n"}}), 200);
  const auto got = events(1);
  ASSERT_EQ(got.size(), 1u);
  EXPECT_NE(got[0].find("value: 29"), std::string::npos);
  for (const int s : slow) ::close(s);
}

TEST_F(Studio, StrangersGetNothing) {
  const auto status = [&](const httplib::Headers& headers, const char* path = "/api/state") {
    return client().Get(path, headers)->status;
  };
  const std::string here = "127.0.0.1:" + std::to_string(port);
  EXPECT_EQ(status({{"Host", "127.0.0.1:1"}}), 200);  // a forwarded port
  EXPECT_EQ(status({{"Origin", "http://" + here}}), 200);
  EXPECT_EQ(status({{"Origin", "http://127.0.0.1:1"}}), 403);
  EXPECT_EQ(status({{"Host", "evil.example"}, {"Origin", "http://evil.example"}}), 403);  // rebinding
  EXPECT_EQ(status({{"Host", "127.0.0.1.evil.example"}}), 403);
  EXPECT_EQ(status({{"Host", "localhost:80x"}}), 403);
  EXPECT_EQ(status({{"Sec-Fetch-Site", "cross-site"}}), 403);
  const httplib::Headers opened = {
      {"Sec-Fetch-Site", "cross-site"}, {"Sec-Fetch-Mode", "navigate"}, {"Sec-Fetch-Dest", "document"}};
  EXPECT_EQ(status(opened, "/"), 200);  // a link in a mail
  EXPECT_EQ(status(opened), 403);
  httplib::Client stranger("127.0.0.1", port);
  for (const char* path :
       {"/", "/studio.js", "/api/state", "/api/types", "/api/events", "/api/value/0123456789ab"})
    EXPECT_EQ(stranger.Get(path)->status, 403) << path;
  EXPECT_EQ(client().Post("/api/save", "{}", "text/plain")->status, 400);
  EXPECT_EQ(client().Post("/api/text", std::string(20 << 20, ' '), "application/json")->status, 413);
  EXPECT_EQ(post("/api/edit", {{"edits", {{{"op", "format"}}}}}), 400);
  EXPECT_EQ(post("/api/edit", json::array()), 400);
  EXPECT_EQ(client().Get("/../../etc/passwd")->status, 404);
}

TEST_F(Studio, TellsThePriceOfAnEditAndDoesNotMakeIt) {
  json answer;
  ASSERT_EQ(post("/api/price", kSet, &answer), 200);
  ASSERT_EQ(answer["nodes"].size(), 1u);
  EXPECT_EQ(answer["nodes"][0]["path"], "a");
  EXPECT_EQ(get("/api/state")["document"]["can_undo"], false);
  EXPECT_EQ(post("/api/price", {{"edits", {{{"op", "explode"}}}}}), 400);
  EXPECT_EQ(post("/api/price", {{"edits", {{{"op", "remove"}, {"node", "x"}}}}}), 400);
}

TEST_F(Studio, DeepJsonIsRefused) {
  const std::string deep(1'000'000, '[');
  std::string objects;
  for (int k = 0; k < 1'000'000; ++k) objects += "{\"a\":";
  for (const std::string& body :
       {deep, objects,
        "{\"edits\": [{\"op\": \"set\", \"node\": \"a\", \"param\": \"value\", \"value\": " + deep +
            std::string(deep.size(), ']') + "}]}"}) {
    const auto r = client().Post("/api/edit", body, "application/json");
    ASSERT_TRUE(r);
    EXPECT_EQ(r->status, 400);
    EXPECT_NE(r->body.find("nested more than 100 deep"), std::string::npos) << r->body;
  }
  const auto bad = client().Post("/api/edit", "{\"edits\": 5", "application/json");
  EXPECT_EQ(bad->body.find("json.exception"), std::string::npos) << bad->body;
  EXPECT_EQ(get("/api/state")["document"]["saved"], true);
}

TEST_F(Studio, KeepsWhereNodesAreBesideTheGraph) {
  const json mine = {
      {"places", {{"a", {10, 20}}}},
      {"notes", {{{"x", 1}, {"y", 2}, {"width", 30}, {"height", 40}, {"text", "why"}, {"frame", false}}}}};
  ASSERT_EQ(post("/api/arrange", {{"arrangement", mine}}), 200);
  const fs::path beside = file.parent_path() / "graph.yaml.studio.json";
  EXPECT_EQ(json::parse(*read_file(beside)), mine);
  EXPECT_EQ(get("/api/state")["document"]["arrangement"], mine);
  EXPECT_EQ(get("/api/state")["document"]["saved"], true);  // it is no part of the graph
  for (const json& bad :
       {json{{"places", {{"a", "left"}}}}, json{{"scripts", json::array()}}, json{{"notes", {{{"x", 1}}}}}})
    EXPECT_EQ(post("/api/arrange", {{"arrangement", bad}}), 400) << bad;
  ASSERT_EQ(post("/api/arrange", {{"arrangement", {{"places", json::object()}}}}), 200);
  EXPECT_FALSE(fs::exists(beside));
  write_text_atomically(beside, "{\"places\": {\"a\": [\"<script>\", 1]}}");  // a stranger's file
  ASSERT_EQ(post("/api/edit", kSet), 200);
  EXPECT_EQ(get("/api/state")["document"]["arrangement"], json::object());
  EXPECT_EQ(post("/api/arrange", {{"arrangement", mine}}), 400);  // it is not replaced
}

TEST_F(Studio, SendsOnlyFilesThatTheGraphWrites) {
  const fs::path out = fs::absolute("out") / "studio_test_file.json";
  ASSERT_EQ(post("/api/text",
                 {{"text",
                   kText + "  w: {type: Write, inputs: {in: a}, params: {path: studio_test_file.json}}\n"}}),
            200);
  EXPECT_EQ(client().Get("/api/output?path=studio_test_file.json")->status, 400);
  EXPECT_EQ(get("/api/outputs"), json({{"folder", out.parent_path().string()},
                                       {"files", {{{"node", "w"}, {"path", "studio_test_file.json"}}}}}));
  write_text_atomically(out, "5");
  EXPECT_EQ(get("/api/outputs")["files"][0]["bytes"], 1);
  EXPECT_EQ(client().Get("/api/output?path=studio_test_file.json")->body, "5");
  for (const char* path : {"other.json", "../graph.yaml", "/etc/passwd", ""})
    EXPECT_EQ(client().Get("/api/output?path=" + std::string(path))->status, 400) << path;
  fs::remove(out);
  fs::create_symlink(file, out);  // a link out of the folder
  EXPECT_EQ(client().Get("/api/output?path=studio_test_file.json")->status, 400);
  fs::remove(out);
}

TEST_F(Studio, ListsFilesBelowTheGraphsFolder) {
  fs::create_directories(file.parent_path() / "pictures");
  write_text_atomically(file.parent_path() / "pictures/a.png", "");
  write_text_atomically(file.parent_path() / ".hidden", "");
  EXPECT_EQ(get("/api/files"), json({{"files", {"graph.yaml", "pictures/a.png"}}, {"more", false}}));
}

}  // namespace
}  // namespace terrazzo
