#include "scan/base/parallel.h"

#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace relief {
namespace {

TEST(ParallelFor, VisitsEveryItemOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<int> visits(1003, 0);
    parallel_for(visits.size(), 10, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(visits, std::vector<int>(1003, 1));
  }
}

TEST(ParallelFor, RethrowsInTheCaller) {
  const auto fail = [](std::size_t, std::size_t) { throw std::runtime_error("body"); };
  EXPECT_THROW(parallel_for(100, 1, 4, fail), std::runtime_error);
}

TEST(ParallelFor, DoesNothingForNothing) {
  parallel_for(0, 1, 4, [](std::size_t, std::size_t) { FAIL(); });
}

}  // namespace
}  // namespace relief
