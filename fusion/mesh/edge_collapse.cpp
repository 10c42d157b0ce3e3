#include "fusion/mesh/edge_collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <queue>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Part of the squared length of an edge in its cost. Where errors are below 0.01 lengths (0.007
// with half of it, 0.014 with twice), short edges go first and faces stay well shaped.
constexpr double kLengthShare = 1e-4;

// Between a face before and after, 60 degrees: faces that were flat are at most 120 apart, and
// neither folds back onto the other.
constexpr double kLeastCosine = 0.5;
// Of triangles, see roundness(): no angle is below atan(0.05) = 2.9 degrees.
constexpr double kLeastRoundness = 0.05;
constexpr double kRounding = 1e-9;  // Of the roundness of faces of the same shape.

using Corners = std::array<Eigen::Vector3d, 3>;

Eigen::Vector3d cross_of(const Corners& corners) {
  return (corners[1] - corners[0]).cross(corners[2] - corners[0]);
}

// Twice the area over the longest edge squared.
double roundness(const Corners& corners) {
  const double longest =
      std::max({(corners[1] - corners[0]).squaredNorm(), (corners[2] - corners[1]).squaredNorm(),
                (corners[0] - corners[2]).squaredNorm()});
  return longest > 0.0 ? cross_of(corners).norm() / longest : 0.0;
}

struct Candidate {
  double cost;
  std::uint32_t from, to;
  std::uint32_t from_stamp, to_stamp;
  bool operator>(const Candidate& other) const {
    return std::tie(cost, from, to) > std::tie(other.cost, other.from, other.to);
  }
};

// Candidates by their cost, the least first. The dear ones wait unsorted until the cheap ones are
// used up: most never come that far, and the heap stays small enough for the cache.
class CandidateQueue {
 public:
  void push(const Candidate& candidate) {
    if (candidate.cost > limit_)
      waiting_.push_back(candidate);
    else
      heap_.push(candidate);
  }

  bool empty() const { return heap_.empty() && waiting_.empty(); }

  /// Must not be empty.
  Candidate pop() {
    if (heap_.empty()) admit();
    const Candidate next = heap_.top();
    heap_.pop();
    return next;
  }

 private:
  // The cheapest of those that wait, and all of the same cost.
  void admit() {
    const std::size_t count =
        std::min(std::max(kLeastAdmitted, waiting_.size() / 16), waiting_.size());
    const auto last = waiting_.begin() + static_cast<std::ptrdiff_t>(count - 1);
    std::nth_element(waiting_.begin(), last, waiting_.end(),
                     [](const Candidate& a, const Candidate& b) { return b > a; });
    limit_ = last->cost;
    const auto dear = std::partition(waiting_.begin(), waiting_.end(),
                                     [this](const Candidate& c) { return c.cost > limit_; });
    for (auto candidate = dear; candidate != waiting_.end(); ++candidate) heap_.push(*candidate);
    waiting_.erase(dear, waiting_.end());
  }

  // Candidates at once: few enough for the cache. Changes no result.
  static constexpr std::size_t kLeastAdmitted = 50000;

  double limit_ = -1.0;  // The largest cost in the heap; costs are not negative.
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> heap_;
  std::vector<Candidate> waiting_;
};

class Collapser {
 public:
  Collapser(TriangleMesh& mesh, const EdgeCollapseOptions& options)
      : mesh_(mesh),
        options_(options),
        faces_of_(mesh.vertices.size()),
        planes_(mesh.vertices.size(), Eigen::Matrix4d::Zero()),
        stamp_(mesh.vertices.size(), 0),
        refused_(mesh.vertices.size()),
        fixed_(mesh.vertices.size(), 0),
        gone_(mesh.faces.size(), 0),
        left_(mesh.faces.size()) {
    for (const auto& vertex : mesh.vertices) centre_ += vertex;
    centre_ /= static_cast<double>(std::max<std::size_t>(1, mesh.vertices.size()));
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) add_face(f);
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) fixed_[v] = on_border(v);
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      if (v % kBetweenStops == 0) check_stop_and_memory();
      for (const std::uint32_t w : neighbours(v)) propose(v, w);
    }
  }

  void run() {
    for (std::size_t step = 0; left_ > options_.faces && !queue_.empty(); ++step) {
      if (step % kBetweenStops == 0) check_stop_and_memory();
      const Candidate next = queue_.pop();
      if (next.from_stamp != stamp_[next.from] || next.to_stamp != stamp_[next.to]) continue;
      if (allowed(next.from, next.to))
        collapse(next.from, next.to);
      else
        refused_[next.from].push_back(next.to);
    }
    std::size_t kept = 0;
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f)
      if (!gone_[f]) mesh_.faces[kept++] = mesh_.faces[f];
    mesh_.faces.resize(kept);
  }

 private:
  static constexpr std::size_t kBetweenStops = 4096;      // Steps, milliseconds. Changes no result.
  static constexpr std::uint32_t kRemoved = 0xffffffffu;  // A stamp that no candidate has.

  static bool has(const TriangleMesh::Face& face, std::uint32_t v) {
    return face[0] == v || face[1] == v || face[2] == v;
  }

  void add_face(std::uint32_t f) {
    const auto& face = mesh_.faces[f];
    const Eigen::Vector3d normal = face_cross(mesh_, f).normalized();
    Eigen::Vector4d plane;
    plane << normal, -normal.dot(mesh_.corner(f, 0) - centre_);
    for (const std::uint32_t v : face) {
      faces_of_[v].push_back(f);
      planes_[v] += plane * plane.transpose();
    }
  }

  // Vertices round v, in ascending order.
  std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
    std::vector<std::uint32_t> around;
    around.reserve(2 * faces_of_[v].size());
    for (const std::uint32_t f : faces_of_[v])
      for (const std::uint32_t w : mesh_.faces[f])
        if (w != v) around.push_back(w);
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    return around;
  }

  // Round an inner vertex of a manifold there are as many neighbours as faces.
  bool on_border(std::uint32_t v) const { return neighbours(v).size() != faces_of_[v].size(); }

  void propose(std::uint32_t from, std::uint32_t to) {
    if (fixed_[from]) return;
    Eigen::Vector4d place;
    place << mesh_.vertices[to] - centre_, 1.0;
    const double squares = place.dot((planes_[from] + planes_[to]) * place);
    if (squares > options_.max_error * options_.max_error) return;
    const double length = (mesh_.vertices[to] - mesh_.vertices[from]).squaredNorm();
    queue_.push(
        {std::max(0.0, squares) + kLengthShare * length, from, to, stamp_[from], stamp_[to]});
  }

  // What was refused for the faces around `from`, which have changed.
  void propose_again(std::uint32_t from) {
    for (const std::uint32_t to : refused_[from])
      if (stamp_[to] != kRemoved) propose(from, to);
    refused_[from].clear();
  }

  bool allowed(std::uint32_t from, std::uint32_t to) const {
    return keeps_topology(from, to) && keeps_shape(from, to);
  }

  // The link condition.
  bool keeps_topology(std::uint32_t from, std::uint32_t to) const {
    const auto a = neighbours(from), b = neighbours(to);
    std::vector<std::uint32_t> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    if (common.size() != 2) return false;
    const auto spans = [&](std::uint32_t v) {
      return std::any_of(faces_of_[v].begin(), faces_of_[v].end(), [&](std::uint32_t f) {
        return has(mesh_.faces[f], common[0]) && has(mesh_.faces[f], common[1]);
      });
    };
    return !(spans(from) && spans(to));
  }

  // No face turns far, and none is narrow, or at least none narrower than what is there.
  bool keeps_shape(std::uint32_t from, std::uint32_t to) const {
    double least_before = 1.0, least_after = 1.0;
    for (const std::uint32_t f : faces_of_[from]) {
      Corners before, after;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh_.faces[f][k];
        before[k] = mesh_.vertices[v];
        after[k] = mesh_.vertices[v == from ? to : v];
      }
      least_before = std::min(least_before, roundness(before));
      if (has(mesh_.faces[f], to)) continue;
      least_after = std::min(least_after, roundness(after));
      const Eigen::Vector3d cross = cross_of(before), new_cross = cross_of(after);
      if (!(cross.dot(new_cross) > kLeastCosine * cross.norm() * new_cross.norm())) return false;
    }
    return least_after >= std::min(kLeastRoundness, (1.0 - kRounding) * least_before);
  }

  void collapse(std::uint32_t from, std::uint32_t to) {
    for (const std::uint32_t f : faces_of_[from]) {
      auto& face = mesh_.faces[f];
      if (has(face, to)) {
        gone_[f] = 1;
        --left_;
        for (const std::uint32_t w : face)
          if (w != from) std::erase(faces_of_[w], f);
      } else {
        std::replace(face.begin(), face.end(), from, to);
        faces_of_[to].push_back(f);
      }
    }
    faces_of_[from].clear();
    planes_[to] += planes_[from];
    stamp_[from] = kRemoved;
    ++stamp_[to];
    for (const std::uint32_t w : neighbours(to)) {
      propose(w, to);
      propose(to, w);
      propose_again(w);
    }
    refused_[to].clear();
  }

  TriangleMesh& mesh_;
  EdgeCollapseOptions options_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  std::vector<std::vector<std::uint32_t>> faces_of_;
  std::vector<Eigen::Matrix4d> planes_;  // Sums of squared distances to planes, as quadratic forms.
  std::vector<std::uint32_t> stamp_;     // Renewed when the planes of a vertex change.
  std::vector<std::vector<std::uint32_t>> refused_;  // Of a vertex: where it may not go as yet.
  std::vector<std::uint8_t> fixed_, gone_;
  std::size_t left_;
  CandidateQueue queue_;
};

}  // namespace

void collapse_edges(TriangleMesh& mesh, const EdgeCollapseOptions& options) {
  Collapser(mesh, options).run();
}

}  // namespace relief::fusion
