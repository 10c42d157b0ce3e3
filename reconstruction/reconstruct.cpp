#include "relief/reconstruction/reconstruct.h"

#include <algorithm>
#include <array>
#include <utility>

#include "reconstruction/memory_check.h"
#include "reconstruction/stage_context.h"

namespace relief::reconstruction {

namespace {

class Reconstructor {
 public:
  Reconstructor(std::vector<RangeView> views, const ReconstructionPart& part,
                const ReconstructionOptions& options, const Context& context,
                const ReconstructionCallbacks& callbacks)
      : part_(part), options_(options), context_(context), callbacks_(callbacks) {
    result_.views = std::move(views);
  }

  Result<Reconstruction> run() {
    if (options_.remove_background) {
      result_.background = find_static_background(result_.views);
      ::relief::remove_background(result_.background, result_.views);
    }
    if (auto room = check_memory_to_refine(result_.views, options_.refine); !room)
      return room.error();
    for (const auto& [stage, work] : kWork) {
      if (stage > part_.last) break;
      const Result<void> done = (this->*work)();
      if (!done) return done.error();
    }
    return std::move(result_);
  }

 private:
  struct StageWork {
    Stage stage;
    Result<void> (Reconstructor::*work)();
  };
  static const std::array<StageWork, 6> kWork;  // In the order of the stages.

  Result<void> align() {
    if (part_.last == Stage::kAlign && part_.searched_pairs) {
      const auto searched =
          search_or_find(result_.views, options_.align, *part_.searched_pairs,
                         stages_.of(Stage::kAlign), stages_.missing_unit_error(Stage::kAlign));
      return searched ? Result<void>{} : searched.error();
    }
    auto alignment =
        align_or_find("align", result_.views, options_.align, stages_.of(Stage::kAlign),
                      stages_.missing_unit_error(Stage::kAlign));
    if (!alignment) return alignment.error();
    if (auto told = tell(callbacks_.aligned, *alignment); !told) return told;
    result_.first_alignment = std::move(*alignment);
    return {};
  }

  // Starts from the views at their given poses, and ends with them aligned.
  Result<void> calibrate() {
    if (has_stage(Stage::kCalibrate, options_)) {
      auto calibration = calibrate_or_find(result_.views, result_.first_alignment, options_.align,
                                           options_.calibration, stages_.of(Stage::kCalibrate),
                                           stages_.missing_unit_error(Stage::kCalibrate));
      if (!calibration) return calibration.error();
      registration::apply_alignment(result_.first_alignment, result_.views);
      registration::apply_calibration(*calibration, result_.views);
      result_.calibration = std::move(*calibration);
      if (result_.calibration.found()) result_.first_alignment = result_.calibration.alignment;
      if (auto told = tell(callbacks_.calibrated, result_.calibration, result_.views); !told)
        return told;
    } else {
      registration::apply_alignment(result_.first_alignment, result_.views);
    }
    drop_unaligned();
    if (result_.views.empty())
      return Error{ErrorKind::kUnsolvable, "no view could be aligned: nothing to merge"};
    return {};
  }

  // The pairs of the first alignment among the views that are left.
  std::vector<registration::PairFit> remaining_pairs() const {
    const registration::Alignment& first = result_.first_alignment;
    std::vector<std::size_t> index(first.views.size(), 0);
    for (std::size_t i = 0, next = 0; i < index.size(); ++i)
      if (first.views[i].aligned) index[i] = next++;
    std::vector<registration::PairFit> remaining;
    for (const registration::PairFit& pair : first.pairs) {
      if (!first.views[pair.a].aligned || !first.views[pair.b].aligned) continue;
      remaining.push_back(pair);
      remaining.back().a = index[pair.a];
      remaining.back().b = index[pair.b];
    }
    return remaining;
  }

  Result<void> compare() {
    if (!has_stage(Stage::kCompare, options_)) return {};
    CrossViewOptions compare;
    compare.correct = options_.contradicted == ContradictedRanges::kCorrect;
    auto found =
        weigh_or_find(remaining_pairs(), compare, result_.views, stages_.of(Stage::kCompare),
                      stages_.missing_unit_error(Stage::kCompare));
    if (!found) return found.error();
    result_.consistency = std::move(*found);
    return tell(callbacks_.compared, result_.consistency, result_.views);
  }

  // Views that fit nowhere would only spoil the model.
  void drop_unaligned() {
    std::vector<RangeView> kept;
    for (std::size_t i = 0; i < result_.views.size(); ++i)
      if (result_.first_alignment.views[i].aligned) kept.push_back(std::move(result_.views[i]));
    result_.views = std::move(kept);
  }

  Result<void> refine() {
    if (part_.last == Stage::kRefine && part_.refined_views)
      keep_chosen_views(*part_.refined_views);
    auto refined = refine_or_find(result_.views, options_.refine, stages_.of(Stage::kRefine),
                                  stages_.missing_unit_error(Stage::kRefine));
    if (!refined) return refined.error();
    for (std::size_t i = 0; i < refined->size(); ++i) {
      hybrid::RefinedView& view = (*refined)[i];
      result_.refinements.push_back(view);
      result_.views[i] = std::move(view.view);
    }
    return tell(callbacks_.refined, result_.refinements, result_.views);
  }

  // Of the views that are left, those with an index in `chosen` among the views given.
  void keep_chosen_views(const std::vector<std::size_t>& chosen) {
    std::vector<RangeView> taken;
    for (std::size_t i = 0, next = 0; i < result_.first_alignment.views.size(); ++i) {
      if (!result_.first_alignment.views[i].aligned) continue;
      if (std::find(chosen.begin(), chosen.end(), i) != chosen.end())
        taken.push_back(std::move(result_.views[next]));
      ++next;
    }
    result_.views = std::move(taken);
  }

  bool any_refined() const {
    return std::any_of(result_.refinements.begin(), result_.refinements.end(), [](const auto& one) {
      return one.status == hybrid::RefineStatus::kRefined;
    });
  }

  // Along motions that nothing determines the second alignment starts where the first one did.
  void keep_doubts(registration::Alignment& second) const {
    auto view = second.views.begin();
    for (const registration::ViewReport& first : result_.first_alignment.views) {
      if (!first.aligned) continue;
      if (first.status == registration::PoseStatus::kUnverified && !first.kept_motions.empty() &&
          view->status == registration::PoseStatus::kVerified && !view->kept_motions.empty()) {
        view->status = first.status;
        view->reason = first.reason;
      }
      ++view;
    }
  }

  Result<void> align_again() {
    if (any_refined() && result_.views.size() > 1) {
      registration::AlignOptions options = options_.align;
      options.surface.normals = registration::NormalSource::kMeasured;
      options.starting_poses.keep_given = false;
      auto alignment =
          align_or_find("align_again", result_.views, options, stages_.of(Stage::kAlignAgain),
                        stages_.missing_unit_error(Stage::kAlignAgain));
      if (!alignment) return alignment.error();
      keep_doubts(*alignment);
      const AlignmentGain gain =
          compare_alignments(result_.first_alignment, *alignment, result_.views);
      if (gain.kept()) registration::apply_alignment(*alignment, result_.views);
      result_.second_alignment = {std::move(*alignment), gain};
      if (auto told = tell(callbacks_.aligned_again, *result_.second_alignment); !told) return told;
    }
    return tell(callbacks_.views_finished, result_.views);
  }

  Result<void> merge() {
    if (part_.last == Stage::kMerge && part_.field) {
      const auto computed =
          field_part_or_find(result_.views, options_.model.merge, *part_.field,
                             stages_.of(Stage::kMerge), stages_.missing_unit_error(Stage::kMerge));
      return computed ? Result<void>{} : computed.error();
    }
    ModelOptions options = options_.model;
    if (part_.last == Stage::kMerge) {
      options.polish.reset();
      options.decimation = {};
    }
    auto model = build_model_in(stages_, result_.views, options);
    if (!model) return model.error();
    result_.model = std::move(*model);
    return {};
  }

  template <typename Callback, typename... Arguments>
  static Result<void> tell(const Callback& callback, const Arguments&... arguments) {
    return callback ? callback(arguments...) : Result<void>{};
  }

  const ReconstructionPart& part_;
  const ReconstructionOptions& options_;
  const Context& context_;
  const ReconstructionCallbacks& callbacks_;
  const StageContext stages_{context_, callbacks_.progress, part_};
  Reconstruction result_;
};

const std::array<Reconstructor::StageWork, 6> Reconstructor::kWork{
    {{Stage::kAlign, &Reconstructor::align},
     {Stage::kCalibrate, &Reconstructor::calibrate},
     {Stage::kCompare, &Reconstructor::compare},
     {Stage::kRefine, &Reconstructor::refine},
     {Stage::kAlignAgain, &Reconstructor::align_again},
     {Stage::kMerge, &Reconstructor::merge}}};

}  // namespace

bool Reconstruction::complete() const {
  return first_alignment.complete() && first_alignment.solved() &&
         std::none_of(refinements.begin(), refinements.end(),
                      [](const hybrid::RefineSummary& view) { return view.failed(); });
}

Result<Reconstruction> reconstruct(std::vector<RangeView> views,
                                   const ReconstructionOptions& options, const Context& context,
                                   const ReconstructionCallbacks& callbacks) {
  return reconstruct_part(std::move(views), {}, options, context, callbacks);
}

bool has_stage(Stage stage, const ReconstructionOptions& options) {
  if (stage == Stage::kCalibrate)
    return options.calibration.scope != registration::CalibrationScope::kOff;
  if (stage == Stage::kCompare) return options.contradicted != ContradictedRanges::kKeep;
  return stage != Stage::kPolish || options.model.polish.has_value();
}

std::string step_name(Stage stage) {
  std::string name(to_string(stage));
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

Result<Reconstruction> reconstruct_part(std::vector<RangeView> views,
                                        const ReconstructionPart& part,
                                        const ReconstructionOptions& options,
                                        const Context& context,
                                        const ReconstructionCallbacks& callbacks) {
  return run_in(context, [&] {
    return Reconstructor(std::move(views), part, options, context, callbacks).run();
  });
}

}  // namespace relief::reconstruction
