#include "scan/io/project/loading/settled_views.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "scan/io/files/file_ending.h"

namespace relief {

namespace {

// Of the points that a view had on other rays, so many are on those from the origin: else they
// hide each other, and were not seen from there.
constexpr double kKept = 0.8;
// Of the normals, so many at most look away from the origin: all do of an object round it, and
// half of them where a program has not oriented them.
constexpr double kAverted = 0.75;

double averted_part(const LoadedView& loaded) {
  if (!loaded.normals) return 0.0;
  const Grid<Eigen::Vector3f>& normals = loaded.normals->components;
  std::size_t all = 0, averted = 0;
  for (int v = 0; v < normals.height(); ++v)
    for (int u = 0; u < normals.width(); ++u) {
      if (!normals(u, v).allFinite() || !loaded.view.has_sample(u, v)) continue;
      ++all;
      averted += normals(u, v).cast<double>().dot(loaded.view.point(u, v)) > 0.0 ? 1 : 0;
    }
  return all > 0 ? static_cast<double>(averted) / static_cast<double>(all) : 0.0;
}

}  // namespace

std::vector<std::size_t> views_to_see_from_origin(const std::vector<AssumedViewpoint>& viewpoints) {
  const auto at_origin = std::ranges::count(viewpoints, AssumedViewpoint::kOrigin);
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < viewpoints.size(); ++i)
    if (viewpoints[i] == AssumedViewpoint::kFarOff) others.push_back(i);
  if (std::cmp_less_equal(at_origin, others.size())) others.clear();
  return others;
}

AssumedViewpoint viewpoint_in_set(const ViewSpec& spec, const LoadedView& loaded) {
  const bool other_frame = spec.grid_options.shared_frame ||
                           (spec.pose == PoseKind::kAbsent && loaded.view.pose != spec.pose);
  return other_frame ? AssumedViewpoint::kNone : loaded.assumed_viewpoint;
}

bool see_from_origin(ViewSpec& spec, LoadedView& loaded) {
  ViewSpec other = spec;
  other.grid_options.viewpoint = Eigen::Vector3d::Zero();
  auto seen = load_view(other);
  if (!seen || averted_part(*seen) > kAverted ||
      static_cast<double>(seen->view.sample_count()) <
          kKept * static_cast<double>(loaded.view.sample_count()))
    return false;
  seen->assumed_viewpoint = AssumedViewpoint::kOrigin;
  seen->notes.push_back("view " + spec.name +
                        ": taken as seen from the origin of the frame, as most clouds of the set "
                        "are; alone it would be taken as seen from far off");
  spec = std::move(other);
  loaded = std::move(*seen);
  return true;
}

std::optional<RigidMotion> pose_of_file(const ViewSpec& spec, const LoadedView& loaded) {
  if (spec.pose != PoseKind::kAbsent || loaded.view.pose != PoseKind::kGuess ||
      spec.grid_options.shared_frame || !spec.grid || lower_ending(*spec.grid) != ".pcd")
    return std::nullopt;
  return loaded.view.world_from_view;
}

bool is_constant(const std::vector<std::optional<RigidMotion>>& poses_of_files) {
  return poses_of_files.size() > 1 && std::ranges::all_of(poses_of_files, [&](const auto& pose) {
           return pose && poses_of_files.front() &&
                  pose->matrix() == poses_of_files.front()->matrix();
         });
}

Result<ConventionChoice> settle_views(std::vector<ViewSpec>& specs) {
  std::vector<AssumedViewpoint> viewpoints(specs.size(), AssumedViewpoint::kNone);
  std::vector<std::optional<NormalEvidence>> evidence(specs.size());
  const auto take_evidence = [&](LoadedView& loaded, std::size_t i) {
    evidence[i].reset();
    if (loaded.normals) evidence[i] = std::move(loaded.normals->evidence);
  };
  for (std::size_t i = 0; i < specs.size(); ++i) {
    if (!specs[i].normals && !specs[i].grid) continue;
    auto loaded = load_view(specs[i]);
    if (!loaded) return loaded.error();
    viewpoints[i] = viewpoint_in_set(specs[i], *loaded);
    take_evidence(*loaded, i);
  }
  ConventionChoice choice;
  for (const std::size_t i : views_to_see_from_origin(viewpoints)) {
    auto loaded = load_view(specs[i]);
    if (!loaded) return loaded.error();
    if (!see_from_origin(specs[i], *loaded)) continue;
    choice.notes.push_back(loaded->notes.back());
    take_evidence(*loaded, i);
  }
  std::vector<NormalEvidence> of_normals;
  for (auto& one : evidence)
    if (one) of_normals.push_back(std::move(*one));
  auto found = choose_conventions(of_normals);
  if (!found) return found;
  choice.notes.insert(choice.notes.end(), found->notes.begin(), found->notes.end());
  choice.views.resize(specs.size());
  auto chosen = found->views.begin();
  for (std::size_t i = 0; i < specs.size(); ++i)
    if (evidence[i]) choice.views[i] = *chosen++;
  return choice;
}

}  // namespace relief
