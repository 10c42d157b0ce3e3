#include "registration/global/features/feature_matches.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace relief::registration {

namespace {

// Every n-th column: columns are in the order of their cells, so that these are spread.
std::vector<Eigen::Index> spread_keys(Eigen::Index size, int keys) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, size / keys);
  std::vector<Eigen::Index> indices;
  for (Eigen::Index i = 0; i < size; i += stride) indices.push_back(i);
  return indices;
}

// Points nearer to a key than `least_shift` look infinitely different.
void exclude_near(const Eigen::Matrix3Xd& points, const std::vector<Eigen::Index>& keys,
                  double least_shift, Eigen::MatrixXf& distances) {
  const double least = least_shift * least_shift;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const Eigen::Vector3d key = points.col(keys[k]);
    for (Eigen::Index i = 0; i < points.cols(); ++i)
      if ((points.col(i) - key).squaredNorm() < least)
        distances(i, static_cast<Eigen::Index>(k)) = std::numeric_limits<float>::infinity();
  }
}

// (column of `from`, similar column of `to`). In 66 dimensions one product of matrices takes 29 ms
// a pair of views of the Stanford bunny, FLANN's exact kd-tree 69 ms. Its random trees with 128
// checks take 92 ms and miss 6 %.
std::vector<std::pair<Eigen::Index, Eigen::Index>> most_similar(
    const LocalFeatures& from, const LocalFeatures& to, const FeatureMatchOptions& options) {
  const auto keys = spread_keys(from.cols(), options.keys);
  LocalFeatures queries(from.rows(), static_cast<Eigen::Index>(keys.size()));
  for (std::size_t k = 0; k < keys.size(); ++k)
    queries.col(static_cast<Eigen::Index>(k)) = from.col(keys[k]);
  // Squared distances less the constant of each query.
  Eigen::MatrixXf distances = -2.0f * to.transpose() * queries;
  distances.colwise() += to.colwise().squaredNorm().transpose();
  if (options.own_points) exclude_near(*options.own_points, keys, options.least_shift, distances);

  const auto wanted = std::min<std::size_t>(static_cast<std::size_t>(options.candidates),
                                            static_cast<std::size_t>(to.cols()));
  std::vector<Eigen::Index> order(static_cast<std::size_t>(to.cols()));
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pairs;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    const auto column = distances.col(static_cast<Eigen::Index>(k));
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(wanted),
                      order.end(), [&](Eigen::Index x, Eigen::Index y) {
                        return std::pair(column[x], x) < std::pair(column[y], y);
                      });
    for (std::size_t c = 0; c < wanted; ++c)
      if (std::isfinite(column[order[c]])) pairs.emplace_back(keys[k], order[c]);
  }
  return pairs;
}

}  // namespace

std::vector<FeatureMatch> match_features(const LocalFeatures& a, const LocalFeatures& b,
                                         const FeatureMatchOptions& options) {
  assert(options.keys > 0 && options.candidates > 0);
  if (a.cols() == 0 || b.cols() == 0) return {};
  auto pairs = most_similar(a, b, options);
  for (const auto& [of_b, of_a] : most_similar(b, a, options)) pairs.emplace_back(of_a, of_b);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<FeatureMatch> matches;
  for (const auto& [of_a, of_b] : pairs) matches.push_back({of_a, of_b});
  return matches;
}

}  // namespace relief::registration
