#include "registration/posegraph/joint/view_clusters.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

namespace relief::registration {

namespace {

using Links = std::map<std::size_t, SharedConstraintSum>;  // By the other cluster.

void add_link(Links& links, std::size_t other, const SharedConstraintSum& shared) {
  const auto [place, is_first] = links.try_emplace(other, shared);
  if (!is_first) place->second.add(shared);
}

SharedConstraintSum sum_of(const Links& links) {
  SharedConstraintSum sum = links.begin()->second;
  for (auto link = std::next(links.begin()); link != links.end(); ++link) sum.add(link->second);
  return sum;
}

std::vector<std::size_t> merged(const std::vector<std::size_t>& a,
                                const std::vector<std::size_t>& b) {
  std::vector<std::size_t> both;
  std::ranges::merge(a, b, std::back_inserter(both));
  return both;
}

class Agglomeration {
 public:
  Agglomeration(const std::vector<ViewSurface>& surfaces,
                const std::vector<RigidMotion>& world_from_view,
                const std::vector<PairConstraint>& pairs)
      : surfaces_(surfaces), world_from_view_(world_from_view), links_(surfaces.size()) {
    for (const PairConstraint& pair : pairs) {
      if (!(surfaces[pair.a].radius() > 0.0) || !(surfaces[pair.b].radius() > 0.0)) continue;
      add_link(links_[pair.a], pair.b, pair.shared);
      add_link(links_[pair.b], pair.a, pair.shared);
    }
    for (std::size_t view = 0; view < surfaces.size(); ++view) views_.push_back({view});
    for (std::size_t view = 0; view < surfaces.size(); ++view) add_cluster(view);
  }

  std::vector<ViewCluster> run() {
    while (!candidates_.empty()) {
      const auto [correlation, a, b] = candidates_.top();
      candidates_.pop();
      if (links_[a].contains(b)) join(a, b);
    }
    return std::move(found_);
  }

 private:
  // Makes a cluster known, and its links to those before it.
  void add_cluster(std::size_t cluster) {
    const Links& links = links_[cluster];
    if (links.empty()) return;
    found_.push_back({views_[cluster], sum_of(links)});
    for (const auto& [other, shared] : links)
      if (other < cluster)
        candidates_.push({least_correlation(cluster, other, shared), other, cluster});
  }

  double least_correlation(std::size_t a, std::size_t b, const SharedConstraintSum& shared) const {
    const ViewsExtent extent(merged(views_[a], views_[b]), surfaces_, world_from_view_);
    return shared.about(extent.centre, extent.radius).constraints().correlations.minCoeff();
  }

  void join(std::size_t a, std::size_t b) {
    const std::size_t both = views_.size();
    views_.push_back(merged(views_[a], views_[b]));
    links_.emplace_back();
    for (const std::size_t part : {a, b})
      for (const auto& [other, shared] : std::exchange(links_[part], {})) {
        links_[other].erase(part);
        if (other == a || other == b) continue;
        add_link(links_[both], other, shared);
        add_link(links_[other], both, shared);
      }
    add_cluster(both);
  }

  const std::vector<ViewSurface>& surfaces_;
  const std::vector<RigidMotion>& world_from_view_;
  std::vector<std::vector<std::size_t>> views_;  // Of each cluster: first the single views.
  std::vector<Links> links_;                     // Of each; none of clusters within others.
  std::priority_queue<std::tuple<double, std::size_t, std::size_t>> candidates_;
  std::vector<ViewCluster> found_;
};

}  // namespace

ViewsExtent::ViewsExtent(const std::vector<std::size_t>& views,
                         const std::vector<ViewSurface>& surfaces,
                         const std::vector<RigidMotion>& world_from_view) {
  const double count = static_cast<double>(views.size());
  for (const std::size_t i : views) centre += world_from_view[i] * surfaces[i].centre() / count;
  double squares = 0.0;
  for (const std::size_t i : views) {
    const double own = surfaces[i].radius();
    squares += own * own + (world_from_view[i] * surfaces[i].centre() - centre).squaredNorm();
  }
  radius = std::sqrt(squares / count);
}

std::vector<ViewCluster> cluster_views(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<RigidMotion>& world_from_view,
                                       const std::vector<PairConstraint>& pairs) {
  return Agglomeration(surfaces, world_from_view, pairs).run();
}

}  // namespace relief::registration
