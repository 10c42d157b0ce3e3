#include "registration/global/unplaced_reason.h"

#include <cstddef>
#include <cstdio>
#include <numbers>

#include "registration/global/links/moved_piece.h"

namespace relief::registration {

namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

// What a pose lacks that nothing contradicts, after "sharing ..., where surfaces differ by ...".
std::string describe_lack(const PoseEvidence& evidence, const ViewSurface& a,
                          const ViewSurface& b) {
  const double enough = ViewGroupOptions().lone_overlap;
  if (evidence.overlap < enough)
    return "; sharing less than " + in_percent(enough) +
           ", it needs a third view that overlaps both and confirms it";
  if (relative_coherent_rms(evidence, a, b) > VerificationThresholds().max_coherent_rms ||
      misfits_locally(evidence, a, b))
    return ", neighbouring samples alike, as at wrong poses";
  return ", more than where other pairs of these views fit";
}

// What is known of the best pose that was found but not believed.
std::string describe_rejected(const PoseLink& link, std::size_t view,
                              const std::vector<RangeView>& views,
                              const std::vector<ViewSurface>& surfaces) {
  const PoseEvidence& evidence = link.evidence;
  const double spacings = evidence.rms / coarser_spacing(surfaces[link.a], surfaces[link.b]);
  char text[160];
  std::snprintf(text, sizeof text,
                "where surfaces differ by %.2g sample spacings (RMS), normals by %.0f degrees",
                spacings, evidence.normal_rms * kDegreesPerRadian);
  std::string against;
  if (violates_free_space(evidence))
    against += ", and " + in_percent(evidence.free_space_violation) + " stands in space seen empty";
  if (misses_coverage(evidence))
    against += ", and one of the two saw nothing in place of " +
               in_percent(evidence.missing_coverage) + " of what faces it";
  if (moved_before_still_sensor(surfaces[link.a], surfaces[link.b], link.b_from_a))
    against +=
        ", and both were taken from one place while something moved: if that is the object, leave "
        "out what stands still (a mask per view)";
  if (against.empty()) against = describe_lack(evidence, surfaces[link.a], surfaces[link.b]);
  return "the best is next to " + views[link.a == view ? link.b : link.a].name + ", sharing " +
         in_percent(evidence.overlap) + ", " + text + against;
}

std::string describe_ambiguity(const AmbiguousPair& pair, const std::string& other) {
  if (!pair.second_overlap)
    return "shares " + in_percent(pair.overlap) + " with " + other +
           ", but only shapes that fit at other poses, too, as flat or round ones";
  return "fits " + other + " in more ways than one (overlaps " + in_percent(pair.overlap) +
         " and " + in_percent(*pair.second_overlap) + "), its shape is symmetric or too plain";
}

}  // namespace

std::string in_percent(double fraction) {
  char text[16];
  std::snprintf(text, sizeof text, "%.0f %%", 100.0 * fraction);
  return text;
}

namespace {

std::string why_unplaced(std::size_t view, const ViewGroups& placed, const CheckedPoses& checked,
                         const std::vector<RangeView>& views,
                         const std::vector<ViewSurface>& surfaces,
                         const StartingPoseOptions& options) {
  for (const AmbiguousPair& pair : placed.ambiguous) {
    if (placed.group[pair.a] != placed.group[view] && placed.group[pair.b] != placed.group[view])
      continue;
    const std::size_t other = placed.group[pair.a] == placed.group[view] ? pair.b : pair.a;
    return "it is ambiguous: it " + describe_ambiguity(pair, views[other].name) +
           (checked.refuted[view]
                ? "; other views saw through where it stands at its given pose: give a better "
                  "guess in world_from_view, or leave out what stands still, as a wall (a mask per "
                  "view)"
                : "; give a guess in world_from_view");
  }
  std::string why;
  if (checked.refuted[view])
    why = "at its given pose it stands where other views saw through, and fits none of them; ";
  else if (checked.world_from_view[view])
    why = "other given poses are wrong, and nothing confirms its own; ";
  if (!options.search) return why + "give a better guess in world_from_view or remove it";
  const std::string found =
      placed.best_rejected.empty() || !placed.best_rejected[view]
          ? "no pose was found at which it shares " + in_percent(options.min_overlap) +
                " with another view"
          : "no pose was found that can be believed: " +
                describe_rejected(*placed.best_rejected[view], view, views, surfaces);
  return why + found + "; add a view between or give a guess in world_from_view" +
         (why.empty() ? "" : ", or keep its pose with --poses trust");
}

}  // namespace

std::string unplaced_reason(std::size_t view, const ViewGroups& placed, const CheckedPoses& checked,
                            const std::vector<RangeView>& views,
                            const std::vector<ViewSurface>& surfaces,
                            const StartingPoseOptions& options) {
  const std::string reason = why_unplaced(view, placed, checked, views, surfaces, options);
  if (placed.denied_by_plane.empty() || !placed.denied_by_plane[view]) return reason;
  return reason +
         "; what stands clear of the plane that is most of it fits other views, but there the "
         "planes do not lie on each other: if that is a wall or a table that did not move with the "
         "object, leave it out (a mask per view, or a crop of the images)";
}

}  // namespace relief::registration
