// Where the page of a report looks first.
#include "apps/reports/html/viewer/view_camera.h"

#include <gtest/gtest.h>

namespace relief {
namespace {

// One camera frame: x right, y down, z forward, or with OpenGL's y up and z back.
Json view_at(const Eigen::Vector3d& place, const Eigen::Vector3d& right,
             const Eigen::Vector3d& second, const char* model) {
  const Eigen::Vector3d third = right.cross(second);
  Json rows = Json::array();
  for (int k = 0; k < 3; ++k) rows.push_back({right[k], second[k], third[k], place[k]});
  rows.push_back({0, 0, 0, 1});
  return {{"name", "view"}, {"world_from_view", rows}, {"camera", {{"model", model}}}};
}

std::vector<ViewCamera> cameras_of(const std::vector<Json>& views) {
  std::vector<ViewCamera> cameras;
  for (const Json& view : views) cameras.push_back(view_camera(view).value());
  return cameras;
}

// A plate of two triangles on each side; the lower side, whose normal is -z, is filled.
TriangleMesh plate() {
  TriangleMesh mesh;
  for (const double z : {0.1, 0.0})
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
      mesh.vertices.emplace_back(x, y, z);
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
  mesh.filled = {0, 0, 0, 0, 1, 1, 1, 1};
  return mesh;
}

TEST(InitialViewpoint, LooksAsTheCameraThatFacesMostOfWhatWasMeasured) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  const auto cameras =
      cameras_of({view_at({0, 0, -5}, x, y, "pinhole"), view_at({3, 0, 3}, z, y, "pinhole"),
                  view_at({1, 0, 5}, x, -y, "pinhole")});
  EXPECT_EQ(initial_viewpoint(plate(), cameras).towards_viewer, z);
}

TEST(InitialViewpoint, IsUprightForBothKindsOfCameras) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  const TriangleMesh mesh = plate();
  EXPECT_EQ(initial_viewpoint(mesh, cameras_of({view_at({0, 0, 5}, x, -y, "pinhole")})).up, y);
  EXPECT_EQ(initial_viewpoint(mesh, cameras_of({view_at({0, 0, 5}, x, y, "pinhole_gl")})).up, y);
  EXPECT_EQ(initial_viewpoint(mesh, cameras_of({view_at({0, 0, 5}, -x, -y, "pinhole_gl")})).up, -y);
}

TEST(InitialViewpoint, FollowsTheDirectionThatOtherCamerasState) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  Json view = view_at({0, 0, 0}, x, y, "rational");
  view["camera"]["view_direction"] = {0.0, -0.6, -0.8};
  const auto found = initial_viewpoint(plate(), cameras_of({view}));
  EXPECT_LT((found.towards_viewer - Eigen::Vector3d(0.0, 0.6, 0.8)).norm(), 1e-12);
  EXPECT_EQ(found.up, y);
}

TEST(InitialViewpoint, DoesNotGuessWhereOtherCamerasLook) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  Json view = view_at({0, 0, -5}, x, y, "rational");
  for (const Json& stated : {Json(), Json(1.0), Json({0, 0, 0}), Json({0, "x", 1})}) {
    view["camera"]["view_direction"] = stated;
    const auto found = initial_viewpoint(plate(), cameras_of({view}));
    EXPECT_EQ(found.up, Eigen::Vector3d::UnitZ());
    EXPECT_EQ(found.towards_viewer, InitialViewpoint().towards_viewer);
  }
}

TEST(InitialViewpoint, NeedsNoCamera) {
  const InitialViewpoint viewpoint = initial_viewpoint(plate(), {});
  EXPECT_EQ(viewpoint.up, Eigen::Vector3d::UnitZ());
  EXPECT_NEAR(viewpoint.towards_viewer.norm(), 1.0, 1e-12);
  EXPECT_TRUE(initial_viewpoint({}, {}).towards_viewer.allFinite());
  EXPECT_FALSE(view_camera({{"world_from_view", {1, 2}}}));
}

}  // namespace
}  // namespace relief
