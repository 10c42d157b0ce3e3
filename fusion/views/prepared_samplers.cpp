#include "fusion/views/prepared_samplers.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

#include "fusion/views/contradicted_views.h"
#include "fusion/views/unshared_samples.h"
#include "scan/base/name_list.h"
#include "scan/base/parallel.h"
#include "scan/base/usable_pose.h"
#include "scan/grid/binned_view.h"

namespace relief::fusion {

namespace {

using SharedView = std::shared_ptr<const RangeView>;

// What preparing a view takes for a while, per pixel of its grid [bytes]: normals, edges, borders,
// and a copy of it with its small gaps filled.
constexpr std::size_t kPreparation = 150;

// Samples to a voxel, along each axis, of a raw view that is merged with large voxels: a lattice
// that takes single ones keeps their noise. With half as many, edges suffer (docs/results.md).
constexpr double kSamplesOfVoxel = 4.0;

// The view with pixels as large as voxels admit. Refined samples have no noise of their own.
SharedView as_large_as_needed(const SharedView& view, double voxel_size) {
  if (!(voxel_size > 0.0) || view->samples == SampleOrigin::kRefined) return view;
  const double spacing = rough_spacing(*view);
  if (!(spacing > 0.0)) return view;
  const double factor = std::min(voxel_size / (kSamplesOfVoxel * spacing), 1000.0);
  auto binned = bin_view(*view, static_cast<int>(factor));
  return binned ? std::make_shared<const RangeView>(std::move(*binned)) : view;
}

// Adds views begin to end - 1, prepared side by side. `any_pose`: whether one had a pose so far.
Result<void> add_views(const ViewSource& views, std::size_t begin, std::size_t end,
                       double voxel_size, const PagedSurfaceOptions& options,
                       PreparedSamplers& prepared, bool& any_pose) {
  std::vector<SharedView> used;
  std::vector<std::size_t> index;
  for (std::size_t i = begin; i < end; ++i) {
    auto view = views.load(i);
    if (!view) return view.error();
    if (has_usable_pose(**view, views.count)) {
      used.push_back(std::move(view).value());
      index.push_back(i);
      continue;
    }
    prepared.notes.push_back("view `" + (*view)->name +
                             "` has no pose and is left out; align it first");
  }
  any_pose = any_pose || !used.empty();
  for (const auto& view : used) evict_pages(options.memory, kPreparation * view->range.size());
  using Prepared = std::optional<Result<ViewSampler>>;
  auto samplers = parallel_map<Prepared>(used.size(), [&](std::size_t k) {
    return Prepared(ViewSampler::create(*as_large_as_needed(used[k], voxel_size), options));
  });
  for (std::size_t k = 0; k < used.size(); ++k) {
    if (!*samplers[k]) return samplers[k]->error();
    if ((*samplers[k])->empty()) {
      prepared.notes.push_back("view `" + used[k]->name +
                               "` has no connected samples and is left out");
      continue;
    }
    prepared.samplers.push_back(std::move(**samplers[k]));
    prepared.indices.push_back(
        static_cast<std::uint16_t>(std::min<std::size_t>(index[k], kNoSourceView)));
  }
  return check(options.memory);
}

std::string note_on_contradicted(const std::vector<std::string>& names, std::size_t samples,
                                 std::size_t left) {
  const bool one = names.size() == 1;
  std::ostringstream note;
  note << (one ? "view " : "views ") << name_list(names) << (one ? " contradicts" : " contradict")
       << " the others: more than a tenth of the samples are far from where two or more others "
          "agree, and more than twice as many as usual; the pose is wrong, or the image is "
          "mirrored or bent, or something moved; "
       << (one ? "it counts" : "they count") << " only where no other view measured, with "
       << std::lround(100.0 * static_cast<double>(left) / static_cast<double>(samples))
       << " % of the samples; --keep-contradicted takes all";
  return note.str();
}

}  // namespace

Result<void> prepare_contradicted(const ViewSource& views, double voxel_size,
                                  const PagedSurfaceOptions& options, const RangeErrors& errors,
                                  PreparedSamplers& prepared, MergeSummary& result) {
  const auto judged = judge_views(prepared.samplers, errors);
  std::vector<const ViewSampler*> others;
  std::vector<std::size_t> contradicted;
  for (std::size_t k = 0; k < judged.size(); ++k) {
    if (judged[k].contradicted && prepared.indices[k] != kNoSourceView)
      contradicted.push_back(k);
    else
      others.push_back(&prepared.samplers[k]);
  }
  if (contradicted.empty()) return {};
  std::size_t samples = 0, left = 0;
  std::vector<std::pair<std::size_t, ViewSampler>> anew;
  for (const std::size_t k : contradicted) {
    const auto view = views.load(prepared.indices[k]);
    if (!view) return view.error();
    const auto unshared = unshared_samples(**view, prepared.samplers[k], others);
    if (!unshared) return unshared.error();
    auto sampler = ViewSampler::create(
        *as_large_as_needed(std::make_shared<const RangeView>(*unshared), voxel_size), options);
    if (!sampler) return sampler.error();
    samples += (*view)->sample_count();
    left += unshared->sample_count();
    result.contradicted_views.push_back((*view)->name);
    anew.emplace_back(k, std::move(*sampler));
  }
  for (auto& [k, sampler] : anew) prepared.samplers[k] = std::move(sampler);
  for (std::size_t k = prepared.samplers.size(); k-- > 0;) {
    if (!prepared.samplers[k].empty()) continue;
    prepared.samplers.erase(prepared.samplers.begin() + static_cast<std::ptrdiff_t>(k));
    prepared.indices.erase(prepared.indices.begin() + static_cast<std::ptrdiff_t>(k));
  }
  result.notes.push_back(note_on_contradicted(result.contradicted_views, samples, left));
  return check(options.memory);
}

Result<PreparedSamplers> prepare_samplers(const ViewSource& views, double voxel_size,
                                          const PagedSurfaceOptions& options,
                                          const Progress& progress) {
  if (views.count == 0) return Error{ErrorKind::kUnsolvable, "there are no views to merge"};
  PreparedSamplers prepared;
  bool any_pose = false;
  // Side by side as many as there are threads; under a limit one after the other.
  const auto at_once = options.memory ? 1 : static_cast<std::size_t>(thread_count());
  for (std::size_t i = 0; i < views.count; i += at_once) {
    if (!report_progress(progress, static_cast<double>(i) / static_cast<double>(views.count),
                         "prepare views"))
      return Error{ErrorKind::kInterrupted, "merging was interrupted"};
    const std::size_t end = std::min(i + at_once, views.count);
    if (const auto added = add_views(views, i, end, voxel_size, options, prepared, any_pose);
        !added)
      return added.error();
  }
  if (!prepared.samplers.empty()) return prepared;
  if (!any_pose)
    return Error{ErrorKind::kUnsolvable, "no view has a pose: align the views before merging"};
  return Error{ErrorKind::kUnsolvable, "no view with a pose has connected samples to merge"};
}

}  // namespace relief::fusion
