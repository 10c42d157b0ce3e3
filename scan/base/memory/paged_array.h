#pragma once

#include <cassert>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "relief/scan/page_allocator.h"
#include "scan/base/memory/memory_limit.h"

namespace relief {

/// A fixed number of values, all bits zero at first: in memory, or, under a limit that is not
/// ample, in a file that is mapped to memory. What was never written takes no memory. T is plain
/// data for which zero bits are a value.
template <typename T>
class PagedArray {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  PagedArray() = default;
  /// Under the limit of the enclosing run_in(), if it has one.
  explicit PagedArray(std::size_t count) : PagedArray(count, current_memory_limit()) {
    owner_ = shared_memory_limit();
  }
  /// `limit` may be null and must outlive the array.
  PagedArray(std::size_t count, MemoryLimit* limit) : count_(count) {
    if (count == 0) return;
    if (limit && bytes() >= kSmallArray) limit_ = limit;
    if (limit_ && !limit_->keep_in_memory(bytes())) data_ = static_cast<T*>(limit_->map(bytes()));
    // Also when there is no file, which the limit's check() tells.
    if (!data_) data_ = static_cast<T*>(std::calloc(count, sizeof(T)));
    if (!data_) throw std::bad_alloc();
  }
  PagedArray(PagedArray&& other) noexcept { *this = std::move(other); }
  PagedArray& operator=(PagedArray&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(count_, other.count_);
    std::swap(limit_, other.limit_);
    std::swap(owner_, other.owner_);
    return *this;
  }
  ~PagedArray() {
    if (!limit_ || !limit_->release(data_, bytes())) std::free(data_);
  }

  std::size_t size() const { return count_; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T* begin() { return data_; }
  const T* begin() const { return data_; }
  T* end() { return data_ + count_; }
  const T* end() const { return data_ + count_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::span<T> span() { return {data_, count_}; }
  std::span<const T> span() const { return {data_, count_}; }

 private:
  std::size_t bytes() const { return count_ * sizeof(T); }

  T* data_ = nullptr;
  std::size_t count_ = 0;
  MemoryLimit* limit_ = nullptr;        // Null for small arrays, and where there is none.
  std::shared_ptr<MemoryLimit> owner_;  // Of a limit that may end before the array.
};

/// A dense image of `width` columns and `height` rows, stored row by row in a PagedArray.
template <typename T>
class PagedGrid {
 public:
  PagedGrid() = default;
  PagedGrid(int width, int height, MemoryLimit* limit)
      : width_(width),
        height_(height),
        values_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), limit) {}

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t size() const { return values_.size(); }
  bool empty() const { return size() == 0; }
  T& operator()(int u, int v) { return values_[index(u, v)]; }
  const T& operator()(int u, int v) const { return values_[index(u, v)]; }
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }

 private:
  std::size_t index(int u, int v) const {
    assert(u >= 0 && v >= 0 && u < width_ && v < height_);
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u);
  }

  int width_ = 0;
  int height_ = 0;
  PagedArray<T> values_;
};

}  // namespace relief
