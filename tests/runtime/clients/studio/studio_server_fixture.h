// A graph that the Studio serves, on a thread of its own, and the client of its page. Include it last.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/clients/studio/server/studio_server.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

#include <httplib.h>  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo::test {

class StudioServerTest : public ::testing::Test {
 protected:
  StudioServerTest() { write_text_atomically(file, kText); }
  ~StudioServerTest() override {
    if (!thread.joinable()) return;
    server->stop();
    thread.join();
  }
  // Node types are arithmetic. `automatic`: evaluates the graph after each edit.
  void serve(const studio::StudioStart& start, bool automatic) {
    live = std::make_unique<studio::LiveGraph>(arithmetic(), value_types(), SessionOptions{},
                                               studio::Document(file), Overrides{}, automatic);
    server = std::make_unique<studio::StudioServer>(*live, arithmetic(), start);
    port = server->bind(0);
    token = server->address().substr(server->address().find("token=") + 6);
    thread = std::thread([this] { server->serve(); });
  }
  httplib::Client client() const {
    httplib::Client c("127.0.0.1", port);
    c.set_default_headers({{"Cookie", "terrazzo_studio_" + std::to_string(port) + "=" + token}});
    c.set_read_timeout(20);
    return c;
  }

  static inline const std::string kText =
      "terrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 5}}  # kept\n";
  const std::filesystem::path folder = std::filesystem::canonical(temporary_folder()),
                              file = folder / "graph.yaml";
  std::unique_ptr<studio::LiveGraph> live;
  std::unique_ptr<studio::StudioServer> server;
  int port = 0;
  std::string token;
  std::thread thread;
};

}  // namespace terrazzo::test
