#include "registration/posegraph/view_graph.h"

#include <algorithm>
#include <numeric>

#include "registration/posegraph/sphere_lattice.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Samples per direction of a pair; bounds the time. An overlap of 0.04 is told to 0.008.
constexpr int kProbes = 600;

bool spheres_meet(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                  double margin) {
  return (b_from_a * a.centre() - b.centre()).norm() <= a.radius() + b.radius() + margin;
}

// Overlap of a pair that meets, 0 unless the samples that it can be expected to share are enough.
double probe(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
             const ViewGraphOptions& options) {
  CorrespondenceOptions search;
  search.count = kProbes;
  search.tries = 1;
  search.max_distance = options.max_distance;
  search.max_normal_angle_deg = options.max_normal_angle_deg;
  search.association = options.association;
  const double a_in_b = find_correspondences(a, b, b_from_a, search).overlap();
  const double b_in_a = find_correspondences(b, a, b_from_a.inverse(), search).overlap();
  const double shared = a_in_b * static_cast<double>(a.samples().size()) +
                        b_in_a * static_cast<double>(b.samples().size());
  return shared >= options.min_correspondences ? 0.5 * (a_in_b + b_in_a) : 0.0;
}

// The smallest member stands for a group. Paths are shortened as they are walked.
class Groups {
 public:
  explicit Groups(std::size_t views) : parent_(views) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  std::size_t of(std::size_t view) {
    while (parent_[view] != view) view = parent_[view] = parent_[parent_[view]];
    return view;
  }

  void join(std::size_t a, std::size_t b) {
    const auto [joined, absorbed] = std::minmax({of(a), of(b)});
    parent_[absorbed] = joined;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace

std::vector<ViewPair> find_meeting_pairs(const std::vector<ViewSurface>& surfaces,
                                         const std::vector<RigidMotion>& world_from_view,
                                         double margin) {
  std::vector<Sphere> spheres;
  std::vector<std::size_t> view_of;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (surfaces[i].samples().empty()) continue;
    spheres.push_back({world_from_view[i] * surfaces[i].centre(), surfaces[i].radius()});
    view_of.push_back(i);
  }
  std::vector<ViewPair> pairs;
  for (const auto& [first, second] : near_spheres(spheres, margin)) {
    const std::size_t a = view_of[first], b = view_of[second];
    const RigidMotion b_from_a = world_from_view[b].inverse() * world_from_view[a];
    if (spheres_meet(surfaces[a], surfaces[b], b_from_a, margin)) pairs.push_back({a, b});
  }
  return pairs;
}

std::vector<ViewPair> find_overlapping_pairs(const std::vector<ViewSurface>& surfaces,
                                             const std::vector<RigidMotion>& world_from_view,
                                             const ViewGraphOptions& options) {
  auto pairs = find_meeting_pairs(surfaces, world_from_view, options.max_distance);
  parallel_for(pairs.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto [a, b, unused] = pairs[i];
      const RigidMotion b_from_a = world_from_view[b].inverse() * world_from_view[a];
      pairs[i].overlap = probe(surfaces[a], surfaces[b], b_from_a, options);
    }
  });
  std::erase_if(pairs, [&](const ViewPair& pair) { return pair.overlap < options.min_overlap; });
  return pairs;
}

std::vector<ViewPair> largest_overlaps(std::size_t views, const std::vector<ViewPair>& pairs,
                                       int per_view) {
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
    return pairs[x].overlap > pairs[y].overlap;
  });
  std::vector<int> kept_of(views, 0);
  Groups groups(views);
  std::vector<bool> keep(pairs.size(), false);
  for (const std::size_t k : order) {
    const auto [a, b, unused] = pairs[k];
    keep[k] = kept_of[a] < per_view || kept_of[b] < per_view || groups.of(a) != groups.of(b);
    if (!keep[k]) continue;
    ++kept_of[a];
    ++kept_of[b];
    groups.join(a, b);
  }
  std::vector<ViewPair> kept;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (keep[k]) kept.push_back(pairs[k]);
  return kept;
}

std::vector<std::size_t> connected_groups(std::size_t views, const std::vector<ViewPair>& pairs) {
  Groups groups(views);
  for (const auto& pair : pairs) groups.join(pair.a, pair.b);
  std::vector<std::size_t> group;
  for (std::size_t i = 0; i < views; ++i) group.push_back(groups.of(i));
  return group;
}

}  // namespace relief::registration
