#include "hybrid/normal_screening.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "scan/median.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr int kRadius = 2;
constexpr std::size_t kFewest = 5;       // normals that a neighbourhood must have
constexpr float kTypicalToLimit = 6.0f;  // four sigma; the median of |x| is 0.67 sigma

struct Deviation {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();  // median normal of the neighbourhood
  float own = 0.0f, typical = 0.0f;  // distance from it, and the median one of the neighbours
};

class Neighbourhood {
 public:
  Deviation deviation(const RangeView& view, int u, int v) {
    members_.clear();
    for (int y = std::max(0, v - kRadius); y <= std::min(view.height() - 1, v + kRadius); ++y)
      for (int x = std::max(0, u - kRadius); x <= std::min(view.width() - 1, u + kRadius); ++x)
        if (view.has_normal(x, y)) members_.push_back(view.normals(x, y));
    if (members_.size() < kFewest) return {};
    const Eigen::Vector3f centre(median_of(0), median_of(1), median_of(2));
    values_.clear();
    for (const auto& normal : members_) values_.push_back((normal - centre).norm());
    return {centre.normalized(), (view.normals(u, v) - centre).norm(), median(values_)};
  }

 private:
  float median_of(int axis) {
    values_.clear();
    for (const auto& normal : members_) values_.push_back(normal[axis]);
    return median(values_);
  }

  std::vector<Eigen::Vector3f> members_;
  std::vector<float> values_;
};

}  // namespace

ScreenedNormals screen_normals(const RangeView& view, int threads) {
  ScreenedNormals screened{view.normals, Grid<std::uint8_t>(view.width(), view.height(), 0), 0};
  if (!view.has_normals()) return screened;
  Grid<Deviation> deviations(view.width(), view.height());
  parallel_for(static_cast<std::size_t>(view.height()), 16, threads,
               [&](std::size_t begin, std::size_t end) {
                 Neighbourhood neighbourhood;
                 for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v)
                   for (int u = 0; u < view.width(); ++u)
                     if (view.has_normal(u, v))
                       deviations(u, v) = neighbourhood.deviation(view, u, v);
               });
  std::vector<float> all;
  for (const Deviation& d : deviations)
    if (d.typical > 0.0f) all.push_back(d.typical);
  if (all.empty()) return screened;
  const float typical = median(all);
  for (std::size_t i = 0; i < deviations.size(); ++i) {
    if (deviations[i].own <= kTypicalToLimit * std::max(typical, deviations[i].typical)) continue;
    screened.normals[i] = deviations[i].centre;
    screened.isolated[i] = 1;
    ++screened.count;
  }
  return screened;
}

}  // namespace relief
