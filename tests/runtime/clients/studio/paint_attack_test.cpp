// Attacks on `terrazzo paint` by other users of the machine or by a broken page.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <iterator>
#include <thread>

#include "nodes/common/io/image_file.h"
#include "runtime/files.h"
#include "tests/runtime/clients/studio/paint_picture.h"
#include "tests/runtime/clients/studio/paint_process.h"
#include "tests/support/program.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::PaintProcess;

class PaintAttack : public ::testing::Test {
 protected:
  const fs::path folder = test::temporary_folder();
};

bool is(const std::string& answer, int status) {
  return answer.starts_with("HTTP/1.1 " + std::to_string(status) + " ");
}

// Connections that never complete their request, but send a byte now and then: 32, as one browser could open,
// and 150, more than there are threads.
TEST_F(PaintAttack, SlowConnectionsDoNotStopThePage) {
  const PaintProcess p({test::paint_picture().string()}, folder);
  for (const std::size_t count : {32u, 150u}) {
    std::vector<int> slow;
    for (std::size_t k = 0; k < count; ++k) {
      slow.push_back(p.connect());
      test::send_all(slow.back(), "GET / HTTP/1.1\r\nHost: ");
    }
    std::atomic<bool> done{false};
    std::thread drip([&] {
      while (!done) {
        for (const int s : slow) ::send(s, "x", 1, MSG_NOSIGNAL | MSG_DONTWAIT);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
    });
    EXPECT_TRUE(is(p.ask(p.head("GET", "/api/state")), 200)) << count;
    EXPECT_TRUE(is(p.post("/api/nib", R"({"region": [2, 2, 40, 60]})"), 200)) << count;
    done = true;
    drip.join();
    for (const int s : slow) ::close(s);
  }
}

// The deadline applies to the whole request: sending a byte now and then does not extend it.
TEST_F(PaintAttack, ASlowRequestIsEnded) {
  const PaintProcess p({test::paint_picture().string()}, folder);
  const int s = p.connect();
  test::send_all(
      s, p.head("POST", "/api/undo", "Content-Type: application/json\r\nContent-Length: 1000000\r\n"));
  int sent = 0;
  for (struct pollfd closed = {s, POLLIN, 0}; sent < 300 && ::poll(&closed, 1, 100) == 0; ++sent)
    ::send(s, " ", 1, MSG_NOSIGNAL);
  EXPECT_LT(sent, 300);
  ::close(s);
}

TEST_F(PaintAttack, EncodedBodiesAreRefusedUnread) {
  const PaintProcess p({test::paint_picture().string()}, folder);
  const auto bomb = test::run_command({"sh", "-c", "head -c 400000000 /dev/zero | gzip -9"}).out;
  ASSERT_LT(bomb.size(), 1u << 20);
  const std::string json = "Content-Type: application/json\r\n";
  EXPECT_TRUE(is(p.ask(p.head("GET", "/api/state")), 200));
  const long before = p.peak_memory();
  EXPECT_TRUE(is(p.ask(p.head("POST", "/api/stroke",
                              json + "Content-Encoding: gzip\r\nContent-Length: " +
                                  std::to_string(bomb.size()) + "\r\n") +
                       bomb),
                 415));
  const auto endless = [&](const std::string& start, const std::string& piece) {
    const int s = p.connect();
    test::send_all(s, start);
    std::thread sender([&] {
      for (std::size_t sent = 0; sent < 64u << 20; sent += piece.size()) test::send_all(s, piece);
      ::shutdown(s, SHUT_WR);
    });
    const std::string answer = test::receive_all(s);
    ::shutdown(s, SHUT_RDWR);
    sender.join();
    ::close(s);
    return answer;
  };
  const std::string megabyte(1 << 20, ' ');
  EXPECT_TRUE(is(endless(p.head("POST", "/api/stroke", json + "Transfer-Encoding: chunked\r\n"),
                         "100000\r\n" + megabyte + "\r\n"),
                 415));
  EXPECT_TRUE(
      is(endless(p.head("POST", "/api/stroke", json + "Content-Length: 67108864\r\n"), megabyte), 413));
  endless("GET /", std::string(1 << 20, 'x'));                      // an endless line
  endless("GET / HTTP/1.1\r\n", "X-Header: 0123456789abcdef\r\n");  // endless headers
  EXPECT_LT(p.peak_memory(), before + 24 * 1024);
  EXPECT_TRUE(is(p.ask(p.head("GET", "/api/state")), 200));
}

// One stroke across a large picture takes minutes.
TEST_F(PaintAttack, ASignalEndsALongStroke) {
  Image large(2000, 2000, 1, 1);
  for (int y = 0; y < large.height; ++y)
    for (int x = 0; x < large.width; ++x)
      large.at(x, y) = (x / 3 + y / 5) % 3 ? Vec3f(0.7f, 0.5f, 0.2f) : Vec3f(0.1f, 0.2f, 0.3f);
  const fs::path file = folder / "large.png";
  write_image(file, large);
  for (const int signal : {SIGTERM, SIGINT})
    for (const bool waits : {true, false}) {  // until the stroke is painted
      PaintProcess p({file.string()}, folder);
      ASSERT_TRUE(is(p.post("/api/nib", R"({"region": [2, 2, 200, 200]})"), 200));
      const std::string stroke =
          R"({"begin": true, "radius": 600, "points": [[100, 700], [1900, 800], [100, 1300]], "budget": )" +
          std::string(waits ? "60000}" : "0}");
      const int s = p.connect();
      test::send_all(s, p.head("POST", "/api/stroke",
                               "Content-Type: application/json\r\nContent-Length: " +
                                   std::to_string(stroke.size()) + "\r\n") +
                            stroke);
      struct pollfd answered = {s, POLLIN, 0};
      ASSERT_EQ(::poll(&answered, 1, waits ? 1000 : 60000), waits ? 0 : 1) << "the stroke was short";
      EXPECT_EQ(p.end(signal), 0);
      ::close(s);
    }
}

// A session does not replace what an earlier session saved.
TEST_F(PaintAttack, SessionsSaveSideBySide) {
  const fs::path image = test::paint_picture();
  const std::string stem = image.stem().string() + "_painted";
  std::vector<std::string> texts;
  for (int k = 0; k < 2; ++k) {
    PaintProcess p({image.string()}, folder);
    p.post("/api/nib", R"({"region": [2, 2, 40, 60]})");
    p.post("/api/stroke", R"({"begin": true, "end": true, "radius": 5, "points": [[)" +
                              std::to_string(20 + 20 * k) + ", 40]]}");
    EXPECT_TRUE(is(p.post("/api/save", "{}"), 200));
    EXPECT_EQ(p.end(SIGINT), 0);
  }
  const auto first = read_file(folder / (stem + ".yaml")), second = read_file(folder / (stem + "_2.yaml"));
  ASSERT_TRUE(first && second);
  EXPECT_NE(first->find("strokes_1"), std::string::npos);
  EXPECT_NE(*first, *second);
  test::ProgramOptions here;
  here.folder = folder;
  const auto again = test::run_command({"timeout", "20", (test::build_folder() / "terrazzo").string(),
                                        "paint", image.string(), "--save", stem + ".yaml"},
                                       here);
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("--overwrite"), std::string::npos) << again.err;
  EXPECT_EQ(read_file(folder / (stem + ".yaml")), first);
}

// An image whose painting could not be saved is refused from the start.
TEST_F(PaintAttack, APictureThatNoGraphCanNameIsRefused) {
  const fs::path image = folder / "caf\xe9.png";
  fs::copy(test::paint_picture(), image);
  test::ProgramOptions here;
  here.folder = folder;
  const auto r = test::run_command(
      {"timeout", "20", (test::build_folder() / "terrazzo").string(), "paint", image.string()}, here);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("is not UTF-8"), std::string::npos) << r.err;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

}  // namespace
}  // namespace terrazzo
