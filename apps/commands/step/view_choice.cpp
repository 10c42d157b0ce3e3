#include "apps/commands/step/view_choice.h"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <set>
#include <string_view>

namespace relief {

namespace {

Error wrong(const std::string& what) { return {ErrorKind::kBadInput, what}; }

std::optional<std::size_t> whole_number(std::string_view text) {
  std::size_t number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// The numbers on both sides of `between`.
std::optional<std::pair<std::size_t, std::size_t>> two_numbers(std::string_view text,
                                                               std::string_view between) {
  const std::size_t at = text.find(between);
  if (at == std::string_view::npos) return std::nullopt;
  const auto first = whole_number(text.substr(0, at));
  const auto second = whole_number(text.substr(at + between.size()));
  if (!first || !second) return std::nullopt;
  return std::pair(*first, *second);
}

// A name counts before an index: views may be called 0, 1, 2.
std::optional<std::size_t> find_view(const std::string& name, const std::vector<RangeView>& views) {
  const auto named = std::find_if(views.begin(), views.end(),
                                  [&](const RangeView& view) { return view.name == name; });
  if (named != views.end()) return static_cast<std::size_t>(named - views.begin());
  const auto index = whole_number(name);
  return index && *index < views.size() ? index : std::nullopt;
}

}  // namespace

void add_view_choice(CLI::App& command, ViewChoice& choice) {
  command.add_option("view", choice.names,
                     "Of refine: the views to refine, by name or by index from 0; default: all");
  command.add_option("--views", choice.range, "Of refine: the views of these indices, as 4..7");
  command.add_option("--block", choice.block,
                     "Of refine: one of several blocks of the views, as 1/4, 2/4, 3/4, 4/4; of "
                     "pairs: one of the pairs of views; of field: one of its bricks");
}

Result<Block> chosen_block(const ViewChoice& choice) {
  if (choice.block.empty()) return Block();
  const auto block = two_numbers(choice.block, "/");
  if (!block || block->first < 1 || block->first > block->second)
    return wrong("--block " + choice.block + ": give the block and how many there are, as 2/4");
  return Block{block->first - 1, block->second};
}

std::vector<std::size_t> block_of(std::size_t count, const Block& block) {
  const std::size_t begin = count * block.index / block.count;
  const std::size_t end = count * (block.index + 1) / block.count;
  std::vector<std::size_t> indices(end - begin);
  std::iota(indices.begin(), indices.end(), begin);
  return indices;
}

Result<std::optional<std::vector<std::size_t>>> chosen_views(const ViewChoice& choice,
                                                             const std::vector<RangeView>& views) {
  if (!choice.given()) return std::optional<std::vector<std::size_t>>();
  const std::string has = "the project has " + std::to_string(views.size()) + " views";
  std::set<std::size_t> chosen;
  for (const std::string& name : choice.names) {
    const auto found = find_view(name, views);
    if (!found) return wrong("no view has the name or the index `" + name + "`: " + has);
    chosen.insert(*found);
  }
  if (!choice.range.empty()) {
    const auto range = two_numbers(choice.range, "..");
    if (!range || range->first > range->second || range->second >= views.size())
      return wrong("--views " + choice.range + ": give indices from 0 as 4..7; " + has);
    for (std::size_t i = range->first; i <= range->second; ++i) chosen.insert(i);
  }
  if (!choice.block.empty()) {
    const auto block = chosen_block(choice);
    if (!block) return block.error();
    for (const std::size_t i : block_of(views.size(), *block)) chosen.insert(i);
  }
  return std::optional(std::vector<std::size_t>(chosen.begin(), chosen.end()));
}

}  // namespace relief
