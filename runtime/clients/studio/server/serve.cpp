#include "runtime/clients/studio/server/serve.h"

#include <chrono>
#include <thread>

namespace terrazzo::studio {

void serve_until(const std::atomic<bool>& cancel, const std::function<void()>& serve,
                 const std::function<void()>& stop) {
  std::atomic<bool> ended{false};
  std::thread watch([&] {
    while (!ended && !cancel) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    stop();
  });
  // A destructor, so that the thread is also joined if serve() throws. Otherwise the program would abort.
  const struct Joined {
    std::atomic<bool>& ended;
    std::thread& watch;
    ~Joined() {
      ended = true;
      watch.join();
    }
  } joined{ended, watch};
  serve();
}

}  // namespace terrazzo::studio
