#pragma once

#include <cstdint>

namespace relief::simulation {

/// Which random numbers an error draws: equal streams of equal seeds give equal errors.
struct RandomStream {
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;
};

}  // namespace relief::simulation
