#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <queue>
#include <tuple>
#include <vector>

namespace relief::fusion {

/// An edge that may collapse: its vertex `from` onto `to`.
struct CollapseCandidate {
  double cost;
  std::uint32_t from, to;
  std::uint32_t from_stamp, to_stamp;  ///< Of the vertices when the cost was computed.

  bool operator>(const CollapseCandidate& other) const {
    return std::tie(cost, from, to) > std::tie(other.cost, other.from, other.to);
  }
};

/// Candidates by their cost, the least first. The dear ones wait unsorted until the cheap ones are
/// used up: most never come that far, and the heap stays small enough for the cache.
class CollapseQueue {
 public:
  void push(const CollapseCandidate& candidate) {
    if (candidate.cost > limit_)
      waiting_.push_back(candidate);
    else
      heap_.push(candidate);
  }

  bool empty() const { return heap_.empty() && waiting_.empty(); }

  /// Must not be empty.
  CollapseCandidate pop() {
    if (heap_.empty()) admit();
    const CollapseCandidate next = heap_.top();
    heap_.pop();
    return next;
  }

 private:
  // The cheapest of those that wait, and all of the same cost.
  void admit() {
    const std::size_t count =
        std::min(std::max(kLeastAdmitted, waiting_.size() / 16), waiting_.size());
    const auto last = waiting_.begin() + static_cast<std::ptrdiff_t>(count - 1);
    std::nth_element(waiting_.begin(), last, waiting_.end(),
                     [](const CollapseCandidate& a, const CollapseCandidate& b) { return b > a; });
    limit_ = last->cost;
    const auto dear =
        std::partition(waiting_.begin(), waiting_.end(),
                       [this](const CollapseCandidate& c) { return c.cost > limit_; });
    for (auto candidate = dear; candidate != waiting_.end(); ++candidate) heap_.push(*candidate);
    waiting_.erase(dear, waiting_.end());
  }

  // Candidates at once: few enough for the cache. Changes no result.
  static constexpr std::size_t kLeastAdmitted = 50000;

  double limit_ = -1.0;  // The largest cost in the heap; costs are not negative.
  std::priority_queue<CollapseCandidate, std::vector<CollapseCandidate>, std::greater<>> heap_;
  std::vector<CollapseCandidate> waiting_;
};

}  // namespace relief::fusion
