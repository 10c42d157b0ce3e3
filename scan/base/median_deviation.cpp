#include "scan/base/median_deviation.h"

#include <utility>
#include <vector>

#include "scan/base/median.h"

namespace relief {

float median_deviation(const RangeView& view) {
  std::vector<float> known;
  for (const float deviation : view.deviation)
    if (deviation > 0.0f) known.push_back(deviation);
  return median(std::move(known));
}

}  // namespace relief
