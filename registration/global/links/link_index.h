#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "registration/global/view_groups.h"

namespace relief::registration {

/// The links of each pair of views, found without looking through all of them.
class LinkIndex {
 public:
  /// `links` outlive this and stay where they are.
  explicit LinkIndex(const std::vector<PoseLink>& links) {
    for (const PoseLink& link : links) of_pair_[{link.a, link.b}].push_back(&link);
  }

  /// Those from view `a` to view `b`, in the order given; not those from `b` to `a`.
  const std::vector<const PoseLink*>& between(std::size_t a, std::size_t b) const {
    const auto found = of_pair_.find({a, b});
    return found == of_pair_.end() ? none_ : found->second;
  }

 private:
  std::map<std::pair<std::size_t, std::size_t>, std::vector<const PoseLink*>> of_pair_;
  std::vector<const PoseLink*> none_;
};

}  // namespace relief::registration
