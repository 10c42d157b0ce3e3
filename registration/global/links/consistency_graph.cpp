#include "registration/global/links/consistency_graph.h"

#include <bit>
#include <cmath>

#include <Eigen/Geometry>

namespace relief::registration {

namespace {

struct Signature {
  double first = 0.0, second = 0.0, between = 0.0, volume = 0.0;
};

// The angles that two oriented points make: invariant, and of opposite volume when mirrored.
Signature signature(const Eigen::Vector3d& n, const Eigen::Vector3d& m,
                    const Eigen::Vector3d& line) {
  return {n.dot(line), m.dot(line), n.dot(m), n.cross(m).dot(line)};
}

bool similar(const Signature& s, const Signature& t, double tolerance) {
  return std::abs(s.first - t.first) < tolerance && std::abs(s.second - t.second) < tolerance &&
         std::abs(s.between - t.between) < tolerance && std::abs(s.volume - t.volume) < tolerance;
}

}  // namespace

ConsistencyGraph::ConsistencyGraph(const ResampledView& a, const ResampledView& b,
                                   const std::vector<FeatureMatch>& matches,
                                   const ConsistencyOptions& options)
    : words_((matches.size() + 63) / 64),
      bits_(matches.size() * words_, 0),
      degrees_(matches.size(), 0) {
  for (std::size_t i = 0; i < matches.size(); ++i) {
    for (std::size_t j = i + 1; j < matches.size(); ++j) {
      const FeatureMatch &x = matches[i], &y = matches[j];
      const Eigen::Vector3d in_a = a.points.col(y.a) - a.points.col(x.a);
      const Eigen::Vector3d in_b = b.points.col(y.b) - b.points.col(x.b);
      const double length_a = in_a.norm(), length_b = in_b.norm();
      if (std::abs(length_a - length_b) > options.distance_tolerance) continue;
      if (length_a < options.least_distance || length_b < options.least_distance) continue;
      if (similar(signature(a.normals.col(x.a), a.normals.col(y.a), in_a / length_a),
                  signature(b.normals.col(x.b), b.normals.col(y.b), in_b / length_b),
                  options.angle_tolerance))
        connect(i, j);
    }
  }
}

void ConsistencyGraph::connect(std::size_t i, std::size_t j) {
  bits_[i * words_ + j / 64] |= std::uint64_t{1} << (j % 64);
  bits_[j * words_ + i / 64] |= std::uint64_t{1} << (i % 64);
  ++degrees_[i];
  ++degrees_[j];
}

std::vector<std::size_t> ConsistencyGraph::consensus_around(std::size_t i) const {
  std::size_t best = size(), most = 0;
  for (std::size_t j = 0; j < size(); ++j) {
    if (!consistent(i, j)) continue;
    std::size_t common = 1;  // An edge alone counts too.
    for (std::size_t w = 0; w < words_; ++w)
      common += static_cast<std::size_t>(std::popcount(row(i)[w] & row(j)[w]));
    if (common <= most) continue;
    most = common;
    best = j;
  }
  std::vector<std::size_t> set;
  if (best == size()) return set;
  for (std::size_t k = 0; k < size(); ++k)
    if (k == i || k == best || (consistent(i, k) && consistent(best, k))) set.push_back(k);
  return set;
}

}  // namespace relief::registration
