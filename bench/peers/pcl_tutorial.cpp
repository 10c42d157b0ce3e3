// Registers clouds of a depth camera one after the other, as PCL's tutorial "How to incrementally
// register pairs of clouds" does: non-linear ICP of points and their curvature.
//
//   relief_pcl_tutorial CLOUDS_FOLDER OUTPUT.json
//
// All numbers are the tutorial's, which are for rooms in metres: voxels of 0.05, normals of 30
// neighbours, correspondences up to 0.1, less by 0.001 whenever a step is below 1e-6, thirty rounds
// of two iterations. Clouds follow each other by their names. Writes per view the motion that
// brings its cloud into place.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_representation.h>
#include <pcl/registration/icp_nl.h>
#include <pcl/search/kdtree.h>

namespace {

using nlohmann::json;
using Points = pcl::PointCloud<pcl::PointXYZ>;
using Cloud = pcl::PointCloud<pcl::PointNormal>;

class PointAndCurvature : public pcl::PointRepresentation<pcl::PointNormal> {
 public:
  PointAndCurvature() {
    nr_dimensions_ = 4;
    const float weights[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    setRescaleValues(weights);
  }
  void copyToFloatArray(const pcl::PointNormal& point, float* out) const override {
    out[0] = point.x;
    out[1] = point.y;
    out[2] = point.z;
    out[3] = point.curvature;
  }
};

Cloud::Ptr prepared(const Points::Ptr& points) {
  Points::Ptr few(new Points);
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(0.05f, 0.05f, 0.05f);
  grid.setInputCloud(points);
  grid.filter(*few);
  Cloud::Ptr cloud(new Cloud);
  pcl::NormalEstimation<pcl::PointXYZ, pcl::PointNormal> normals;
  normals.setSearchMethod(
      pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
  normals.setKSearch(30);
  normals.setInputCloud(few);
  normals.compute(*cloud);
  pcl::copyPointCloud(*few, *cloud);
  return cloud;
}

// The motion that brings the target to the source, as in the tutorial, turned round.
Eigen::Matrix4f source_from_target(const Cloud::Ptr& source, const Cloud::Ptr& target) {
  pcl::IterativeClosestPointNonLinear<pcl::PointNormal, pcl::PointNormal> icp;
  icp.setTransformationEpsilon(1e-6);
  icp.setMaxCorrespondenceDistance(0.1);
  icp.setPointRepresentation(pcl::make_shared<const PointAndCurvature>());
  icp.setInputSource(source);
  icp.setInputTarget(target);
  icp.setMaximumIterations(2);
  Eigen::Matrix4f motion = Eigen::Matrix4f::Identity(), previous = motion;
  Cloud::Ptr moved = source;
  for (int round = 0; round < 30; ++round) {
    const Cloud::Ptr start = moved;
    moved.reset(new Cloud);
    icp.setInputSource(start);
    icp.align(*moved);
    motion = icp.getFinalTransformation() * motion;
    const Eigen::Matrix4f step = icp.getLastIncrementalTransformation();
    if (std::abs((step - previous).sum()) < icp.getTransformationEpsilon())
      icp.setMaxCorrespondenceDistance(icp.getMaxCorrespondenceDistance() - 0.001);
    previous = step;
  }
  return motion.inverse();
}

json to_json(const Eigen::Matrix4f& matrix) {
  json rows = json::array();
  for (int r = 0; r < 4; ++r) {
    rows.push_back(json::array());
    for (int c = 0; c < 4; ++c) rows.back().push_back(matrix(r, c));
  }
  return rows;
}

int run(const std::string& folder, const char* output_path) {
  const json description = json::parse(std::ifstream(folder + "/clouds.json"));
  std::vector<json> views = description["views"];
  std::sort(views.begin(), views.end(), [](const json& a, const json& b) {
    return a["name"].get<std::string>() < b["name"].get<std::string>();
  });
  json output;
  Eigen::Matrix4f motion = Eigen::Matrix4f::Identity();
  Cloud::Ptr before;
  for (const json& view : views) {
    Points::Ptr points(new Points);
    if (pcl::io::loadPCDFile(folder + "/" + view["stem"].get<std::string>() + ".pcd", *points) != 0)
      return 2;
    const Cloud::Ptr cloud = prepared(points);
    if (before) motion = motion * source_from_target(before, cloud);
    output["motions"][view["name"].get<std::string>()] = to_json(motion);
    before = cloud;
  }
  std::ofstream(output_path) << output;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: relief_pcl_tutorial CLOUDS_FOLDER OUTPUT.json\n";
    return 2;
  }
  return run(argv[1], argv[2]);
}
