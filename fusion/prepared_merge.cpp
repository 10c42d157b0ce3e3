#include "fusion/prepared_merge.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "fusion/views/inter_view_errors.h"
#include "scan/base/median.h"
#include "scan/base/median_deviation.h"
#include "scan/base/parallel.h"
#include "scan/grid/binned_view.h"
#include "scan/units/content_hash.h"
#include "scan/units/input_hash.h"

namespace relief::fusion {

namespace {

struct SampleQuality {
  double deviation = 0.0;  // Median of the views' median deviations; 0: no view has any.
  bool refined = false;    // Any view is.
};

struct Inputs {
  SampleQuality quality;
  std::size_t samples = 0;          // Of all views.
  double spacing = 0.0;             // Median of the views' spacings, where wanted [unit].
  std::vector<std::string> hashes;  // Of the views, where units are kept.
};

Result<Inputs> look_at(const ViewSource& views, bool spaced, bool hashed, MemoryLimit* memory) {
  Inputs inputs;
  SampleQuality& quality = inputs.quality;
  std::vector<double> medians, spacings;
  for (std::size_t i = 0; i < views.count; ++i) {
    const auto view = views.load(i);
    if (!view) return view.error();
    const double known = median_deviation(**view);
    if (known > 0.0) medians.push_back(known);
    inputs.samples += (*view)->sample_count();
    if (const double spacing = spaced ? rough_spacing(**view) : 0.0; spacing > 0.0)
      spacings.push_back(spacing);
    quality.refined |= (*view)->samples == SampleOrigin::kRefined;
    if (hashed) inputs.hashes.push_back(hash_of_view(**view));
    if (const auto kept = check(memory); !kept) return kept.error();
  }
  quality.deviation = median(std::move(medians));
  inputs.spacing = median(std::move(spacings));
  return inputs;
}

// Of all samples: worth a note.
constexpr double kManyNoisy = 0.01;

// `samples`: of all views.
void count_samples(const std::vector<ViewSampler>& views, std::size_t samples,
                   MergeSummary& result) {
  for (const ViewSampler& view : views) {
    result.flying_samples += view.flying();
    result.filled_samples += view.filled();
    result.noisy_samples += view.noisy();
  }
  if (static_cast<double>(result.noisy_samples) > kManyNoisy * static_cast<double>(samples))
    result.notes.push_back(std::to_string(result.noisy_samples) +
                           " samples are far noisier than the others, and than their spacing: they "
                           "tell which space is empty, not where the surface is");
}

// Refined views hold detail that a lattice as coarse as the samples blurs; in raw views there is
// only noise below the spacing (docs/results.md, Voxel size).
constexpr double kRefinedVoxel = 0.8;  // [sample spacings]

// So many times as coarse as the finest view, a lattice loses detail that is worth a note.
constexpr double kMuchCoarser = 2.0;

void note_lost_detail(const std::vector<double>& spacings, MergeSummary& result) {
  const auto [finest, coarsest] = std::minmax_element(spacings.begin(), spacings.end());
  if (!(result.voxel_size > kMuchCoarser * *finest)) return;
  std::ostringstream note;
  note << std::setprecision(2) << "the sample spacings of the views are from " << *finest << " to "
       << *coarsest << ", and voxels are as large as in the typical view, " << result.voxel_size
       << ": --voxel " << *finest << " keeps the detail of the finest";
  result.notes.push_back(note.str());
}

// Samples know their noise, whatever the range. What views differ by beyond it is not shared.
void take_known_deviations(double nominal, RangeErrors& errors) {
  errors.exponent = 0.0;
  errors.nominal_deviation = nominal;
  errors.excess_variance = std::max(0.0, errors.stddev * errors.stddev - nominal * nominal);
}

void choose_scales(const std::vector<ViewSampler>& views, const MergeOptions& options, bool refined,
                   const RangeErrors& errors, MergeSummary& result) {
  std::vector<double> spacings, noises;
  for (const ViewSampler& view : views) {
    spacings.push_back(view.spacing());
    noises.push_back(view.noise());
  }
  result.view_noise = median(noises);
  result.voxel_size = options.voxel_size > 0.0 ? options.voxel_size
                                               : (refined ? kRefinedVoxel : 1.0) * median(spacings);
  if (options.voxel_size == 0.0) note_lost_detail(spacings, result);
  result.inter_view_stddev = errors.stddev;
  result.range_exponent = errors.exponent;
  const double deviation = view_stddev(result);
  result.truncation =
      options.truncation > 0.0
          ? options.truncation
          : std::max(3.0 * result.voxel_size, kTruncatedDeviations * deviation + result.voxel_size);
}

void note_files_in_memory(const MemoryLimit* limit, std::vector<std::string>& notes) {
  if (limit && limit->folder_is_memory())
    notes.push_back("temporary files in " + limit->folder().string() +
                    " lie in memory themselves: the limit spares the machine nothing");
}

}  // namespace

Result<PreparedMerge> prepare_merge(const ViewSource& views, const MergeOptions& options,
                                    UnitStore* store, MemoryLimit* memory, const Progress& progress,
                                    MergeSummary& result) {
  note_files_in_memory(memory, result.notes);
  const auto inputs = look_at(views, options.voxel_size > 0.0, store != nullptr, memory);
  if (!inputs) return inputs.error();
  const SampleQuality& quality = inputs->quality;
  PagedSurfaceOptions surfaces{.memory = memory};
  surfaces.weights.silhouette_ramp = options.silhouette_ramp;
  surfaces.weights.nominal_deviation = quality.deviation;
  auto prepared = prepare_samplers(views, options.voxel_size, surfaces, progress);
  if (!prepared) return prepared.error();
  std::vector<ViewSampler>& samplers = prepared->samplers;
  result.notes.insert(result.notes.end(), prepared->notes.begin(), prepared->notes.end());
  release_freed_memory();
  count_samples(samplers, inputs->samples, result);
  RangeErrors errors = inter_view_errors(samplers);
  if (!options.keep_contradicted) {
    for (ViewSampler& sampler : samplers) sampler.set_range_errors(errors);
    if (const auto kept =
            prepare_contradicted(views, options.voxel_size, surfaces, errors, *prepared, result);
        !kept)
      return kept.error();
    if (!result.contradicted_views.empty()) errors = inter_view_errors(samplers);
  }
  if (quality.deviation > 0.0) take_known_deviations(quality.deviation, errors);
  for (ViewSampler& sampler : samplers) sampler.set_range_errors(errors);
  choose_scales(samplers, options, quality.refined, errors, result);
  return PreparedMerge{std::move(*prepared), quality.deviation, inputs->spacing,
                       FieldUnits(store, ContentHash().add(inputs->hashes, options).hex())};
}

ClosedFieldOptions field_options(const MergeSummary& chosen, const FieldUnits& units,
                                 MemoryLimit* memory) {
  ClosedFieldOptions options;
  options.voxel_size = chosen.voxel_size;
  options.truncation = chosen.truncation;
  options.memory = memory;
  options.units = units;
  return options;
}

double view_stddev(const MergeSummary& chosen) {
  return std::max(chosen.view_noise, chosen.inter_view_stddev);
}

Progress part_of(const Progress& whole, double begin, double end) {
  return [&whole, begin, end](double fraction, std::string_view step) {
    return report_progress(whole, begin + fraction * (end - begin), step);
  };
}

ViewSource source_of(const std::vector<RangeView>& views) {
  return {views.size(), [&views](std::size_t i) -> Result<std::shared_ptr<const RangeView>> {
            return std::shared_ptr<const RangeView>(std::shared_ptr<void>(), &views[i]);
          }};
}

}  // namespace relief::fusion
