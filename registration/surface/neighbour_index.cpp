#include "registration/surface/neighbour_index.h"

#include <algorithm>
#include <cassert>

#include <flann/flann.hpp>

namespace relief::registration {

namespace {

flann::Matrix<float> as_rows(Eigen::Matrix3Xf& points) {
  return {points.data(), static_cast<std::size_t>(points.cols()), 3};
}

}  // namespace

struct NeighbourIndex::Tree {
  explicit Tree(const Eigen::Matrix3Xd& given)
      : centre(given.rowwise().mean()),
        points((given.colwise() - centre).cast<float>()),
        index(as_rows(points), flann::KDTreeSingleIndexParams(12)) {
    index.buildIndex();
  }

  Eigen::Vector3d centre;
  Eigen::Matrix3Xf points;
  flann::Index<flann::L2_Simple<float>> index;
};

NeighbourIndex::NeighbourIndex(const Eigen::Matrix3Xd& points) {
  assert(points.cols() > 0);
  tree_ = std::make_unique<Tree>(points);
}

NeighbourIndex::~NeighbourIndex() = default;
NeighbourIndex::NeighbourIndex(NeighbourIndex&&) noexcept = default;
NeighbourIndex& NeighbourIndex::operator=(NeighbourIndex&&) noexcept = default;

std::vector<int> NeighbourIndex::nearest(const Eigen::Matrix3Xd& queries) const {
  Eigen::Matrix3Xf centred = (queries.colwise() - tree_->centre).cast<float>();
  std::vector<int> indices(static_cast<std::size_t>(queries.cols()));
  std::vector<float> distances(indices.size());
  flann::Matrix<int> index_rows(indices.data(), indices.size(), 1);
  flann::Matrix<float> distance_rows(distances.data(), indices.size(), 1);
  flann::SearchParams exact(flann::FLANN_CHECKS_UNLIMITED);
  exact.cores = 1;
  tree_->index.knnSearch(as_rows(centred), index_rows, distance_rows, 1, exact);
  return indices;
}

std::vector<std::vector<int>> NeighbourIndex::neighbours_within(double radius) const {
  std::vector<std::vector<int>> neighbours;
  std::vector<std::vector<float>> distances;
  flann::SearchParams exact(flann::FLANN_CHECKS_UNLIMITED);
  exact.cores = 1;
  exact.sorted = false;
  tree_->index.radiusSearch(as_rows(tree_->points), neighbours, distances,
                            static_cast<float>(radius * radius), exact);
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    std::erase(neighbours[i], static_cast<int>(i));
    std::sort(neighbours[i].begin(), neighbours[i].end());
  }
  return neighbours;
}

}  // namespace relief::registration
