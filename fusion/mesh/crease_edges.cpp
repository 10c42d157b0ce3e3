#include "fusion/mesh/crease_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>
#include <unordered_set>
#include <vector>

#include <Eigen/Geometry>

#include "fusion/holes/plates/thin_plate.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"
#include "scan/mesh/moved_faces.h"

namespace relief::fusion {

namespace {

constexpr std::size_t kGrain = 4096;  // Faces of one piece of work; changes no result.

// A face takes part in one turn of a pass only. After three passes less than a tenth is left to
// turn (CreaseEdges.ComeToRest).
constexpr int kPasses = 3;

// Times the work is begun anew before the faces stay as given. Bounds the time.
constexpr int kAttempts = 5;

// What must be gained, in sagittas (below) against the length of the edge: a turn of the normals of
// 1.7 degrees. With half of it creases of 0.9 degrees count, with twice only those of 3.4.
constexpr double kLeastGain = 0.03;

// Nor less than this [standard deviations of the views' noise]. Noise of sigma turns the normals at
// the ends of an edge of length l by about sigma / l: that is a sagitta of sigma.
constexpr double kNoise = 1.0;

// Cosine of the largest angle between a new face and the mean of the old ones, 60 degrees: the new
// faces are at most 120 apart, and neither folds back onto the other.
constexpr double kTurn = 0.5;

// New faces have no angle below the least of the old ones, or below this [rad]. Two equilateral
// faces get angles of 30 degrees: with twice the value hardly any edge would turn.
constexpr double kLeastAngle = 15.0 * std::numbers::pi / 180.0;

// An edge from a to b and the corners opposite to it of its faces, left and right of it.
struct EdgeFlip {
  double gain = 0.0;
  std::uint32_t a = 0, b = 0, c = 0, d = 0;
  std::uint32_t left = 0, right = 0;
};

Eigen::Vector3d cross_of(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b,
                         std::uint32_t c) {
  const auto& x = mesh.vertices;
  return (x[b] - x[a]).cross(x[c] - x[a]);
}

double least_angle(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const auto& x = mesh.vertices;
  const auto angle = [&](std::uint32_t p, std::uint32_t q, std::uint32_t r) {
    const Eigen::Vector3d u = x[q] - x[p], v = x[r] - x[p];
    return std::atan2(u.cross(v).norm(), u.dot(v));
  };
  return std::min({angle(a, b, c), angle(b, c, a), angle(c, a, b)});
}

class CreaseEdges {
 public:
  CreaseEdges(TriangleMesh& mesh, const CreaseEdgeOptions& options)
      : mesh_(mesh),
        options_(options),
        all_(mesh.vertices.size()),
        fixed_(mesh.vertices.size()),
        touched_(mesh.vertices.size()) {
    std::fill(all_.begin(), all_.end(), 1);
  }

  // Turns edges, at first freely; where the result intersects itself, over again without the
  // vertices there. Returns how many edges were turned.
  std::size_t run() {
    const PagedVector<TriangleMesh::Face> as_given = paged_copy(mesh_.faces);
    auto searched = paged_copy(as_given);  // Faces whose intersections are known,
    std::vector<std::uint32_t> bad;        // and those that have some.
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      std::size_t turned = 0;
      std::fill(touched_.begin(), touched_.end(), 1);
      for (int pass = 0; pass < kPasses; ++pass) turned += this->pass();
      bad = intersecting(searched, bad);
      if (bad.empty()) return turned;
      for (const std::uint32_t f : bad)
        for (const std::uint32_t v : mesh_.faces[f]) fixed_[v] = 1;
      searched = std::move(mesh_.faces);
      mesh_.faces = paged_copy(as_given);
    }
    return 0;
  }

 private:
  // Of faces that are as they were no others than `known` intersect.
  std::vector<std::uint32_t> intersecting(const PagedVector<TriangleMesh::Face>& before,
                                          const std::vector<std::uint32_t>& known) const {
    PagedVector<std::uint32_t> in_question;
    serial_for(before.size(), [&](std::size_t i) {
      const auto f = static_cast<std::uint32_t>(i);
      if (mesh_.faces[f] != before[f] || std::binary_search(known.begin(), known.end(), f))
        in_question.push_back(f);
    });
    return intersecting_faces(mesh_, std::move(in_question), 2.0 * options_.voxel_size);
  }

  // Only near the vertices of faces that were turned in the pass before is there anything new.
  std::size_t pass() {
    mesh_.normals = vertex_normals(mesh_);
    const FacesAround around(mesh_, all_);
    std::vector<EdgeFlip> flips = candidates(around);
    std::sort(flips.begin(), flips.end(), [](const EdgeFlip& s, const EdgeFlip& t) {
      return std::tie(t.gain, s.left, s.a) < std::tie(s.gain, t.left, t.a);
    });
    keep_apart(flips);
    std::fill(touched_.begin(), touched_.end(), 0);
    // In the order of the faces few pages are touched at a time.
    std::ranges::sort(flips, {}, &EdgeFlip::left);
    serial_for(flips.size(), [&](std::size_t i) { apply(flips[i]); });
    for (const std::uint32_t f : faces_at(mesh_, touched_))  // and to the neighbours
      for (const std::uint32_t v : mesh_.faces[f]) touched_[v] = 1;
    return flips.size();
  }

  // How far the surface leaves an edge: eight times the height of the arc over it that has the
  // normals of its ends.
  double sagitta(std::uint32_t i, std::uint32_t j) const {
    return std::abs((mesh_.normals[i] - mesh_.normals[j])
                        .cast<double>()
                        .dot(mesh_.vertices[j] - mesh_.vertices[i]));
  }

  std::vector<EdgeFlip> candidates(const FacesAround& around) const {
    const auto faces = faces_at(mesh_, touched_);
    std::vector<std::vector<EdgeFlip>> found((faces.size() + kGrain - 1) / kGrain);
    parallel_for(faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t k = 0; k < 3; ++k) consider(faces[i], k, around, found[begin / kGrain]);
    });
    std::vector<EdgeFlip> flips;
    for (const auto& range : found) flips.insert(flips.end(), range.begin(), range.end());
    return flips;
  }

  void consider(std::uint32_t f, std::size_t k, const FacesAround& around,
                std::vector<EdgeFlip>& flips) const {
    const auto& face = mesh_.faces[f];
    EdgeFlip flip{0.0, face[k], face[(k + 1) % 3], face[(k + 2) % 3], 0, f, 0};
    const double length = (mesh_.vertices[flip.b] - mesh_.vertices[flip.a]).norm();
    const double least = std::max(kLeastGain * length, kNoise * options_.noise);
    const double now = sagitta(flip.a, flip.b);
    if (!(now > least) || !find_right(around, flip)) return;
    flip.gain = now - sagitta(flip.c, flip.d);
    if (flip.gain > least && !may_not_flip(flip) && allowed(flip) &&
        !joined(around, flip.c, flip.d))
      flips.push_back(flip);
  }

  // Finds the face beyond the edge; of the two faces the first one speaks.
  bool find_right(const FacesAround& around, EdgeFlip& flip) const {
    bool found = false;
    around.visit(flip.a, [&](std::uint32_t g) {
      const auto& face = mesh_.faces[g];
      for (std::size_t k = 0; k < 3 && g > flip.left; ++k) {
        if (face[k] != flip.b || face[(k + 1) % 3] != flip.a) continue;
        flip.d = face[(k + 2) % 3];
        flip.right = g;
        found = true;
      }
    });
    return found;
  }

  bool may_not_flip(const EdgeFlip& t) const {
    return fixed_[t.a] || fixed_[t.b] || fixed_[t.c] || fixed_[t.d];
  }

  bool allowed(const EdgeFlip& t) const {
    const Eigen::Vector3d mean = cross_of(mesh_, t.a, t.b, t.c) + cross_of(mesh_, t.b, t.a, t.d);
    for (const Eigen::Vector3d& n :
         {cross_of(mesh_, t.c, t.d, t.b), cross_of(mesh_, t.d, t.c, t.a)})
      if (!(n.dot(mean) > kTurn * n.norm() * mean.norm())) return false;
    const double before =
        std::min(least_angle(mesh_, t.a, t.b, t.c), least_angle(mesh_, t.b, t.a, t.d));
    const double after =
        std::min(least_angle(mesh_, t.c, t.d, t.b), least_angle(mesh_, t.d, t.c, t.a));
    return after >= std::min(before, kLeastAngle);
  }

  bool joined(const FacesAround& around, std::uint32_t c, std::uint32_t d) const {
    bool any = false;
    around.visit(c, [&](std::uint32_t f) {
      for (const std::uint32_t v : mesh_.faces[f]) any = any || v == d;
    });
    return any;
  }

  // Of the turns that share a face, or would make the same edge, the first one stays.
  void keep_apart(std::vector<EdgeFlip>& flips) const {
    PagedArray<std::uint8_t> taken(mesh_.faces.size());
    std::unordered_set<std::uint64_t> made;
    std::erase_if(flips, [&](const EdgeFlip& t) {
      if (taken[t.left] || taken[t.right]) return true;
      if (!made.insert(std::uint64_t{std::min(t.c, t.d)} << 32 | std::max(t.c, t.d)).second)
        return true;
      taken[t.left] = taken[t.right] = 1;
      return false;
    });
  }

  void apply(const EdgeFlip& t) {
    for (const std::uint32_t v : {t.a, t.b, t.c, t.d}) touched_[v] = 1;
    mesh_.faces[t.left] = {t.c, t.d, t.b};
    mesh_.faces[t.right] = {t.d, t.c, t.a};
  }

  TriangleMesh& mesh_;
  const CreaseEdgeOptions& options_;
  PagedArray<std::uint8_t> all_;      // Set for every vertex.
  PagedArray<std::uint8_t> fixed_;    // Vertices whose edges and whose faces' edges stay.
  PagedArray<std::uint8_t> touched_;  // Vertices with edges to look at in the next pass.
};

}  // namespace

std::size_t align_edges_with_creases(TriangleMesh& mesh, const CreaseEdgeOptions& options) {
  const std::size_t turned = CreaseEdges(mesh, options).run();
  mesh.normals = vertex_normals(mesh);
  return turned;
}

}  // namespace relief::fusion
