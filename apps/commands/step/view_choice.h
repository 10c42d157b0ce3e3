#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief {

/// Which views of a project a step works on.
struct ViewChoice {
  std::vector<std::string> names;  ///< Names, or indices from 0.
  std::string range;               ///< `I..J`: indices from I to J, both included.
  std::string block;               ///< `I/N`: the Ith of N blocks of about equal size, from 1.

  bool given() const { return !names.empty() || !range.empty() || !block.empty(); }
};

/// Adds the positional VIEW..., --views and --block.
void add_view_choice(CLI::App& command, ViewChoice& choice);

/// The indices of the chosen views, in their order and each once; nothing: all. Error: kBadInput
/// where a name, an index or a block is not there.
Result<std::optional<std::vector<std::size_t>>> chosen_views(const ViewChoice& choice,
                                                             const std::vector<RangeView>& views);

/// The indices in [0, count) of block `index` of `blocks`, counted from 0.
std::vector<std::size_t> block_of(std::size_t count, std::size_t index, std::size_t blocks);

}  // namespace relief
