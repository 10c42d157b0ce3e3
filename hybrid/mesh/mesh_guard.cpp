#include "hybrid/mesh/mesh_guard.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/Geometry>

#include "relief/scan/mesh_check.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"
#include "scan/mesh/moved_faces.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kGrain = 4096;  // Faces of one piece of work; changes no result.
// Fraction of its way: with less a vertex stays where it was. Ways are halved, so any value above
// 1/16 and up to 1/8 does the same.
constexpr float kLeastScale = 0.1f;
// Fraction of a face's area that must stay: far above the rounding of floats (1e-7). All checks
// hold back 0.5 % of the vertices of views not refined (docs/results.md, Polishing merged meshes).
constexpr double kLeastArea = 0.01;
// Cosine of 60 degrees: faces that near to the normal of one surface are at most 120 apart, so none
// folds back onto another.
constexpr double kTurn = 0.5;
// Searches for intersections cost more than other checks. As many halvings take a vertex back to
// where it was: after them, what still intersects goes there at once.
constexpr int kPatientSearches = 4;

// Whether a face may change from one cross product to another, lying in a surface of that normal.
bool sound(const Eigen::Vector3d& before, const Eigen::Vector3d& after,
           const Eigen::Vector3d& around) {
  const double old_size = before.norm(), size = after.norm();
  if (!(size > kLeastArea * old_size)) return false;
  const double turn = before.dot(after);
  if (!(turn > 0.0)) return false;
  return turn > kTurn * old_size * size || after.dot(around) > kTurn * size * around.norm();
}

class Guard {
 public:
  Guard(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> displacements)
      : before_(mesh),
        displacements_(displacements),
        normals_(vertex_normals(mesh)),
        scale_(paged_filled(mesh.vertices.size(), 1.0f)),
        changed_(mesh.vertices.size()) {
    moved_.vertices = paged_copy(mesh.vertices);
    moved_.faces = paged_copy(mesh.faces);
  }

  GuardedMove run() {
    GuardedMove move;
    bool damped = true;
    for (int searches = 0; damped; ++searches) {
      do {
        apply();
        ++move.rounds;
      } while (damp(unsound_faces(), 0.5f));
      const auto faces = searches == 0 ? all_intersecting_faces() : newly_intersecting_faces();
      damped = damp(faces, searches < kPatientSearches ? 0.5f : 0.0f);
    }
    for (const float s : scale_) {
      move.damped += s < 1.0f;
      move.unmoved += s == 0.0f;
    }
    move.vertices = std::move(moved_.vertices);
    return move;
  }

 private:
  void apply() {
    parallel_for(scale_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        moved_.vertices[i] = before_.vertices[i] + double{scale_[i]} * displacements_[i];
    });
  }

  std::vector<std::uint32_t> unsound_faces() const {
    PagedArray<std::uint8_t> unsound(moved_.faces.size());
    parallel_for(unsound.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        Eigen::Vector3d around = Eigen::Vector3d::Zero();
        for (const std::uint32_t v : before_.faces[f]) around += normals_[v].cast<double>();
        unsound[f] = !sound(face_cross(before_, f), face_cross(moved_, f), around);
      }
    });
    std::vector<std::uint32_t> faces;
    for (std::size_t f = 0; f < unsound.size(); ++f)
      if (unsound[f]) faces.push_back(static_cast<std::uint32_t>(f));
    return faces;
  }

  std::vector<std::uint32_t> all_intersecting_faces() {
    std::fill(changed_.begin(), changed_.end(), 0);
    SelfIntersectionOptions options;
    return find_self_intersections(moved_, options).faces();
  }

  // Those that vertices damped since the last search may have brought to intersect, and more.
  std::vector<std::uint32_t> newly_intersecting_faces() {
    PagedVector<std::uint32_t> faces = faces_at(moved_, changed_);
    std::fill(changed_.begin(), changed_.end(), 0);
    const double edge =
        std::sqrt(2.0 * surface_area(before_) / static_cast<double>(before_.faces.size()));
    return intersecting_faces(moved_, std::move(faces), 2.0 * edge);
  }

  // True if some vertex of the faces did move, and now moves less.
  bool damp(const std::vector<std::uint32_t>& faces, float factor) {
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t f : faces)
      vertices.insert(vertices.end(), before_.faces[f].begin(), before_.faces[f].end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    bool any = false;
    for (const std::uint32_t v : vertices) {
      if (scale_[v] == 0.0f) continue;
      scale_[v] = scale_[v] * factor < kLeastScale ? 0.0f : scale_[v] * factor;
      changed_[v] = 1;
      any = true;
    }
    return any;
  }

  const TriangleMesh& before_;
  std::span<const Eigen::Vector3d> displacements_;
  PagedVector<Eigen::Vector3f> normals_;
  PagedVector<float> scale_;
  PagedArray<std::uint8_t> changed_;  // Damped since the last search for intersections.
  TriangleMesh moved_;
};

}  // namespace

GuardedMove guarded_move(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> displacements) {
  return Guard(mesh, displacements).run();
}

}  // namespace relief::hybrid
