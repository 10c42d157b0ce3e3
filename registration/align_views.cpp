#include "registration/align_views.h"

#include <algorithm>
#include <map>

#include "scan/parallel.h"

namespace relief {

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
  if (!(starting.max_contradiction >= 0.0 && starting.max_contradiction <= 1.0))
    return "starting_poses.max_contradiction must be in [0, 1]";
  return {};
}

Result<std::vector<ViewSurface>> build_surfaces(const std::vector<RangeView>& views,
                                                const AlignOptions& options,
                                                const Progress& progress) {
  ViewSurfaceOptions surface = options.surface;
  surface.threads = options.threads;
  surface.neighbour_index |= options.refinement.association == Association::kNearest ||
                             options.starting_poses.association == Association::kNearest;
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

// Groups that hold a known view share the frame that the known poses define. Without any, the
// largest group is the main one, if it has at least two views or is all there is.
std::vector<bool> in_main_frame(const std::vector<RangeView>& views,
                                const std::vector<std::size_t>& group) {
  std::map<std::size_t, std::size_t> sizes;
  std::map<std::size_t, bool> anchored;
  for (std::size_t i = 0; i < views.size(); ++i) {
    ++sizes[group[i]];
    if (views[i].pose == PoseKind::kKnown) anchored[group[i]] = true;
  }
  if (anchored.empty()) {
    const auto largest =
        std::max_element(sizes.begin(), sizes.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (largest->second >= 2 || views.size() == 1) anchored[largest->first] = true;
  }
  std::vector<bool> main(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) main[i] = anchored.count(group[i]) > 0;
  return main;
}

std::string names_of_group(const std::vector<RangeView>& views,
                           const std::vector<std::size_t>& group, std::size_t except) {
  std::string names;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (group[i] == group[except] && i != except)
      names += (names.empty() ? "" : ", ") + views[i].name;
  return names;
}

std::string reason_not_aligned(const std::vector<RangeView>& views,
                               const std::vector<std::size_t>& group, const ViewSurface& surface,
                               const std::string& unplaced, ViewRole role, std::size_t i) {
  if (surface.samples().empty())
    return "it has no usable samples: none lies off all boundaries with a surface normal";
  if (!unplaced.empty()) return unplaced;
  if (role == ViewRole::kExcluded)
    return "it fits none of the views that it seems to overlap; give a better guess or remove it";
  const std::string partners = names_of_group(views, group, i);
  if (partners.empty())
    return "it overlaps no other view at its starting pose; add a view between or a better guess";
  return "its group overlaps no view of the main group; it is aligned only to " + partners;
}

// Views that were refined but fit none of those they seem to overlap: all their pairs are misfits.
std::vector<bool> find_misfits(const std::vector<ViewRole>& roles, const JointRefinement& refined) {
  std::vector<bool> paired(roles.size(), false), fits(roles.size(), false);
  for (const auto& pair : refined.pairs) {
    for (const std::size_t i : {pair.a, pair.b}) {
      paired[i] = true;
      if (pair.grade != PairGrade::kMisfit) fits[i] = true;
    }
  }
  std::vector<bool> misfits(roles.size());
  for (std::size_t i = 0; i < roles.size(); ++i)
    misfits[i] = paired[i] && !fits[i] && roles[i] == ViewRole::kFree;
  return misfits;
}

// Joint refinement; views that turn out to fit nowhere are taken out and the rest refined again
// from where it started, free of their pull.
Result<JointRefinement> refine_without_misfits(const std::vector<ViewSurface>& surfaces,
                                               const std::vector<RigidMotion>& poses,
                                               std::vector<ViewRole>& roles,
                                               const JointRefinementOptions& options,
                                               const Progress& progress) {
  for (;;) {
    auto refined = refine_jointly(surfaces, poses, roles, options, progress);
    if (!refined) return refined;
    const auto misfits = find_misfits(roles, *refined);
    if (std::find(misfits.begin(), misfits.end(), true) == misfits.end()) return refined;
    for (std::size_t i = 0; i < roles.size(); ++i)
      if (misfits[i]) roles[i] = ViewRole::kExcluded;
  }
}

void report_views(const std::vector<RangeView>& views, const std::vector<ViewSurface>& surfaces,
                  const StartingPoses& starts, const std::vector<ViewRole>& roles,
                  const JointRefinement& refined, Alignment& result) {
  const auto main = in_main_frame(views, refined.group);
  for (std::size_t i = 0; i < views.size(); ++i) {
    ViewReport report;
    report.name = views[i].name;
    report.world_from_view = refined.world_from_view[i];
    report.pose_std = refined.pose_std[i];
    const auto row = static_cast<Eigen::Index>(6 * i);
    report.pose_covariance = refined.pose_covariance.block<6, 6>(row, row);
    report.aligned = main[i] && roles[i] != ViewRole::kExcluded;
    if (!report.aligned)
      report.reason =
          reason_not_aligned(views, refined.group, surfaces[i], starts.reasons[i], roles[i], i);
    result.views.push_back(std::move(report));
  }
  if (views.size() == 1) result.notes.push_back("one view only: nothing to align");
}

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
                              const Progress& progress) {
  if (views.empty()) return Error{ErrorKind::kBadInput, "there are no views to align"};
  if (const auto why = invalid_option(options); !why.empty())
    return Error{ErrorKind::kBadInput, "alignment options: " + why};

  auto surfaces = build_surfaces(views, options, progress);
  if (!surfaces) return surfaces.error();
  StartingPoseOptions starting = options.starting_poses;
  starting.threads = options.threads;
  auto starts = find_starting_poses(*surfaces, views, starting, progress);
  if (!starts) return starts.error();

  std::vector<RigidMotion> poses;
  std::vector<ViewRole> roles;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto& start = starts->world_from_view[i];
    poses.push_back(start.value_or(views[i].world_from_view));
    roles.push_back(!start                              ? ViewRole::kExcluded
                    : views[i].pose == PoseKind::kKnown ? ViewRole::kFixed
                                                        : ViewRole::kFree);
  }
  JointRefinementOptions refinement = options.refinement;
  refinement.threads = options.threads;
  auto refined = refine_without_misfits(*surfaces, poses, roles, refinement, progress);
  if (!refined) return refined.error();

  Alignment result;
  result.notes = starts->notes;
  report_views(views, *surfaces, *starts, roles, *refined, result);
  result.pairs = std::move(refined->pairs);
  result.termination = refined->termination;
  result.iterations = refined->iterations;
  result.rms = refined->rms;
  return result;
}

}  // namespace relief
