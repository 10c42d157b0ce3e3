#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "apps/reports/report.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// Where a view looked from, to draw it. Slopes are x/z and y/z of its outermost pixels.
struct ViewCamera {
  std::string name;
  Json world_from_view;  ///< Row-major 4x4 nested arrays; camera frame x right, y down.
  double left = -0.25, right = 0.25, top = -0.25, bottom = 0.25;
  double forward = 1.0;                      ///< Sign of z in front of the camera.
  std::optional<Eigen::Vector3d> direction;  ///< In its frame, of unit length; where it has one.
};

/// The camera of a view as scan.json or report.json has it; none without a pose. Cameras that are
/// no pinholes have a nominal opening.
std::optional<ViewCamera> view_camera(const Json& view);

/// For the page.
Json to_json(const ViewCamera& camera);

/// From where a model is shown first; unit vectors in the world.
struct InitialViewpoint {
  Eigen::Vector3d towards_viewer = Eigen::Vector3d(1.0, -1.0, 0.5).normalized();
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< An axis of the world, or its opposite.
};

/// Against the direction of the camera that faces most of what was measured, with the axis up that
/// is most upright for all cameras. Without directions, from one side and a little above.
InitialViewpoint initial_viewpoint(const TriangleMesh& mesh,
                                   const std::vector<ViewCamera>& cameras);

}  // namespace relief
