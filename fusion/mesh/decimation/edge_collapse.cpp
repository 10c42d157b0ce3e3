#include "fusion/mesh/decimation/edge_collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "fusion/mesh/decimation/collapse_queue.h"
#include "scan/base/parallel.h"
#include "scan/mesh/vertex_arrays.h"

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

// Of moved vertices: planes as many as this part of all draw them to the middle of their edge.
// Along planes and creases the others say nothing.
constexpr double kMiddleShare = 1e-3;
// From the middle of an edge, in its lengths. Nearly parallel planes meet far off.
constexpr double kFarthest = 1.0;

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
      const CollapseCandidate next = queue_.pop();
      if (next.from_stamp != stamp_[next.from] || next.to_stamp != stamp_[next.to]) continue;
      const Eigen::Vector3d place = place_for(next.from, next.to);
      if (keeps_topology(next.from, next.to) && keeps_shape(next.from, next.to, place))
        collapse(next.from, next.to, place);
      else
        refuse(next.from, next.to);
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

  // Whether the edge has one candidate, the same for both directions.
  bool both_move(std::uint32_t a, std::uint32_t b) const {
    return options_.move && !fixed_[a] && !fixed_[b];
  }

  // Where one vertex stands for both: where the squares are least. Of exact planes the given places
  // stay.
  Eigen::Vector3d place_for(std::uint32_t from, std::uint32_t to) const {
    const Eigen::Vector3d &a = mesh_.vertices[from], &b = mesh_.vertices[to];
    if (!both_move(from, to)) return b;
    const Eigen::Matrix4d planes = planes_[from] + planes_[to];
    const Eigen::Vector3d middle = 0.5 * (a + b);
    Eigen::Matrix3d squares = planes.topLeftCorner<3, 3>();
    const Eigen::Vector3d slope = squares * (middle - centre_) + planes.topRightCorner<3, 1>();
    squares.diagonal().array() += kMiddleShare * squares.trace();
    const Eigen::Vector3d step = -squares.llt().solve(slope);
    Eigen::Vector3d best = middle;
    if (step.norm() <= kFarthest * (a - b).norm()) best += step;
    double least = squares_at(planes, best);
    for (const Eigen::Vector3d& given : {b, a}) {
      const double of_given = squares_at(planes, given);
      if (of_given > least) continue;
      least = of_given;
      best = given;
    }
    return best;
  }

  double squares_at(const Eigen::Matrix4d& planes, const Eigen::Vector3d& place) const {
    Eigen::Vector4d at;
    at << place - centre_, 1.0;
    return at.dot(planes * at);
  }

  void propose(std::uint32_t from, std::uint32_t to) {
    if (fixed_[from] || (both_move(from, to) && from < to)) return;
    const double squares = squares_at(planes_[from] + planes_[to], place_for(from, to));
    if (squares > options_.max_error * options_.max_error) return;
    const double length = (mesh_.vertices[to] - mesh_.vertices[from]).squaredNorm();
    queue_.push(
        {std::max(0.0, squares) + kLengthShare * length, from, to, stamp_[from], stamp_[to]});
  }

  void refuse(std::uint32_t from, std::uint32_t to) {
    refused_[from].push_back(to);
    if (both_move(from, to)) refused_[to].push_back(from);
  }

  // What was refused for the faces around `v`, which have changed.
  void propose_again(std::uint32_t v) {
    for (const std::uint32_t w : refused_[v]) {
      if (stamp_[w] == kRemoved) continue;
      propose(v, w);
      if (!both_move(v, w)) continue;
      propose(w, v);
      std::erase(refused_[w], v);
    }
    refused_[v].clear();
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
  bool keeps_shape(std::uint32_t from, std::uint32_t to, const Eigen::Vector3d& place) const {
    double least_before = 1.0, least_after = 1.0;
    const auto keeps_direction = [&](std::uint32_t moved, std::uint32_t other) {
      for (const std::uint32_t f : faces_of_[moved]) {
        Corners before, after;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t v = mesh_.faces[f][k];
          before[k] = mesh_.vertices[v];
          after[k] = v == moved ? place : before[k];
        }
        least_before = std::min(least_before, roundness(before));
        if (has(mesh_.faces[f], other)) continue;
        least_after = std::min(least_after, roundness(after));
        const Eigen::Vector3d cross = cross_of(before), new_cross = cross_of(after);
        if (!(cross.dot(new_cross) > kLeastCosine * cross.norm() * new_cross.norm())) return false;
      }
      return true;
    };
    return keeps_direction(from, to) && (!both_move(from, to) || keeps_direction(to, from)) &&
           least_after >= std::min(kLeastRoundness, (1.0 - kRounding) * least_before);
  }

  // `to` stands at a place for both, with the attributes of the nearer one.
  void move(std::uint32_t from, std::uint32_t to, const Eigen::Vector3d& place) {
    if ((mesh_.vertices[from] - place).squaredNorm() < (mesh_.vertices[to] - place).squaredNorm())
      visit_vertex_arrays(mesh_, [&](auto& values) {
        if (!values.empty()) values[to] = values[from];
      });
    mesh_.vertices[to] = place;
  }

  void collapse(std::uint32_t from, std::uint32_t to, const Eigen::Vector3d& place) {
    move(from, to, place);
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
  CollapseQueue queue_;
};

}  // namespace

void collapse_edges(TriangleMesh& mesh, const EdgeCollapseOptions& options) {
  Collapser(mesh, options).run();
}

}  // namespace relief::fusion
