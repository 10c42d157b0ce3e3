#include "registration/global/links/moved_piece.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "registration/global/pair_search.h"
#include "registration/pairwise/search_schedule.h"
#include "scan/base/disjoint_sets.h"

namespace relief::registration {

namespace {

// Largest motion of a sensor that counts as still [sample spacings]: as far as the finest level of
// ICP searches.
constexpr double kStill = 4.0;
// Part of a view's samples: less is no piece. Where nothing moved, 0.0005 of those of a depth
// camera hang together in front, along outlines that flicker, and 0.004 where a box of a twentieth
// of the image turned.
constexpr double kSmallestPiece = 0.002;
// Fewest samples of a piece: noise alone joins up to nine.
constexpr std::size_t kFewestSamples = 25;

bool is_in_front(const ViewSurface& source, const SurfacePoint& sample, const ViewSurface& target,
                 const RigidMotion& target_from_source, double min_stddev) {
  const Eigen::Vector3d point = target_from_source * sample.point;
  const auto pixel = target.project(point);
  const auto seen = pixel ? target.at(*pixel) : std::nullopt;
  if (!seen) return false;
  const double stddev = std::hypot(source.noise_at(sample), target.noise_at(*seen));
  return (point - seen->point).dot(seen->normal) >
         finest_search_distance(coarser_spacing(source, target), std::max(stddev, min_stddev));
}

// How many of these samples of a view hang together at most.
std::size_t largest_piece(const ViewSurface& view, const std::vector<std::uint32_t>& samples) {
  if (samples.empty()) return 0;
  const auto width = static_cast<std::uint32_t>(view.width());
  const std::uint32_t end = *std::max_element(samples.begin(), samples.end()) + 1;
  std::vector<std::uint8_t> marked(end, 0);
  for (const std::uint32_t i : samples) marked[i] = 1;
  DisjointSets sets(end);
  for (const std::uint32_t i : samples) {
    if (i % width > 0 && marked[i - 1]) sets.join(i, i - 1);
    if (i >= width && marked[i - width]) sets.join(i, i - width);
  }
  std::vector<std::size_t> sizes(end, 0);
  std::size_t largest = 0;
  for (const std::uint32_t i : samples) largest = std::max(largest, ++sizes[sets.find(i)]);
  return largest;
}

bool has_piece_in_front(const ViewSurface& source, const ViewSurface& target,
                        const RigidMotion& target_from_source, double min_stddev) {
  if (!target.can_project()) return false;
  std::vector<std::uint32_t> in_front;
  for (const std::uint32_t i : source.samples())
    if (is_in_front(source, source.sample(i), target, target_from_source, min_stddev))
      in_front.push_back(i);
  const std::size_t least = std::max(
      kFewestSamples,
      static_cast<std::size_t>(kSmallestPiece * static_cast<double>(source.samples().size())));
  return largest_piece(source, in_front) >= least;
}

}  // namespace

bool moved_before_still_sensor(const ViewSurface& a, const ViewSurface& b,
                               const RigidMotion& b_from_a, double min_stddev) {
  return same_pose(a, b_from_a, RigidMotion::Identity(), kStill * coarser_spacing(a, b)) &&
         (has_piece_in_front(a, b, b_from_a, min_stddev) ||
          has_piece_in_front(b, a, b_from_a.inverse(), min_stddev));
}

}  // namespace relief::registration
