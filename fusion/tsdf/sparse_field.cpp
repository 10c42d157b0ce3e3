#include "fusion/tsdf/sparse_field.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

constexpr std::size_t kGrain = 16;  // Blocks of one piece of work; changes no result.

template <typename Visit>
void for_neighbourhood(const Visit& visit) {
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) visit(dx, dy, dz);
}

bool crosses(float a, float b) { return (a > 0.0f) != (b > 0.0f); }

// Which of the 27 blocks round a block hold nodes of cells that the zero set crosses, among the
// cells that touch the block: bit (dx + 1) + 3 (dy + 1) + 9 (dz + 1).
std::uint32_t crossed_neighbours(const SparseField::Padded& padded) {
  std::uint32_t crossed = 0;
  const auto side = [](int c) { return c < 0 ? 0 : c < kBlockSide ? 1 : 2; };
  for (int z = -1; z < kBlockSide; ++z) {
    for (int y = -1; y < kBlockSide; ++y) {
      for (int x = -1; x < kBlockSide; ++x) {
        const float first = padded[padded_index(x, y, z)];
        bool crossing = false;
        for (int k = 1; k < 8 && !crossing; ++k)
          crossing =
              crosses(first, padded[padded_index(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2))]);
        if (!crossing) continue;
        for (int k = 0; k < 8; ++k)
          crossed |=
              1u << (side(x + (k & 1)) + 3 * side(y + (k >> 1 & 1)) + 9 * side(z + (k >> 2)));
      }
    }
  }
  return crossed;
}

}  // namespace

void make_sorted_set(std::vector<NodeKey>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

std::vector<NodeKey> KeySet::take() {
  std::vector<NodeKey> keys = std::exchange(keys_, {});
  make_sorted_set(keys);
  next_ = kFewest;
  return {keys.begin(), keys.end()};
}

SparseField::SparseField(const Lattice& lattice, std::vector<NodeKey> active_blocks,
                         const SparseField* coarser, float outside_value, MemoryLimit* memory)
    : lattice_(lattice),
      coarser_(coarser),
      outside_value_(outside_value),
      keys_(std::move(active_blocks)),
      active_(keys_.size(), 1),
      memory_(memory) {
  add_border();
  clear_values();
  link_neighbours();
}

SparseField::SparseField(const Lattice& lattice, SparseFieldBlocks blocks,
                         const SparseField* coarser, float outside_value, MemoryLimit* memory)
    : lattice_(lattice),
      coarser_(coarser),
      outside_value_(outside_value),
      keys_(std::move(blocks.keys)),
      active_(std::move(blocks.active)),
      memory_(memory),
      values_(blocks.values.size(), memory) {
  std::copy(blocks.values.begin(), blocks.values.end(), values_.begin());
  link_neighbours();
}

SparseFieldBlocks SparseField::blocks() const {
  return {keys_, active_, {values_.begin(), values_.end()}};
}

void SparseField::clear_values() {
  values_ = PagedArray<float>(keys_.size() * kBlockNodes, memory_);
  if (coarser_) return;  // prolong() gives all values
  std::fill(values_.begin(), values_.end(), outside_value_);
}

void SparseField::add_border() {
  KeySet set;
  for (std::size_t b = 0; b < keys_.size(); ++b) {
    if (!active_[b]) {
      set.add(keys_[b]);
      continue;
    }
    const Node centre = node_of(keys_[b]);
    for_neighbourhood([&](int dx, int dy, int dz) { set.add(key_of(centre + Node(dx, dy, dz))); });
  }
  std::vector<NodeKey> all = set.take();
  std::vector<std::uint8_t> active(all.size(), 0);
  for (std::size_t b = 0; b < keys_.size(); ++b) {
    const auto place = std::lower_bound(all.begin(), all.end(), keys_[b]);
    active[static_cast<std::size_t>(place - all.begin())] = active_[b];
  }
  keys_ = std::move(all);
  active_ = std::move(active);
}

void SparseField::link_neighbours() {
  neighbours_ = PagedArray<std::array<std::int32_t, 27>>(keys_.size(), memory_);
  serial_for(keys_.size(), [&](std::size_t b) {
    const Node centre = block(b);
    std::size_t k = 0;
    for_neighbourhood(
        [&](int dx, int dy, int dz) { neighbours_[b][k++] = find(centre + Node(dx, dy, dz)); });
  });
}

std::int32_t SparseField::find(const Node& block) const {
  const NodeKey key = key_of(block);
  const auto place = std::lower_bound(keys_.begin(), keys_.end(), key);
  if (place == keys_.end() || *place != key) return -1;
  return static_cast<std::int32_t>(place - keys_.begin());
}

float SparseField::value(const Node& node) const {
  const std::int32_t b = find(block_of(node));
  if (b >= 0) return values(static_cast<std::size_t>(b))[offset_in_block(node)];
  return coarser_ ? coarser_->value_at_finer(node) : outside_value_;
}

float SparseField::value_at_finer(const Node& finer_node) const {
  const Node low(finer_node.x() >> 1, finer_node.y() >> 1, finer_node.z() >> 1);
  const Node odd(finer_node.x() & 1, finer_node.y() & 1, finer_node.z() & 1);
  float sum = 0.0f;
  for (int k = 0; k < 8; ++k) {
    const Node step(k & 1, (k >> 1) & 1, k >> 2);
    sum += value(low + step.cwiseProduct(odd));
  }
  return sum / 8.0f;
}

// The 8^3 fine nodes of a block lie among 5^3 coarse ones, each looked up once.
void SparseField::prolong_block(std::size_t b, float limit) {
  std::array<float, 125> coarse;
  const Node first = first_node(b) / 2;
  for (int z = 0, k = 0; z < 5; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 5; ++x)
        coarse[static_cast<std::size_t>(k++)] = coarser_->value(first + Node(x, y, z));
  float* fine = values(b);
  for (int i = 0; i < kBlockNodes; ++i) {
    const Node node = node_at_offset(i);
    float sum = 0.0f;
    for (int k = 0; k < 8; ++k) {
      const int x = (node.x() + (k & 1)) >> 1, y = (node.y() + (k >> 1 & 1)) >> 1;
      const int z = (node.z() + (k >> 2)) >> 1;
      sum += coarse[static_cast<std::size_t>(x + 5 * y + 25 * z)];
    }
    fine[i] = std::clamp(sum / 8.0f, -limit, limit);
  }
}

void SparseField::prolong(float limit) {
  if (!coarser_) return;
  parallel_for(keys_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    evict_pages(memory_);
    for (std::size_t b = begin; b < end; ++b) prolong_block(b, limit);
  });
}

void SparseField::gather(std::size_t b, Padded& padded) const {
  assert(active(b));
  const auto side = [](int c) { return c < 0 ? -1 : c < kBlockSide ? 0 : 1; };
  for (int z = -1; z <= kBlockSide; ++z) {
    for (int y = -1; y <= kBlockSide; ++y) {
      const auto row = [&](int dx) {
        const auto n = static_cast<std::size_t>(neighbour(b, dx, side(y), side(z)));
        return values(n) + ((y & 7) << 3) + ((z & 7) << 6);
      };
      float* out = padded.data() + padded_index(-1, y, z);
      out[0] = row(-1)[7];
      std::copy_n(row(0), kBlockSide, out + 1);
      out[9] = row(1)[0];
    }
  }
}

std::vector<NodeKey> SparseField::crossed_border_blocks() const {
  std::vector<std::uint32_t> crossed(keys_.size(), 0);
  parallel_for(keys_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    evict_pages(memory_);
    Padded padded;
    for (std::size_t b = begin; b < end; ++b) {
      if (!active(b)) continue;
      gather(b, padded);
      crossed[b] = crossed_neighbours(padded);
    }
  });
  std::vector<NodeKey> blocks;
  for (std::size_t b = 0; b < keys_.size(); ++b) {
    for (std::size_t k = 0; k < 27; ++k) {
      if (!(crossed[b] >> k & 1u)) continue;
      const auto n = static_cast<std::size_t>(neighbours_[b][k]);
      if (!active(n)) blocks.push_back(keys_[n]);
    }
  }
  make_sorted_set(blocks);
  return blocks;
}

void SparseField::activate(const std::vector<NodeKey>& blocks, float limit) {
  for (const NodeKey key : blocks) active_[static_cast<std::size_t>(find(node_of(key)))] = 1;
  const std::vector<NodeKey> old_keys = keys_;
  const PagedArray<float> old_values = std::move(values_);
  add_border();
  clear_values();
  link_neighbours();
  prolong(limit);
  parallel_for(old_keys.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    evict_pages(memory_);
    for (std::size_t b = begin; b < end; ++b) {
      const auto now = static_cast<std::size_t>(find(node_of(old_keys[b])));
      std::copy_n(old_values.begin() + b * kBlockNodes, kBlockNodes, values(now));
    }
  });
}

void SparseField::close_zero_set(float limit) {
  for (auto crossed = crossed_border_blocks(); !crossed.empty(); crossed = crossed_border_blocks())
    activate(crossed, limit);
}

}  // namespace relief::fusion
