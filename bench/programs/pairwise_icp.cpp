// Registers the views of a project two at a time along a tree of pairs, as the peers of the
// alignment benchmark do, and writes the motion of each view with the processor time spent.
//
//   relief_pairwise_icp PROJECT CLOUDS.json OUTPUT.json
//
// CLOUDS.json is the description that bench/peers/clouds.py writes: the names of the views and the
// tree of greatest overlaps. Every pair starts from the poses of the project and is registered by
// its geometry alone, as the peers do it.

#include <ctime>
#include <fstream>
#include <iostream>
#include <vector>

#include <nlohmann/json.hpp>

#include "registration/pairwise/icp.h"
#include "registration/surface/view_surface.h"
#include "relief/io/project_io.h"

namespace {

using nlohmann::json;

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

json to_json(const relief::RigidMotion& motion) {
  json rows = json::array();
  for (int r = 0; r < 4; ++r) {
    rows.push_back(json::array());
    for (int c = 0; c < 4; ++c) rows.back().push_back(motion.matrix()(r, c));
  }
  return rows;
}

int run(const char* project_path, const char* clouds_path, const char* output_path) {
  const auto project = relief::read_project(project_path);
  if (!project) {
    std::cerr << project.error().message << '\n';
    return 2;
  }
  const json clouds = json::parse(std::ifstream(clouds_path));
  const double read = processor_seconds();
  std::vector<relief::registration::ViewSurface> surfaces;
  relief::registration::ViewSurfaceOptions geometry;
  geometry.normal_signal = false;
  for (const auto& view : project->views) surfaces.emplace_back(view, geometry);
  const double prepared = processor_seconds();
  std::vector<relief::RigidMotion> motions(surfaces.size(), relief::RigidMotion::Identity());
  for (const json& edge : clouds["tree"]) {
    const auto source = edge[0].get<std::size_t>(), target = edge[1].get<std::size_t>();
    const auto& from = project->views[source].world_from_view;
    const auto& to = project->views[target].world_from_view;
    const auto found =
        relief::registration::align_pair(surfaces[source], surfaces[target], to.inverse() * from);
    motions[source] = motions[target] * to * found.target_from_source * from.inverse();
  }
  json output = {{"reading_seconds", read},
                 {"preparing_seconds", prepared - read},
                 {"pairs_seconds", processor_seconds() - prepared}};
  for (std::size_t i = 0; i < motions.size(); ++i)
    output["motions"][clouds["views"][i]["name"].get<std::string>()] = to_json(motions[i]);
  std::ofstream(output_path) << output;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: relief_pairwise_icp PROJECT CLOUDS.json OUTPUT.json\n";
    return 2;
  }
  return run(argv[1], argv[2], argv[3]);
}
