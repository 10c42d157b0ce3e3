#include "fusion/crease_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_set>
#include <vector>

#include <Eigen/Geometry>

#include "fusion/moved_faces.h"
#include "fusion/thin_plate.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr std::size_t kGrain = 4096;

// Memory for each vertex of the mesh [bytes].
constexpr std::size_t kVertex = 110;

// Turning the edges along one crease takes a few passes, since a face takes part in one turn of a
// pass only.
constexpr int kPasses = 4;

// What must be gained, in bulges (below) against the length of the edge: less is noise.
constexpr double kLeastGain = 0.03;

// Cosine of the largest angle between a new face and the mean of the old ones.
constexpr double kTurn = 0.5;

// New faces have no angle below the least of the old ones, or below this [rad].
constexpr double kLeastAngle = 15.0 * std::numbers::pi / 180.0;

// An edge from a to b and the corners opposite to it of its faces, left and right of it.
struct Turn {
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
      : mesh_(mesh), options_(options), all_(mesh.vertices.size(), 1) {}

  // How many edges were turned.
  std::size_t pass() {
    mesh_.normals = vertex_normals(mesh_);
    const FacesAround around(mesh_, all_);
    std::vector<Turn> turns = candidates(around);
    std::sort(turns.begin(), turns.end(), [](const Turn& s, const Turn& t) {
      return s.gain != t.gain ? s.gain > t.gain : s.left < t.left;
    });
    keep_apart(turns);
    for (const Turn& turn : turns) apply(turn);
    return turns.size() - undo_intersecting(turns);
  }

 private:
  // How far the surface leaves an edge: eight times the height of the arc over it that has the
  // normals of its ends.
  double bulge(std::uint32_t i, std::uint32_t j) const {
    return std::abs((mesh_.normals[i] - mesh_.normals[j])
                        .cast<double>()
                        .dot(mesh_.vertices[j] - mesh_.vertices[i]));
  }

  std::vector<Turn> candidates(const FacesAround& around) const {
    std::vector<std::vector<Turn>> found((mesh_.faces.size() + kGrain - 1) / kGrain);
    parallel_for(mesh_.faces.size(), kGrain, options_.threads,
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t f = begin; f < end; ++f)
                     for (std::size_t k = 0; k < 3; ++k)
                       consider(static_cast<std::uint32_t>(f), k, around, found[begin / kGrain]);
                 });
    std::vector<Turn> turns;
    for (const auto& range : found) turns.insert(turns.end(), range.begin(), range.end());
    return turns;
  }

  void consider(std::uint32_t f, std::size_t k, const FacesAround& around,
                std::vector<Turn>& turns) const {
    const auto& face = mesh_.faces[f];
    Turn turn{0.0, face[k], face[(k + 1) % 3], face[(k + 2) % 3], 0, f, 0};
    const double length = (mesh_.vertices[turn.b] - mesh_.vertices[turn.a]).norm();
    const double least = kLeastGain * length, now = bulge(turn.a, turn.b);
    if (!(now > least) || !find_right(around, turn)) return;
    turn.gain = now - bulge(turn.c, turn.d);
    if (turn.gain > least && allowed(turn) && !joined(around, turn.c, turn.d))
      turns.push_back(turn);
  }

  // Finds the face beyond the edge; of the two faces the first one speaks.
  bool find_right(const FacesAround& around, Turn& turn) const {
    bool found = false;
    around.visit(turn.a, [&](std::uint32_t g) {
      const auto& face = mesh_.faces[g];
      for (std::size_t k = 0; k < 3 && g > turn.left; ++k) {
        if (face[k] != turn.b || face[(k + 1) % 3] != turn.a) continue;
        turn.d = face[(k + 2) % 3];
        turn.right = g;
        found = true;
      }
    });
    return found;
  }

  bool allowed(const Turn& t) const {
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
  void keep_apart(std::vector<Turn>& turns) const {
    std::vector<std::uint8_t> taken(mesh_.faces.size());
    std::unordered_set<std::uint64_t> made;
    std::erase_if(turns, [&](const Turn& t) {
      if (taken[t.left] || taken[t.right]) return true;
      if (!made.insert(std::uint64_t{std::min(t.c, t.d)} << 32 | std::max(t.c, t.d)).second)
        return true;
      taken[t.left] = taken[t.right] = 1;
      return false;
    });
  }

  void apply(const Turn& t) {
    mesh_.faces[t.left] = {t.c, t.d, t.b};
    mesh_.faces[t.right] = {t.d, t.c, t.a};
  }

  void undo(const Turn& t) {
    mesh_.faces[t.left] = {t.a, t.b, t.c};
    mesh_.faces[t.right] = {t.b, t.a, t.d};
  }

  // Returns how many turns were taken back. That may make others intersect, hence the rounds.
  std::size_t undo_intersecting(std::vector<Turn> turns) {
    const std::size_t all = turns.size();
    for (std::size_t left = all + 1; turns.size() < left;) {
      left = turns.size();
      std::vector<std::uint32_t> faces;
      for (const Turn& t : turns) faces.insert(faces.end(), {t.left, t.right});
      const std::vector<std::uint32_t> bad =
          intersecting_faces(mesh_, faces, 2.0 * options_.voxel_size, options_.threads);
      const auto is_bad = [&](std::uint32_t f) {
        return std::binary_search(bad.begin(), bad.end(), f);
      };
      std::erase_if(turns, [&](const Turn& t) {
        if (!is_bad(t.left) && !is_bad(t.right)) return false;
        undo(t);
        return true;
      });
    }
    return all - turns.size();
  }

  TriangleMesh& mesh_;
  const CreaseEdgeOptions& options_;
  std::vector<std::uint8_t> all_;
};

}  // namespace

std::size_t align_edges_with_creases(TriangleMesh& mesh, const CreaseEdgeOptions& options) {
  relieve(options.memory, kVertex * mesh.vertices.size());
  CreaseEdges edges(mesh, options);
  std::size_t turned = 0;
  for (int pass = 0; pass < kPasses; ++pass) turned += edges.pass();
  mesh.normals = vertex_normals(mesh);
  return turned;
}

}  // namespace relief
