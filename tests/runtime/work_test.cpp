#include "runtime/work.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <chrono>
#include <thread>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

TEST(Work, ALoopWithinAFailedOneNeverReturnsHalfDone) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 4);
  int entered = 0;
  for (int repeat = 0; repeat < 20; ++repeat) {
    std::atomic<bool> failing{false};
    std::atomic<int> silent{0}, inner{0};
    const Work work;
    const auto wait_for = [](const auto& condition) {
      for (int ms = 0; ms < 1000 && !condition(); ++ms)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    const auto body = [&](std::size_t i, std::size_t) {
      if (i == 0) {
        wait_for([&] { return inner > 0; });
        failing = true;
        throw Error("test", "the first range fails");
      }
      ++inner;
      wait_for([&] { return failing.load(); });
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      std::atomic<int> ran{0};
      work.parallel(200, 1, [&](std::size_t, std::size_t) { ++ran; });
      if (ran != 200) ++silent;
    };
    EXPECT_THROW(work.parallel(8, 1, body), std::exception);
    EXPECT_EQ(silent, 0);
    entered += inner;
  }
  if (entered == 0) GTEST_SKIP() << "no second thread took part";
}

TEST(Work, ReductionsKeepTheirOrder) {
  const auto sum = [](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    return Work().reduce<double>(
        10000, 7, 0.0,
        [](std::size_t b, std::size_t e) {
          double s = 0;
          for (std::size_t i = b; i < e; ++i) s += 1.0 / static_cast<double>(3 * i + 1);
          return s;
        },
        [](double a, double b) { return a + b; });
  };
  EXPECT_EQ(sum(1), sum(2));
  EXPECT_EQ(sum(1), sum(7));
}

TEST(Work, PartsShareTheProgress) {
  std::vector<double> seen;
  const Work::Report report = [&](double f, const std::string&) { seen.push_back(f); };
  const Work work(nullptr, &report);
  work.part(0.5, 1).progress(0.5);
  work.part(0, 0.5).part(0.5, 1).progress(1);
  EXPECT_EQ(seen, (std::vector<double>{0.75, 0.5}));
}

TEST(Work, EitherFlagStopsIt) {
  std::atomic<bool> one{false}, other{false};
  const Work work(&one, nullptr, &other);
  EXPECT_NO_THROW(work.check());
  other = true;
  EXPECT_THROW(work.check(), Cancelled);
  EXPECT_THROW(work.quiet().part(0, 1).check(), Cancelled);
}

}  // namespace
}  // namespace terrazzo
