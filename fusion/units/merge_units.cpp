#include "fusion/units/merge_units.h"

#include "scan/units/unit_codec_private.h"

namespace relief::fusion {

namespace {

UnitKey key_of_level(const std::string& inputs, int level) {
  return unit_key("field", inputs, level);
}

UnitKey key_of_group(const std::string& inputs, std::size_t number) {
  return unit_key("field_group", inputs, number);
}

}  // namespace

// A structured binding names exactly the fields there are: whoever adds one comes by here.
void hash_into(ContentHash& hash, const MergeOptions& options) {
  const auto& [voxel_size, truncation, silhouette_ramp, keep_holes, largest_fill, keep_components,
               keep_contradicted, keep_handles] = options;
  hash.add(voxel_size, truncation, silhouette_ramp, keep_holes, largest_fill, keep_components,
           keep_contradicted, keep_handles);
}

template <class Archive>
static void serialize(Archive& archive, SparseFieldBlocks& blocks) {
  auto& [keys, active, values] = blocks;
  archive(keys, active, values);
}

template <class Archive>
static void serialize(Archive& archive, KeptLevel& level) {
  auto& [blocks, moving_blocks, bent] = level;
  archive(blocks, moving_blocks, bent);
}

template <class Archive>
static void serialize(Archive& archive, IntegratedBlocks& integrated) {
  auto& [values, floors] = integrated;
  archive(values, floors);
}

std::optional<KeptLevel> FieldUnits::find(int level) const {
  if (store_ == nullptr) return std::nullopt;
  auto content = store_->find(key_of_level(inputs_, level));
  if (!content) return std::nullopt;
  auto kept = decode_unit<KeptLevel>(std::move(*content));
  if (!kept || !kept->blocks.consistent()) return std::nullopt;
  return kept;
}

void FieldUnits::keep(int level, const SparseField& field, std::size_t moving_blocks,
                      bool bent) const {
  if (store_ == nullptr) return;
  keep_unit(*store_, key_of_level(inputs_, level), KeptLevel{field.blocks(), moving_blocks, bent});
}

std::optional<IntegratedBlocks> FieldUnits::find_group(std::size_t number) const {
  if (store_ == nullptr) return std::nullopt;
  auto content = store_->find(key_of_group(inputs_, number));
  if (!content) return std::nullopt;
  return decode_unit<IntegratedBlocks>(std::move(*content));
}

void FieldUnits::keep_group(std::size_t number, const IntegratedBlocks& integrated) const {
  if (store_ != nullptr) keep_unit(*store_, key_of_group(inputs_, number), integrated);
}

}  // namespace relief::fusion
