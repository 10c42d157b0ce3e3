#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief {

/// One of several blocks of what a step works on.
struct Block {
  std::size_t index = 0;  ///< From 0.
  std::size_t count = 1;  ///< > index.
};

/// Which views of a project a step works on.
struct ViewChoice {
  std::vector<std::string> names;  ///< Names, or indices from 0.
  std::string range;               ///< `I..J`: indices from I to J, both included.
  std::string block;               ///< `I/N`: the Ith of N blocks of about equal size, from 1.

  bool given() const { return chooses_views() || !block.empty(); }
  bool chooses_views() const { return !names.empty() || !range.empty(); }
};

/// Adds the positional VIEW..., --views and --block.
void add_view_choice(CLI::App& command, ViewChoice& choice);

/// The indices of the chosen views, in their order and each once; nothing: all. Error: kBadInput
/// where a name, an index or a block is not there.
Result<std::optional<std::vector<std::size_t>>> chosen_views(const ViewChoice& choice,
                                                             const std::vector<RangeView>& views);

/// The block of `choice`, the whole where none is given. Error: kBadInput where it is not there.
Result<Block> chosen_block(const ViewChoice& choice);

/// The indices in [0, count) of a block.
std::vector<std::size_t> block_of(std::size_t count, const Block& block);

}  // namespace relief
