#include "relief/fusion/field_part.h"

#include "fusion/prepared_merge.h"
#include "fusion/tsdf/closed_field.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

constexpr double kPrepared = 0.1;  // Of the time, in bricks of a tenth of the finest level.

}  // namespace

Result<std::size_t> compute_field_part(const std::vector<RangeView>& views,
                                       const MergeOptions& options, const FieldPart& part,
                                       const Context& context) {
  if (part.bricks > 0 && part.brick >= part.bricks)
    return Error{ErrorKind::kBadInput, "there is no such brick of the field"};
  if (context.store == nullptr)
    return Error{ErrorKind::kBadInput, "a part of the field needs a store that keeps it"};
  return run_in(context, [&]() -> Result<std::size_t> {
    MemoryLimit* const memory = current_memory_limit();
    MergeSummary chosen;
    const auto prepared = prepare_merge(source_of(views), options, context.store, memory,
                                        part_of(context.progress, 0.0, kPrepared), chosen);
    if (!prepared) return prepared.error();
    return integrate_part_of_field(prepared->samplers, part,
                                   field_options(chosen, prepared->units, memory),
                                   part_of(context.progress, kPrepared, 1.0));
  });
}

}  // namespace relief::fusion
