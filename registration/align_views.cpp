#include "relief/registration/align_views.h"

#include <algorithm>
#include <map>
#include <utility>

#include "registration/units/align_units.h"
#include "registration/verification/given_poses.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

std::string invalid_option(const AlignOptions& options) {
  const auto& refinement = options.refinement;
  const auto& starting = options.starting_poses;
  if (options.surface.normal_radius < 0) return "surface.normal_radius must be >= 0";
  if (options.surface.boundary_margin < 1) return "surface.boundary_margin must be >= 1";
  if (options.surface.final_margin < 1) return "surface.final_margin must be >= 1";
  if (refinement.correspondences < 6) return "refinement.correspondences must be >= 6";
  if (refinement.levels < 1) return "refinement.levels must be >= 1";
  if (!(refinement.search_distance >= 0.0)) return "refinement.search_distance must be >= 0";
  if (!(refinement.max_normal_angle_deg > 0.0 && refinement.max_normal_angle_deg <= 90.0))
    return "refinement.max_normal_angle_deg must be in (0, 90]";
  if (!(refinement.min_overlap > 0.0 && refinement.min_overlap <= 1.0))
    return "refinement.min_overlap must be in (0, 1]";
  if (refinement.min_correspondences < 6) return "refinement.min_correspondences must be >= 6";
  if (!(refinement.tolerance > 0.0)) return "refinement.tolerance must be > 0";
  if (refinement.max_iterations < 1) return "refinement.max_iterations must be >= 1";
  if (!(starting.min_overlap > 0.0 && starting.min_overlap <= 1.0))
    return "starting_poses.min_overlap must be in (0, 1]";
  if (!(starting.max_free_space_violation >= 0.0 && starting.max_free_space_violation <= 1.0))
    return "starting_poses.max_free_space_violation must be in [0, 1]";
  return {};
}

// The first view that projective association was asked for and cannot serve.
const RangeView* view_without_projection(const std::vector<RangeView>& views,
                                         const AlignOptions& options) {
  if (options.refinement.association != Association::kProjective &&
      options.starting_poses.association != Association::kProjective)
    return nullptr;
  for (const RangeView& view : views)
    if (!view.camera.can_project()) return &view;
  return nullptr;
}

ViewSurfaceOptions surface_options_of(const AlignOptions& options) {
  ViewSurfaceOptions surface = options.surface;
  surface.neighbour_index |= options.refinement.association == Association::kNearest ||
                             options.starting_poses.association == Association::kNearest;
  return surface;
}

Result<std::vector<ViewSurface>> build_surfaces(const std::vector<RangeView>& views,
                                                const ViewSurfaceOptions& surface,
                                                const Progress& progress) {
  std::vector<ViewSurface> surfaces;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!report_progress(progress, static_cast<double>(i) / static_cast<double>(views.size()),
                         "preparing views"))
      return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
    surfaces.emplace_back(views[i], surface);
  }
  release_freed_memory();
  return surfaces;
}

// The view's largest verified group, or that of known views.
std::size_t main_group(const PoseVerification& verified, const std::vector<ViewRole>& roles) {
  std::map<std::size_t, std::pair<bool, std::size_t>> weight;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    if (roles[i] == ViewRole::kExcluded) continue;
    auto& [known, size] = weight[verified.group[i]];
    known |= roles[i] == ViewRole::kFixed;
    ++size;
  }
  std::size_t main = roles.size();
  std::pair<bool, std::size_t> most(false, 1);
  for (const auto& [group, w] : weight) {
    if (!(w > most)) continue;
    main = group;
    most = w;
  }
  return main;
}

// Views found by shape that fit none of those they seem to overlap: all their pairs are misfits.
std::vector<bool> find_misfits(const std::vector<bool>& found_by_shape,
                               const std::vector<ViewRole>& roles, const JointRefinement& refined) {
  std::vector<bool> paired(roles.size(), false), fits(roles.size(), false);
  for (const auto& pair : refined.pairs) {
    for (const std::size_t i : {pair.a, pair.b}) {
      paired[i] = true;
      if (pair.status != PairStatus::kMisfit) fits[i] = true;
    }
  }
  std::vector<bool> misfits(roles.size());
  for (std::size_t i = 0; i < roles.size(); ++i)
    misfits[i] = paired[i] && !fits[i] && roles[i] == ViewRole::kFree && found_by_shape[i];
  return misfits;
}

// One alignment on its way from surfaces to a report.
class Aligning {
 public:
  Aligning(const std::vector<RangeView>& views, const std::vector<ViewSurface>& surfaces,
           const AlignOptions& options, const AlignUnits& units, const Progress& progress)
      : views_(views),
        surfaces_(surfaces),
        starting_(options.starting_poses),
        refinement_(options.refinement),
        units_(units),
        progress_(progress) {}

  Result<Alignment> run() {
    auto given = refine_given_poses(surfaces_, views_, starting_, refinement_, progress_, units_);
    if (!given) return given.error();
    auto starts =
        find_starting_poses(surfaces_, views_, given->checked, starting_, progress_, units_);
    if (!starts) return starts.error();
    starts_ = std::move(*starts);
    take_roles();
    if (unchanged(given->checked)) {
      refined_ = std::move(given->refined);
      verified_ = std::move(given->verified);
    } else if (const auto done = refine_all(); !done) {
      return done.error();
    }
    return report(given->checked);
  }

 private:
  void take_roles() {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const auto& start = starts_.world_from_view[i];
      poses_.push_back(start.value_or(views_[i].world_from_view));
      roles_.push_back(!start                               ? ViewRole::kExcluded
                       : views_[i].pose == PoseKind::kKnown ? ViewRole::kFixed
                                                            : ViewRole::kFree);
    }
  }

  // Whether all poses are the given ones, already refined together.
  bool unchanged(const CheckedPoses& checked) const {
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (starts_.found_by_shape[i] ||
          starts_.world_from_view[i].has_value() != checked.world_from_view[i].has_value())
        return false;
    return true;
  }

  // Views found by shape that turn out to fit nowhere are taken out and the rest is refined again
  // from where it started, free of their influence.
  Result<void> refine_all() {
    for (;;) {
      auto refined = units_.refine_jointly(surfaces_, poses_, roles_, refinement_, progress_);
      if (!refined) return refined.error();
      refined_ = std::move(*refined);
      const auto misfits = find_misfits(starts_.found_by_shape, roles_, refined_);
      if (std::find(misfits.begin(), misfits.end(), true) == misfits.end()) break;
      for (std::size_t i = 0; i < roles_.size(); ++i)
        if (misfits[i]) roles_[i] = ViewRole::kExcluded;
    }
    if (!report_progress(progress_, 0.0, "verifying poses"))
      return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
    verified_ =
        verify_poses(surfaces_, refined_.world_from_view, roles_, verification_options(starting_));
    return {};
  }

  Alignment report(const CheckedPoses& checked) {
    Alignment result;
    result.notes = starts_.notes;
    const std::size_t main = main_group(verified_, roles_);
    for (std::size_t i = 0; i < views_.size(); ++i) {
      ViewReport view;
      view.name = views_[i].name;
      view.world_from_view = refined_.world_from_view[i];
      view.pose_std = refined_.pose_std[i];
      view.pose_covariance = refined_.pose_covariance[i];
      view.aligned = starts_.in_main_frame[i] && roles_[i] != ViewRole::kExcluded;
      const bool confirmed =
          verified_.group[i] == main || views_.size() == 1 || views_[i].pose == PoseKind::kKnown;
      view.status = !view.aligned ? PoseStatus::kLeftOut
                    : confirmed   ? PoseStatus::kVerified
                                  : PoseStatus::kUnverified;
      if (view.status == PoseStatus::kUnverified) view.reason = reason_unverified(i);
      if (view.status == PoseStatus::kLeftOut) view.reason = reason_left_out(i);
      result.views.push_back(std::move(view));
    }
    note_moves(checked, result);
    if (views_.size() == 1) result.notes.push_back("one view only: nothing to align");
    result.pairs = std::move(refined_.pairs);
    result.termination = refined_.termination;
    result.iterations = refined_.iterations;
    result.rms = refined_.rms;
    result.solves = std::move(refined_.solves);
    result.loops = std::move(refined_.loops);
    return result;
  }

  void note_moves(const CheckedPoses& checked, Alignment& result) const {
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (starts_.found_by_shape[i] && starts_.in_main_frame[i] &&
          (checked.refuted[i] || checked.world_from_view[i]))
        result.notes.push_back(
            "view " + views_[i].name + ": its given pose " +
            (checked.refuted[i] ? "stands where other views saw through" : "is not confirmed") +
            "; a pose that fits was found by its shape instead");
  }

  std::string names_of_group(const std::vector<std::size_t>& group, std::size_t except) const {
    std::string names;
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (group[i] == group[except] && i != except)
        names += (names.empty() ? "" : ", ") + views_[i].name;
    return names;
  }

  std::string reason_unverified(std::size_t i) const {
    if (surfaces_[i].samples().empty())
      return "it has no usable samples: none lies off all boundaries with a surface normal";
    const ViewVerification& view = verified_.views[i];
    if (!view.overlaps)
      return "it overlaps no other view at its pose; it is kept there, and nothing confirms it";
    if (view.violation > 0.0)
      return "other views saw through where a part of it stands; check its pose";
    const std::string partners = names_of_group(verified_.group, i);
    if (!partners.empty())
      return "it is confirmed only by " + partners + ", which nothing confirms in turn";
    return "it deviates from the views that it overlaps by more than other pairs do";
  }

  std::string reason_left_out(std::size_t i) const {
    if (surfaces_[i].samples().empty())
      return "it has no usable samples: none lies off all boundaries with a surface normal";
    if (!starts_.world_from_view[i]) return starts_.reasons[i];
    if (roles_[i] == ViewRole::kExcluded)
      return "it fits none of the views that it seems to overlap; give a better guess or remove it";
    return "no pose was found at which its group fits the main group; it is aligned only to " +
           names_of_group(refined_.group, i);
  }

  const std::vector<RangeView>& views_;
  const std::vector<ViewSurface>& surfaces_;
  StartingPoseOptions starting_;
  JointRefinementOptions refinement_;
  const AlignUnits& units_;
  const Progress& progress_;
  StartingPoses starts_;
  std::vector<RigidMotion> poses_;
  std::vector<ViewRole> roles_;
  JointRefinement refined_;
  PoseVerification verified_;
};

}  // namespace

bool Alignment::complete() const {
  return std::all_of(views.begin(), views.end(), [](const auto& view) { return view.aligned; });
}

std::vector<RigidMotion> Alignment::world_from_view() const {
  std::vector<RigidMotion> poses;
  for (const auto& view : views) poses.push_back(view.world_from_view);
  return poses;
}

Result<Alignment> align_views(const std::vector<RangeView>& views, const AlignOptions& options,
                              const Context& context) {
  if (views.empty()) return Error{ErrorKind::kBadInput, "there are no views to align"};
  if (const auto why = invalid_option(options); !why.empty())
    return Error{ErrorKind::kBadInput, "alignment options: " + why};
  if (const RangeView* view = view_without_projection(views, options))
    return Error{ErrorKind::kBadInput,
                 "view " + view->name +
                     ": its camera has no projection of points to pixels; use "
                     "the association auto or nearest"};

  return run_in(context, [&]() -> Result<Alignment> {
    const ViewSurfaceOptions surface = surface_options_of(options);
    auto surfaces = build_surfaces(views, surface, context.progress);
    if (!surfaces) return surfaces.error();
    const AlignUnits units(context.store, views, surface);
    return Aligning(views, *surfaces, options, units, context.progress).run();
  });
}

std::string_view to_string(PoseStatus status) {
  switch (status) {
    case PoseStatus::kVerified:
      return "verified";
    case PoseStatus::kUnverified:
      return "unverified";
    case PoseStatus::kLeftOut:
      return "left out";
  }
  return "unknown";
}

}  // namespace relief::registration
