#include "fusion/mesh/small_handles.h"

#include <map>
#include <vector>

#include "fusion/mesh/cube_patches.h"

namespace relief::fusion {

namespace {

using Cell = CubePatches::Cell;

// Takes the cubes that touch `cell`, and those that touch these, out of `handles`.
std::vector<Cell> take_region(const Cell& cell, std::map<Cell, long>& handles, long& in_region) {
  std::vector<Cell> region = {cell};
  in_region = handles.at(cell);
  handles.erase(cell);
  for (std::size_t i = 0; i < region.size(); ++i)
    for (int k = 0; k < 27; ++k) {
      const auto [x, y, z] = region[i];
      const Cell beside = {x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1};
      const auto found = handles.find(beside);
      if (found == handles.end()) continue;
      in_region += found->second;
      handles.erase(found);
      region.push_back(beside);
    }
  return region;
}

}  // namespace

SmallHandles find_small_handles(const TriangleMesh& mesh, double side) {
  SmallHandles result;
  if (mesh.faces.empty()) return result;
  const CubePatches patches(mesh, side);
  std::map<Cell, long> handles;
  double area = 0.0, area_of_all = 0.0;
  for (const CubePatch& patch : patches.all()) {
    area_of_all += patch.area;
    const long genus = patch.genus();
    if (genus <= 0) continue;
    result.count += static_cast<std::size_t>(genus);
    area += patch.area;
    handles[patches.cell_of(patch.first_face)] += genus;
  }
  if (area_of_all > 0.0) result.area_fraction = area / area_of_all;
  while (!handles.empty()) {
    long in_region = 0;
    const auto region = take_region(handles.begin()->first, handles, in_region);
    if (static_cast<std::size_t>(in_region) <= result.in_region) continue;
    result.in_region = static_cast<std::size_t>(in_region);
    result.region.setEmpty();
    for (const Cell& cell : region) result.region.extend(patches.cube(cell));
  }
  return result;
}

}  // namespace relief::fusion
