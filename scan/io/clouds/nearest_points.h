#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace relief {

/// Nearest neighbours among points of a plane or of space: a k-d tree with medians in place. Keeps
/// a reference to `points`, at most 2^32 of them, all finite.
template <int kDimensions>
class NearestPoints {
 public:
  using Point = Eigen::Matrix<double, kDimensions, 1>;
  struct Neighbour {
    double squared_distance = 0.0;
    std::uint32_t index = 0;
    bool operator<(const Neighbour& other) const {
      return std::pair(squared_distance, index) < std::pair(other.squared_distance, other.index);
    }
  };

  explicit NearestPoints(const std::vector<Point>& points)
      : points_(points), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    axes_.resize(points.size());
    sort(0, order_.size());
  }

  /// The `count` points nearest to `query`, the nearest first; fewer where there are fewer. Points
  /// at the place of `query` itself are not among them.
  std::vector<Neighbour> find(const Point& query, std::size_t count) const {
    std::vector<Neighbour> heap;
    heap.reserve(count + 1);
    visit(0, order_.size(), query, count, heap);
    std::sort_heap(heap.begin(), heap.end());
    return heap;
  }

 private:
  static constexpr std::size_t kLeaf = 12;  // Points in a range that is not divided further.

  void sort(std::size_t begin, std::size_t end) {
    while (end - begin > kLeaf) {
      Point low = points_[order_[begin]], high = low;
      for (std::size_t i = begin; i < end; ++i) {
        low = low.cwiseMin(points_[order_[i]]);
        high = high.cwiseMax(points_[order_[i]]);
      }
      Eigen::Index axis = 0;
      (high - low).maxCoeff(&axis);
      const std::size_t middle = begin + (end - begin) / 2;
      const auto at = [&](std::size_t i) {
        return order_.begin() + static_cast<std::ptrdiff_t>(i);
      };
      std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
        return points_[a][axis] < points_[b][axis];
      });
      axes_[middle] = static_cast<std::uint8_t>(axis);
      sort(begin, middle);
      begin = middle + 1;
    }
  }

  void offer(std::uint32_t index, const Point& query, std::size_t count,
             std::vector<Neighbour>& heap) const {
    const Neighbour neighbour{(points_[index] - query).squaredNorm(), index};
    if (neighbour.squared_distance == 0.0) return;
    if (heap.size() == count && !(neighbour < heap.front())) return;
    heap.push_back(neighbour);
    std::push_heap(heap.begin(), heap.end());
    if (heap.size() <= count) return;
    std::pop_heap(heap.begin(), heap.end());
    heap.pop_back();
  }

  void visit(std::size_t begin, std::size_t end, const Point& query, std::size_t count,
             std::vector<Neighbour>& heap) const {
    if (end - begin <= kLeaf) {
      for (std::size_t i = begin; i < end; ++i) offer(order_[i], query, count, heap);
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    const double offset = query[axes_[middle]] - points_[order_[middle]][axes_[middle]];
    const bool below = offset < 0.0;
    visit(below ? begin : middle + 1, below ? middle : end, query, count, heap);
    offer(order_[middle], query, count, heap);
    if (heap.size() == count && offset * offset > heap.front().squared_distance) return;
    visit(below ? middle + 1 : begin, below ? end : middle, query, count, heap);
  }

  const std::vector<Point>& points_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint8_t> axes_;
};

}  // namespace relief
