#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/triangle_mesh.h"

namespace relief {

/// Counts of values in bins of equal width.
struct Histogram {
  double low = 0.0, high = 0.0;  ///< Range of the bins; values above are in the last one.
  std::vector<std::size_t> counts;
};

/// A connected part of the surface that no view measured.
struct FilledRegion {
  double area = 0.0;                                  ///< [unit^2]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< Mean over its area [unit].
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();  ///< Mean normal; short if it faces all round.
};

/// What the pages of a report say of a model beyond its report.json.
struct ModelStatistics {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(),
                  high = Eigen::Vector3d::Zero();  ///< Bounds [unit].
  double area = 0.0;                               ///< [unit^2]
  /// Of the measured vertices [unit]; nothing if the model has no expected errors.
  std::optional<Histogram> expected_error;
  double median_error = 0.0, error_p95 = 0.0;  ///< [unit]
  std::vector<std::size_t> vertices_by_views;  ///< How many vertices 0, 1, 2 ... views measured.
  std::vector<FilledRegion> regions;           ///< The largest first.
};

/// `mesh` must have vertices and faces. Attributes that it lacks are left out.
ModelStatistics measure_model(const TriangleMesh& mesh);

/// The value below which `fraction` of `values` lie. `values` must not be empty; it is reordered.
float quantile(std::vector<float>& values, double fraction);

/// Expected errors of the vertices that a view measured; empty if the mesh has none.
std::vector<float> measured_errors(const TriangleMesh& mesh);

}  // namespace relief
