#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "relief/fusion/field_part.h"
#include "relief/reconstruction/reconstruct.h"
#include "relief/registration/search_pairs.h"

namespace relief::reconstruction {

/// A part of a reconstruction: one stage, after what the stages before it have left in the store.
struct ReconstructionPart {
  /// Nothing after this stage is computed. Where it is kAlign the views stay at their given poses.
  Stage last = Stage::kPolish;
  /// Where `last` is kRefine: only these views are refined, by their indices among the views given.
  /// Those that the alignment left out are passed over. Nothing: all.
  std::optional<std::vector<std::size_t>> refined_views;
  /// Where `last` is kAlign: only these pairs of views are searched for poses by shape, ahead of
  /// the alignment: registration::search_pairs. Nothing: the views are aligned.
  std::optional<registration::PairBlock> searched_pairs;
  /// Where `last` is kMerge: only this part of the field is computed, ahead of merging:
  /// fusion::compute_field_part. Nothing: the views are merged.
  std::optional<fusion::FieldPart> field;
  /// Units of the stages before `last` must be in the store: none is computed.
  bool find_former = false;
  /// The same of `last` itself: nothing is computed at all.
  bool find_last = false;
};

/// Whether a reconstruction with these options has a stage. kAlignAgain needs refined views too.
bool has_stage(Stage stage, const ReconstructionOptions& options);

/// The name of a stage as one word: `align-again`.
std::string step_name(Stage stage);

/// As reconstruct(), which is this function with the default part: the same code with the same keys
/// of units. So parts may be computed in any order, by several processes that share one store, and
/// the last one finds all units. Only the callbacks of the stages up to `last` are called.
///
/// The result holds what these stages gave: `views` after kRefine with `refined_views` are these
/// alone, refined, with `refinements` of the same; `model` is empty before kMerge, and after kMerge
/// neither polished nor decimated. With `searched_pairs` it holds the views as they are given, with
/// `field` those that would be merged.
///
/// Errors: those of reconstruct(); kBadInput where a unit that must be in the store is missing. The
/// message names its stage with step_name().
Result<Reconstruction> reconstruct_part(std::vector<RangeView> views,
                                        const ReconstructionPart& part,
                                        const ReconstructionOptions& options = {},
                                        const Context& context = {},
                                        const ReconstructionCallbacks& callbacks = {});

}  // namespace relief::reconstruction
