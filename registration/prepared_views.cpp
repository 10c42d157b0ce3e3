#include "registration/prepared_views.h"

#include <string>

#include "registration/surface/view_surfaces.h"
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

Result<std::vector<ViewSurface>> build_surfaces(const std::vector<RangeView>& views,
                                                const ViewSurfaceOptions& surface,
                                                const Progress& progress) {
  auto surfaces = make_surfaces(
      views.size(), [&](std::size_t i) { return ViewSurface(views[i], surface); },
      [&](double part) { return report_progress(progress, part, "preparing views"); });
  if (!surfaces) return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
  release_freed_memory();
  return *std::move(surfaces);
}

}  // namespace

ViewSurfaceOptions surface_options(const AlignOptions& options) {
  ViewSurfaceOptions surface = options.surface;
  surface.neighbour_index |= options.refinement.association == Association::kNearest ||
                             options.starting_poses.association == Association::kNearest;
  return surface;
}

Result<PreparedViews> prepare_to_align(const std::vector<RangeView>& views,
                                       const AlignOptions& options, const Context& context) {
  if (views.empty()) return Error{ErrorKind::kBadInput, "there are no views to align"};
  if (const auto why = invalid_option(options); !why.empty())
    return Error{ErrorKind::kBadInput, "alignment options: " + why};
  if (const RangeView* view = view_without_projection(views, options))
    return Error{ErrorKind::kBadInput,
                 "view " + view->name +
                     ": its camera has no projection of points to pixels; use "
                     "the association auto or nearest"};
  const ViewSurfaceOptions surface = surface_options(options);
  auto surfaces = build_surfaces(views, surface, context.progress);
  if (!surfaces) return surfaces.error();
  return PreparedViews{std::move(*surfaces), AlignUnits(context.store, views, surface)};
}

}  // namespace relief::registration
