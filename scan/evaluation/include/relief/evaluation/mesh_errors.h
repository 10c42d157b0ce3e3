#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "relief/evaluation/error_statistics.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::evaluation {

struct MeshDistanceOptions {
  /// Points on each of the two meshes, >= 1. Bounds the time; fractions are told to 0.1 %.
  std::size_t samples = 200000;
  /// Distances of the F-score [unit]. Empty: 0.25, 0.5, 1 and 2 times `spacing`.
  std::vector<double> thresholds;
  /// The sample spacing of the scans [unit]; 0: the median edge length of the true mesh.
  double spacing = 0.0;
};

/// Distances from points of one mesh to the other.
struct DirectedDistance {
  ErrorStatistics distance;     ///< Exact Euclidean point to surface [unit].
  ErrorStatistics normals_deg;  ///< Angle between the surface normals at both ends [degrees].
  std::vector<double> within;   ///< For each threshold: the fraction of points at most so far.
};

/// One direction over the whole surface, and split by whether the result was measured or filled
/// there, where the result says so.
struct DistanceReport {
  DirectedDistance all;
  std::optional<DirectedDistance> measured, filled;
};

struct MeshComparison {
  /// From points of the result to the truth: how wrong what is there is. Split at the points.
  DistanceReport accuracy;
  /// From points of the truth to the result: how much of the object is missing. Split at the
  /// closest points of the result.
  DistanceReport completeness;
  std::vector<double> thresholds;  ///< [unit]
  std::vector<double> f_score;     ///< For each threshold: harmonic mean of the two `within`.
  double filled_fraction = 0.0;    ///< Of the result's area.
  /// The distances behind the statistics, point by point [unit]: from the result to the truth, with
  /// the sign of signed_distances, and from the truth to the result.
  std::vector<double> signed_accuracy, completeness_distances;
};

/// Compares a mesh with the true one, in the same frame. Normals are those of the result's faces,
/// blended over each face by area-weighted vertex normals; of the truth, its own vertex normals if
/// it has them. The seed of the context chooses the points. kBadInput when a mesh has no area or a
/// vertex that is not finite.
Result<MeshComparison> compare_meshes(const TriangleMesh& result, const TriangleMesh& truth,
                                      const MeshDistanceOptions& options = {},
                                      const Context& context = {});

/// Distances between two meshes of one object, neither of which is the truth.
struct MutualDistances {
  /// From points of one mesh to the surface of the other. Split at the points, where the mesh that
  /// they lie on says what was filled.
  DistanceReport a_to_b, b_to_a;
  std::vector<double> thresholds;  ///< Of both reports' `within` [unit].
};

/// Compares two meshes in the same frame, both in the same way: normals are those of the faces,
/// blended by area-weighted vertex normals. The default spacing is the larger of the meshes' median
/// edge lengths. The seed of the context chooses the points. kBadInput when a mesh has no area or a
/// vertex that is not finite.
Result<MutualDistances> mutual_distances(const TriangleMesh& a, const TriangleMesh& b,
                                         const MeshDistanceOptions& options = {},
                                         const Context& context = {});

/// For each vertex of `mesh` its distance to `truth` [unit], negative inside (with the angle
/// weighted normals of Baerentzen and Aanaes 2005, so the sign is right at edges and corners too).
/// `truth` must be closed for the sign to have a meaning, and have at least one face.
std::vector<double> signed_distances(const TriangleMesh& mesh, const TriangleMesh& truth);

struct MeshAlignmentOptions {
  /// Points of the result in the final fit, >= 100. Bounds the time.
  std::size_t samples = 20000;
  /// Also try starts all over the rotations, with the centroids in one place, not only the
  /// identity: for results whose frame is any other. Costs some seconds.
  bool any_start = true;
};

struct MeshAlignment {
  RigidMotion truth_from_result = RigidMotion::Identity();
  double median_distance = 0.0;  ///< Of the result's points to the truth after the motion [unit].
  int iterations = 0;            ///< Of the final fit.
  bool converged = false;        ///< The last step was negligible.
};

/// The rigid motion that brings a mesh onto the true one: point-to-plane ICP (Chen and Medioni
/// 1992) with exact closest points and Tukey weights, so that parts which only one mesh has do not
/// pull. A good fit has a small median distance; symmetric objects have several. The seed of the
/// context chooses the points. kBadInput when a mesh has no area.
Result<MeshAlignment> align_mesh(const TriangleMesh& result, const TriangleMesh& truth,
                                 const MeshAlignmentOptions& options = {},
                                 const Context& context = {});

}  // namespace relief::evaluation
