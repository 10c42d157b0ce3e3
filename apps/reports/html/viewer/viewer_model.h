#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "apps/reports/report.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// A model as the viewer of a report takes it: few faces, few bytes. Attribute vectors have one
/// entry per vertex, or none where the model lacks the attribute.
struct ViewerModel {
  /// Bounds of the positions [unit]. Position p is low + q / 65535 * (high - low), so it is off by
  /// no more than half a step of (high - low) / 65535 along each axis.
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  std::vector<std::array<std::uint16_t, 3>> positions;
  std::vector<TriangleMesh::Face> faces;
  double error_low = 0.0, error_high = 0.0;  ///< Expected errors of the bytes 0 and 255 [unit].
  std::vector<std::uint8_t> errors;
  std::vector<std::uint8_t> views;  ///< How many views measured the vertex; 255: that many or more.
  /// The view with the largest weight, by its index; kNoSourceView: none.
  std::vector<std::uint16_t> sources;
  std::vector<std::uint8_t> filled;  ///< 1: no view measured here.
  std::vector<std::array<std::uint8_t, 3>> colours;
  std::size_t faces_before = 0;  ///< Of the model before it was decimated.
};

/// `mesh` with no more than `faces` faces, as near as decimate_mesh() comes to them, in few bytes.
/// A mesh of more than half as many again is thinned by cluster_vertices() first. The vertices are
/// some of those of `mesh`, with their attributes. Errors: kUnsolvable when the mesh has no faces,
/// or cannot be decimated to less than twice that number.
Result<ViewerModel> make_viewer_model(const TriangleMesh& mesh, std::size_t faces);

/// All of it but the arrays, for the page.
Json to_json(const ViewerModel& model);

}  // namespace relief
