// Registers clouds two at a time along a tree of pairs by PCL's point-to-plane ICP, as
// bench/peers/open3d_align.py does by Open3D's.
//
//   relief_pcl_align CLOUDS_FOLDER OUTPUT.json
//
// The clouds stand in the world by their starting poses, so every pair starts from the identity.
// Voxels, distances and normals from coarse to fine are those of open3d_align.py. An ICP ends after
// 30 iterations or when a step moves by less than a hundredth of the sample spacing: PCL's own
// default never ends before the iterations do.

#include <cmath>
#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>
#include <pcl/registration/icp.h>

namespace {

using nlohmann::json;
using Cloud = pcl::PointCloud<pcl::PointNormal>;

constexpr double kDistance = 3.0;  // [voxels]
constexpr double kNormalRadius = 2.0;

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<double> voxel_sizes(double spacing, double size) {
  std::vector<double> sizes = {0.01 * size};
  while (sizes.back() > 1.5 * spacing) sizes.push_back(std::max(sizes.back() / 2.0, spacing));
  return sizes;
}

Cloud::Ptr thinned(const pcl::PointCloud<pcl::PointXYZ>::Ptr& cloud, double voxel) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr few(new pcl::PointCloud<pcl::PointXYZ>);
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(cloud);
  const auto edge = static_cast<float>(voxel);
  grid.setLeafSize(edge, edge, edge);
  grid.filter(*few);
  Cloud::Ptr oriented(new Cloud);
  pcl::copyPointCloud(*few, *oriented);
  pcl::NormalEstimation<pcl::PointXYZ, pcl::PointNormal> normals;
  normals.setInputCloud(few);
  normals.setRadiusSearch(kNormalRadius * voxel);
  normals.compute(*oriented);
  // Points without neighbours have no normal, and ICP needs one of each.
  std::vector<int> unused;
  oriented->is_dense = false;
  pcl::removeNaNNormalsFromPointCloud(*oriented, *oriented, unused);
  return oriented;
}

Eigen::Matrix4f register_pair(const std::vector<Cloud::Ptr>& source,
                              const std::vector<Cloud::Ptr>& target,
                              const std::vector<double>& sizes, double spacing) {
  Eigen::Matrix4f motion = Eigen::Matrix4f::Identity();
  for (std::size_t level = 0; level < sizes.size(); ++level) {
    pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
    icp.setInputSource(source[level]);
    icp.setInputTarget(target[level]);
    icp.setMaxCorrespondenceDistance(kDistance * sizes[level]);
    icp.setMaximumIterations(30);
    icp.setTransformationEpsilon(std::pow(0.01 * spacing, 2));
    icp.setTransformationRotationEpsilon(1.0 - 1e-10);
    Cloud moved;
    icp.align(moved, motion);
    motion = icp.getFinalTransformation();
  }
  return motion;
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
  std::vector<pcl::PointCloud<pcl::PointXYZ>::Ptr> clouds;
  for (const json& view : description["views"]) {
    clouds.emplace_back(new pcl::PointCloud<pcl::PointXYZ>);
    const std::string path = folder + "/" + view["stem"].get<std::string>() + ".pcd";
    if (pcl::io::loadPCDFile(path, *clouds.back()) != 0) return 2;
  }
  const double read = processor_seconds();
  const double spacing = description["spacing"].get<double>();
  const auto sizes = voxel_sizes(spacing, description["size"].get<double>());
  std::vector<std::vector<Cloud::Ptr>> pyramids(clouds.size());
  for (std::size_t i = 0; i < clouds.size(); ++i)
    for (const double voxel : sizes) pyramids[i].push_back(thinned(clouds[i], voxel));
  const double prepared = processor_seconds();
  std::vector<Eigen::Matrix4f> motions(clouds.size(), Eigen::Matrix4f::Identity());
  for (const json& edge : description["tree"]) {
    const auto source = edge[0].get<std::size_t>(), target = edge[1].get<std::size_t>();
    motions[source] =
        motions[target] * register_pair(pyramids[source], pyramids[target], sizes, spacing);
  }
  json output = {{"reading_seconds", read},
                 {"preparing_seconds", prepared - read},
                 {"pairs_seconds", processor_seconds() - prepared}};
  for (std::size_t i = 0; i < motions.size(); ++i)
    output["motions"][description["views"][i]["name"].get<std::string>()] = to_json(motions[i]);
  std::ofstream(output_path) << output;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: relief_pcl_align CLOUDS_FOLDER OUTPUT.json\n";
    return 2;
  }
  return run(argv[1], argv[2]);
}
