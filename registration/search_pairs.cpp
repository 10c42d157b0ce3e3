#include "relief/registration/search_pairs.h"

#include "registration/distinct_views.h"
#include "registration/given_poses/given_poses.h"
#include "registration/global/starting_poses.h"
#include "registration/prepared_views.h"
#include "scan/base/parallel.h"

namespace relief::registration {

Result<std::size_t> search_pairs(const std::vector<RangeView>& views, const AlignOptions& options,
                                 const PairBlock& block, const Context& context) {
  if (block.index >= block.count)
    return Error{ErrorKind::kBadInput, "there is no such block of pairs"};
  return run_in(context, [&]() -> Result<std::size_t> {
    const DistinctViews distinct(views);
    const auto prepared = prepare_to_align(distinct.views(), options, context);
    if (!prepared) return prepared.error();
    const auto& [surfaces, units] = *prepared;
    const auto given = refine_given_poses(surfaces, distinct.views(), options.starting_poses,
                                          options.refinement, {}, context.progress, units);
    if (!given) return given.error();
    return search_first_pairs(surfaces, given->checked, options.starting_poses, block,
                              context.progress, units);
  });
}

}  // namespace relief::registration
