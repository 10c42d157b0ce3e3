#pragma once

#include "relief/scan/range_view.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::testing {

/// A view of a sphere, with normals (some unknown), confidences, deviations, colours and a pose
/// that is a guess.
RangeView coloured_view(const Camera& camera);

/// Cameras of each model that see the sphere of coloured_view.
std::vector<Camera> cameras_of_all_models();

/// A tetrahedron with all attributes of vertices.
TriangleMesh mesh_with_attributes();

/// Expects the same samples, normals, rays and pose, to `tolerance` of the distance of a point.
void expect_same_samples(const RangeView& found, const RangeView& given, double tolerance);

/// Expects equal faces and attributes, and vertices as close as that.
void expect_same_mesh(const TriangleMesh& found, const TriangleMesh& given, double tolerance);

}  // namespace relief::testing
