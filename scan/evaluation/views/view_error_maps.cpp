#include "scan/evaluation/views/view_error_maps.h"

#include <limits>

#include "relief/scan/discontinuities.h"
#include "scan/evaluation/base/angles.h"
#include "scan/grid/grid_normals.h"

namespace relief::evaluation {

namespace {

Grid<float> angles(const Grid<Eigen::Vector3f>& normals,
                   const Grid<Eigen::Vector3f>& true_normals) {
  Grid<float> result(normals.width(), normals.height(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < result.size(); ++i)
    if (normals[i].allFinite() && true_normals[i].allFinite())
      result[i] = static_cast<float>(angle_between_deg(normals[i], true_normals[i]));
  return result;
}

}  // namespace

ViewErrorMaps error_maps(const ViewAndTruth& pair) {
  const RangeView &view = *pair.view, &truth = *pair.truth;
  const GridEdges edges = connect_samples(truth);
  const Grid<Eigen::Vector3f> true_normals =
      truth.has_normals() ? truth.normals : finite_difference_normals(truth, edges);
  ViewErrorMaps maps;
  maps.name = view.name;
  maps.depth = {view.width(), view.height(), std::numeric_limits<float>::quiet_NaN()};
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v) && truth.has_sample(u, v))
        maps.depth(u, v) = static_cast<float>(depth_error(pair, u, v));
  maps.position_normals_deg = angles(finite_difference_normals(view, edges), true_normals);
  if (view.has_normals()) maps.map_normals_deg = angles(view.normals, true_normals);
  return maps;
}

}  // namespace relief::evaluation
