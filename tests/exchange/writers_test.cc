#include "src/exchange/writers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <barrier>

namespace tessera {
namespace {

TEST(Writers, WorkAtOnceAndFinishWhatTheyHaveTakenBeforeTheyGo) {
  constexpr int threads = 3;
  std::barrier all_at_work(threads);
  std::atomic<int> done = 0;
  {
    Writers writers(threads);
    for (int i = 0; i < 20 * threads; ++i) {
      writers.take([&] {
        all_at_work.arrive_and_wait();
        ++done;
      });
    }
  }
  EXPECT_EQ(done, 20 * threads);
}

}  // namespace
}  // namespace tessera
