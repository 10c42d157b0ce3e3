#include "hybrid/normals/normal_screening.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "scan/base/median.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr int kRadius = 2;          // of the 5 x 5 neighbourhood [samples]
constexpr std::size_t kFewest = 5;  // normals of the 25 that there must be
// Seven sigma: the median distance of Gaussian slopes along two tangents is sqrt(2 ln 2) = 1.18
// sigma. Of noise 1e-11 lies beyond.
constexpr float kTypicalToLimit = 6.0f;

struct Deviation {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();  // median normal of the neighbourhood
  float own = 0.0f, typical = 0.0f;  // distance from it, and the median one of the neighbours
};

// Normals of pixels without a range are no part of the surface.
bool has_both(const RangeView& view, int u, int v) {
  return view.has_sample(u, v) && view.has_normal(u, v);
}

class Neighbourhood {
 public:
  // The normals of samples within the radius of (u, v).
  void gather(const RangeView& view, int u, int v) {
    size_ = 0;
    for (int y = std::max(0, v - kRadius); y <= std::min(view.height() - 1, v + kRadius); ++y)
      for (int x = std::max(0, u - kRadius); x <= std::min(view.width() - 1, u + kRadius); ++x)
        if (has_both(view, x, y)) members_[size_++] = view.normals(x, y);
  }

  // Whether most members are so close to `normal` that their median cannot be further than
  // `limit` from it: a median lies where the majority does, component by component.
  bool surely_within(const Eigen::Vector3f& normal, float limit) const {
    const float side = limit / std::numbers::sqrt3_v<float>;
    std::size_t close = 0;
    for (std::size_t k = 0; k < size_; ++k)
      close += (members_[k] - normal).cwiseAbs().maxCoeff() <= side ? 1 : 0;
    return 2 * close > size_ + 1;
  }

  Deviation deviation_of(const Eigen::Vector3f& normal) {
    if (size_ < kFewest) return {};
    const Eigen::Vector3f centre(median_of(0), median_of(1), median_of(2));
    values_.clear();
    for (std::size_t k = 0; k < size_; ++k) values_.push_back((members_[k] - centre).norm());
    return {centre.normalized(), (normal - centre).norm(), median(values_)};
  }

 private:
  float median_of(int axis) {
    values_.clear();
    for (std::size_t k = 0; k < size_; ++k) values_.push_back(members_[k][axis]);
    return median(values_);
  }

  std::array<Eigen::Vector3f, (2 * kRadius + 1) * (2 * kRadius + 1)> members_;
  std::size_t size_ = 0;
  std::vector<float> values_;
};

// Calls body(row, neighbourhood) for every so many-th row.
template <typename Body>
void each_row(const RangeView& view, int stride, const Body& body) {
  const auto rows = static_cast<std::size_t>((view.height() + stride - 1) / stride);
  parallel_for(rows, 16, [&](std::size_t begin, std::size_t end) {
    Neighbourhood neighbourhood;
    for (std::size_t row = begin; row < end; ++row)
      body(static_cast<int>(row) * stride, neighbourhood);
  });
}

// The typical distance of a normal from the median of its neighbourhood; 0 for none.
float typical_distance(const RangeView& view) {
  // Bounds the time. The 2400 neighbourhoods among them that share no sample have medians that
  // scatter by 14 % each: their median is good to 1.25 * 14 % / sqrt(2400) = 0.4 %.
  constexpr double kEnough = 60000.0;
  const int stride =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(view.normals.size()) / kEnough)));
  std::vector<std::vector<float>> of_row(static_cast<std::size_t>(view.height()));
  each_row(view, stride, [&](int v, Neighbourhood& neighbourhood) {
    for (int u = 0; u < view.width(); u += stride) {
      if (!has_both(view, u, v)) continue;
      neighbourhood.gather(view, u, v);
      const float typical = neighbourhood.deviation_of(view.normals(u, v)).typical;
      if (typical > 0.0f) of_row[static_cast<std::size_t>(v)].push_back(typical);
    }
  });
  std::vector<float> all;
  for (const auto& row : of_row) all.insert(all.end(), row.begin(), row.end());
  return median(all);
}

}  // namespace

ScreenedNormals screen_normals(const RangeView& view) {
  ScreenedNormals screened{view.normals, Grid<std::uint8_t>(view.width(), view.height(), 0), 0};
  if (!view.has_normals()) return screened;
  const float typical = typical_distance(view);
  if (!(typical > 0.0f)) return screened;
  each_row(view, 1, [&](int v, Neighbourhood& neighbourhood) {
    for (int u = 0; u < view.width(); ++u) {
      if (!has_both(view, u, v)) continue;
      const Eigen::Vector3f& normal = view.normals(u, v);
      neighbourhood.gather(view, u, v);
      if (neighbourhood.surely_within(normal, kTypicalToLimit * typical)) continue;
      const Deviation deviation = neighbourhood.deviation_of(normal);
      if (deviation.own <= kTypicalToLimit * std::max(typical, deviation.typical)) continue;
      screened.normals(u, v) = deviation.centre;
      screened.isolated(u, v) = 1;
    }
  });
  screened.count = static_cast<std::size_t>(
      std::count(screened.isolated.begin(), screened.isolated.end(), std::uint8_t{1}));
  return screened;
}

}  // namespace relief::hybrid
