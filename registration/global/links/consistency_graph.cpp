#include "registration/global/links/consistency_graph.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <Eigen/Geometry>

namespace relief::registration {

namespace {

struct MatchedPoint {
  Eigen::Vector3d point, normal;
};

// Two points of a view with their normals, by what no motion of the view changes.
class PointPair {
 public:
  PointPair(const MatchedPoint& first, const MatchedPoint& second)
      : first_(first), second_(second), line_(second.point - first.point), length_(line_.norm()) {}

  double length() const { return length_; }

  // Whether the angles between the normals and the line are those of another pair, and their triple
  // product, which a mirror turns. Most pairs differ in the first of these.
  bool is_similar(const PointPair& other, double tolerance) const {
    const auto alike = [&](double mine, double others) {
      return std::abs(mine - others) < tolerance;
    };
    const Eigen::Vector3d line = line_ / length_, other_line = other.line_ / other.length_;
    const Eigen::Vector3d &n = first_.normal, &m = second_.normal;
    const Eigen::Vector3d &other_n = other.first_.normal, &other_m = other.second_.normal;
    return alike(n.dot(line), other_n.dot(other_line)) &&
           alike(m.dot(line), other_m.dot(other_line)) && alike(n.dot(m), other_n.dot(other_m)) &&
           alike(n.cross(m).dot(line), other_n.cross(other_m).dot(other_line));
  }

 private:
  const MatchedPoint &first_, &second_;
  Eigen::Vector3d line_;
  double length_;
};

}  // namespace

ConsistencyGraph::ConsistencyGraph(const ResampledView& a, const ResampledView& b,
                                   const std::vector<FeatureMatch>& matches,
                                   const ConsistencyOptions& options)
    : words_((matches.size() + 63) / 64),
      bits_(matches.size() * words_, 0),
      degrees_(matches.size(), 0) {
  std::vector<MatchedPoint> in_a, in_b;  // Of the matches, in their order.
  for (const FeatureMatch& match : matches) {
    in_a.push_back({a.points.col(match.a), a.normals.col(match.a)});
    in_b.push_back({b.points.col(match.b), b.normals.col(match.b)});
  }
  for (std::size_t i = 0; i < matches.size(); ++i) {
    for (std::size_t j = i + 1; j < matches.size(); ++j) {
      const PointPair of_a(in_a[i], in_a[j]), of_b(in_b[i], in_b[j]);
      if (std::abs(of_a.length() - of_b.length()) > options.distance_tolerance) continue;
      if (std::min(of_a.length(), of_b.length()) < options.least_distance) continue;
      if (of_a.is_similar(of_b, options.angle_tolerance)) connect(i, j);
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
