#include "reconstruction/cache/stage_units.h"

#include <utility>

#include "fusion/units/merge_units.h"
#include "reconstruction/cache/option_hash.h"
#include "reconstruction/cache/result_codec_private.h"
#include "scan/units/find_or_compute_private.h"
#include "scan/units/input_hash.h"

namespace relief::reconstruction {

namespace {

// What refining changes of a view: all else stays as it is given.
struct ViewGrids {
  Grid<double> range;
  Grid<Eigen::Vector3f> normals;
  Grid<float> confidence, deviation;
  Grid<Colour> colours;
  SampleOrigin samples = SampleOrigin::kRaw;
};

template <class Archive>
void serialize(Archive& archive, ViewGrids& grids) {
  auto& [range, normals, confidence, deviation, colours, samples] = grids;
  archive(range, normals, confidence, deviation, colours, samples);
}

ViewGrids grids_of(const RangeView& view) {
  return {view.range, view.normals, view.confidence, view.deviation, view.colours, view.samples};
}

void put_back(ViewGrids grids, RangeView& view) {
  view.range = std::move(grids.range);
  view.normals = std::move(grids.normals);
  view.confidence = std::move(grids.confidence);
  view.deviation = std::move(grids.deviation);
  view.colours = std::move(grids.colours);
  view.samples = grids.samples;
}

struct KeptRefinement {
  hybrid::RefineSummary summary;
  ViewGrids grids;
};

template <class Archive>
void serialize(Archive& archive, KeptRefinement& kept) {
  auto& [summary, grids] = kept;
  archive(summary, grids);
}

// What comparing changes of a contradicted view.
struct ComparedGrids {
  Grid<double> range;
  Grid<float> confidence, deviation;
};

template <class Archive>
void serialize(Archive& archive, ComparedGrids& grids) {
  auto& [range, confidence, deviation] = grids;
  archive(range, confidence, deviation);
}

struct KeptComparison {
  std::vector<ViewConsistency> consistency;
  std::vector<ComparedGrids> changed;  // The contradicted views, in their order.
};

template <class Archive>
void serialize(Archive& archive, KeptComparison& kept) {
  auto& [consistency, changed] = kept;
  archive(consistency, changed);
}

Result<KeptComparison> compare(const std::vector<registration::PairFit>& pairs,
                               const CrossViewOptions& options, std::vector<RangeView>& views,
                               const Context& context) {
  auto found = weigh_by_consistency(pairs, options, views, context);
  if (!found) return found.error();
  KeptComparison kept{std::move(*found), {}};
  for (std::size_t i = 0; i < views.size(); ++i)
    if (kept.consistency[i].contradicted > 0)
      kept.changed.push_back({views[i].range, views[i].confidence, views[i].deviation});
  return kept;
}

// Computes, or gives the error in place of it.
template <typename Compute>
auto unless(const MissingUnitError& error, Compute compute) {
  return [&error, compute]() -> decltype(compute()) {
    if (error) return *error;
    return compute();
  };
}

}  // namespace

Result<registration::Alignment> align_or_find(std::string_view kind,
                                              const std::vector<RangeView>& views,
                                              const registration::AlignOptions& options,
                                              const Context& context,
                                              const MissingUnitError& otherwise) {
  return find_or_compute<registration::Alignment>(
      context.store, [&] { return unit_key(kind, hashes_of_views(views), options); },
      unless(otherwise, [&] { return registration::align_views(views, options, context); }));
}

Result<std::size_t> search_or_find(const std::vector<RangeView>& views,
                                   const registration::AlignOptions& options,
                                   const registration::PairBlock& block, const Context& context,
                                   const MissingUnitError& otherwise) {
  return find_or_compute<std::size_t>(
      context.store,
      [&] { return unit_key("pairs", hashes_of_views(views), options, block.index, block.count); },
      unless(otherwise,
             [&] { return registration::search_pairs(views, options, block, context); }));
}

Result<registration::SensorCalibration> calibrate_or_find(
    const std::vector<RangeView>& views, const registration::Alignment& aligned,
    const registration::AlignOptions& align, const registration::CalibrationOptions& options,
    const Context& context, const MissingUnitError& otherwise) {
  return find_or_compute<registration::SensorCalibration>(
      context.store,
      [&] {
        return unit_key("calibrate", hashes_of_views(views), aligned.world_from_view(),
                        aligned.pairs, align, options);
      },
      unless(otherwise, [&] {
        return registration::calibrate_views(views, aligned, align, options, context);
      }));
}

Result<std::vector<ViewConsistency>> weigh_or_find(const std::vector<registration::PairFit>& pairs,
                                                   const CrossViewOptions& options,
                                                   std::vector<RangeView>& views,
                                                   const Context& context,
                                                   const MissingUnitError& otherwise) {
  if (context.store == nullptr && !otherwise)
    return weigh_by_consistency(pairs, options, views, context);
  bool computed = false;
  auto kept = find_or_compute<KeptComparison>(
      context.store, [&] { return unit_key("compare", hashes_of_views(views), pairs, options); },
      unless(otherwise, [&] {
        computed = true;
        return compare(pairs, options, views, context);
      }));
  if (!kept) return kept.error();
  auto changed = kept->changed.begin();
  for (std::size_t i = 0; i < views.size() && !computed; ++i) {
    if (kept->consistency[i].contradicted == 0) continue;
    views[i].range = std::move(changed->range);
    views[i].confidence = std::move(changed->confidence);
    views[i].deviation = std::move(changed->deviation);
    ++changed;
  }
  return std::move(kept->consistency);
}

Result<std::vector<hybrid::RefinedView>> refine_or_find(const std::vector<RangeView>& views,
                                                        const hybrid::RefineOptions& options,
                                                        const Context& context,
                                                        const MissingUnitError& otherwise) {
  if (context.store == nullptr && !otherwise) return hybrid::refine_views(views, options, context);
  const auto refine = [&](const RangeView& view, const hybrid::RefineOptions& view_options,
                          const Context& view_context) -> Result<hybrid::RefinedView> {
    auto kept = find_or_compute<KeptRefinement>(
        context.store,
        [&] { return unit_key("refine", hash_of_samples(view), view_options, view_context.seed); },
        [&]() -> Result<KeptRefinement> {
          if (otherwise)
            return Error{otherwise->kind, "view " + view.name + ": " + otherwise->message};
          auto refined = hybrid::refine_view(view, view_options, view_context);
          if (!refined) return refined.error();
          return KeptRefinement{*refined, grids_of(refined->view)};
        });
    if (!kept) return kept.error();
    hybrid::RefinedView refined{kept->summary, {}};
    refined.view.name = view.name;
    refined.view.camera = view.camera;
    refined.view.world_from_view = view.world_from_view;
    refined.view.pose = view.pose;
    put_back(std::move(kept->grids), refined.view);
    return refined;
  };
  return hybrid::refine_views(views, options, context, refine);
}

Result<std::size_t> field_part_or_find(const std::vector<RangeView>& views,
                                       const fusion::MergeOptions& options,
                                       const fusion::FieldPart& part, const Context& context,
                                       const MissingUnitError& otherwise) {
  return find_or_compute<std::size_t>(
      context.store,
      [&] {
        return unit_key("field_part", hashes_of_views(views), options, part.brick, part.bricks);
      },
      unless(otherwise, [&] { return fusion::compute_field_part(views, options, part, context); }));
}

Result<fusion::MergeResult> merge_or_find(const std::vector<std::string>& hashes,
                                          const std::vector<RangeView>& views,
                                          const fusion::MergeOptions& options,
                                          const Context& context,
                                          const MissingUnitError& otherwise) {
  return find_or_compute<fusion::MergeResult>(
      context.store, [&] { return unit_key("merge", hashes, options); },
      unless(otherwise, [&] { return fusion::merge_views(views, options, context); }));
}

Result<hybrid::PolishedMesh> polish_or_find(const std::vector<std::string>& hashes,
                                            const TriangleMesh& mesh,
                                            const std::vector<RangeView>& views,
                                            const hybrid::PolishOptions& options,
                                            const Context& context,
                                            const MissingUnitError& otherwise) {
  return find_or_compute<hybrid::PolishedMesh>(
      context.store, [&] { return unit_key("polish", mesh, hashes, options); },
      unless(otherwise, [&] { return hybrid::polish_mesh(mesh, views, options, context); }));
}

}  // namespace relief::reconstruction
