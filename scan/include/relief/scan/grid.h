#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "relief/scan/page_allocator.h"

namespace relief {

/// A dense image of `width` columns (index u) and `height` rows (index v), stored row by row. Under
/// the memory limit of a context the pixels of large ones lie in files (page_allocator.h).
template <typename T>
class Grid {
 public:
  Grid() = default;
  Grid(int width, int height, const T& value = T())
      : width_(width),
        height_(height),
        data_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value) {
    assert(width >= 0 && height >= 0);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t size() const { return data_.size(); }
  bool empty() const { return data_.empty(); }

  bool contains(int u, int v) const { return u >= 0 && v >= 0 && u < width_ && v < height_; }
  std::size_t index(int u, int v) const {
    assert(contains(u, v));
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u);
  }

  decltype(auto) operator()(int u, int v) { return data_[index(u, v)]; }
  decltype(auto) operator()(int u, int v) const { return data_[index(u, v)]; }
  decltype(auto) operator[](std::size_t i) { return data_[i]; }
  decltype(auto) operator[](std::size_t i) const { return data_[i]; }

  T* data() { return data_.data(); }
  const T* data() const { return data_.data(); }
  auto begin() { return data_.begin(); }
  auto end() { return data_.end(); }
  auto begin() const { return data_.begin(); }
  auto end() const { return data_.end(); }

  template <typename U>
  bool same_size(const Grid<U>& other) const {
    return width_ == other.width() && height_ == other.height();
  }

 private:
  int width_ = 0;
  int height_ = 0;
  PagedVector<T> data_;
};

/// Red, green, blue as they stand in files, commonly sRGB.
using Colour = std::array<std::uint8_t, 3>;

}  // namespace relief
