#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "scan/base/memory/paged_array.h"
#include "scan/base/parallel.h"

namespace relief {

/// Lists of values, one behind the other in a few paged arrays. Under a memory limit thousands of
/// short lists would each lie in memory, or need a file each. T as in PagedArray.
template <typename T>
class PagedLists {
 public:
  std::size_t size() const { return lists_.size(); }
  std::span<const T> operator[](std::size_t i) const { return lists_[i]; }

  /// Appends a copy of a list. Looks at the memory as loops do (parallel.h).
  void add(std::span<const T> list) {
    if (list.empty()) {
      lists_.emplace_back();
      return;
    }
    if (blocks_.empty() || blocks_.back().size() - used_ < list.size()) {
      check_stop_and_memory();
      blocks_.emplace_back(std::max(list.size(), std::min(kMostOfBlock, total_)));
      used_ = 0;
    }
    T* const begin = blocks_.back().data() + used_;
    std::copy(list.begin(), list.end(), begin);
    used_ += list.size();
    total_ += list.size();
    lists_.emplace_back(begin, list.size());
  }

 private:
  // A megabyte: few files, and little that stays unused. Changes no result.
  static constexpr std::size_t kMostOfBlock = (std::size_t{1} << 20) / sizeof(T);

  std::vector<PagedArray<T>> blocks_;
  std::size_t used_ = 0;   // Of the last block.
  std::size_t total_ = 0;  // Values of all lists.
  std::vector<std::span<const T>> lists_;
};

}  // namespace relief
