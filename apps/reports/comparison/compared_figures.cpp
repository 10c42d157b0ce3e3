#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "apps/reports/comparison/run_comparison.h"
#include "apps/reports/html/viewer/model_statistics.h"
#include "scan/evaluation/base/angles.h"

namespace relief {

namespace {

using Reading = std::function<std::optional<double>(const RunFolder&)>;

// Where a figure of a run is found.
struct FigureSource {
  const char *key, *title;
  Quantity quantity;
  Reading read;
};

struct FigureGroup {
  const char* name;
  std::vector<FigureSource> sources;
};

std::string alignment_views(const RunFolder& run) { return run.report.alignment() + "/views"; }

Reading at(const std::string& place) {
  return [place](const RunFolder& run) { return run.report.number(place); };
}

Reading truth_at(const std::string& place) {
  return [place](const RunFolder& run) -> std::optional<double> {
    const auto truth = run.report.truth(place);
    return truth ? std::optional(*truth ? 1.0 : 0.0) : std::nullopt;
  };
}

Reading in_alignment(const std::string& key) {
  return [key](const RunFolder& run) { return run.report.number(run.report.alignment() + key); };
}

// How many entries of an array are as wanted; nothing if there is no such array.
std::optional<double> count_in(const RunFolder& run, const std::string& place,
                               const std::function<bool(const std::string& entry)>& wanted) {
  if (!run.report.find(place)) return std::nullopt;
  const auto entries = run.report.entries(place);
  return static_cast<double>(std::count_if(entries.begin(), entries.end(), wanted));
}

Reading count_of_alignment(const std::string& array, const std::string& key,
                           const std::string& text) {
  return [=](const RunFolder& run) {
    return count_in(run, run.report.alignment() + array, [&](const std::string& entry) {
      return text.empty() || run.report.text(entry + key) == text;
    });
  };
}

std::vector<double> numbers_in(const RunFolder& run, const std::string& place,
                               const std::string& key) {
  std::vector<double> numbers;
  for (const std::string& entry : run.report.entries(place))
    if (const auto number = run.report.number(entry + key)) numbers.push_back(*number);
  return numbers;
}

std::optional<double> sum(const std::vector<double>& numbers) {
  if (numbers.empty()) return std::nullopt;
  double sum = 0.0;
  for (const double number : numbers) sum += number;
  return sum;
}

std::optional<double> median(std::vector<double> numbers) {
  if (numbers.empty()) return std::nullopt;
  return evaluation::summarize(std::move(numbers)).median;
}

Reading sum_of(const std::string& place, const std::string& key) {
  return [=](const RunFolder& run) { return sum(numbers_in(run, place, key)); };
}

Reading median_of(const std::string& place, const std::string& key) {
  return [=](const RunFolder& run) { return median(numbers_in(run, place, key)); };
}

// Median over the placed views of the length of three entries of `pose_std`, from `first` on.
Reading pose_std(int first, double factor) {
  return [=](const RunFolder& run) {
    std::vector<double> lengths;
    for (const std::string& view : run.report.entries(alignment_views(run))) {
      if (!run.report.truth(view + "/aligned").value_or(false)) continue;
      double squares = 0.0;
      for (int k = first; k < first + 3; ++k) {
        const auto entry = run.report.number(view + "/pose_std/" + std::to_string(k));
        squares += entry ? *entry * *entry : 0.0;
      }
      lengths.push_back(factor * std::sqrt(squares));
    }
    return median(std::move(lengths));
  };
}

Reading of_model(const std::function<double(const TriangleMesh&)>& measure) {
  return [measure](const RunFolder& run) {
    return run.model ? std::optional(measure(*run.model)) : std::nullopt;
  };
}

Reading expected_error(double fraction) {
  return [fraction](const RunFolder& run) -> std::optional<double> {
    if (!run.model) return std::nullopt;
    std::vector<float> errors = measured_errors(*run.model);
    return errors.empty() ? std::nullopt : std::optional<double>(quantile(errors, fraction));
  };
}

constexpr const char* kStages[] = {"align",  "calibrate",   "compare",
                                   "refine", "align_again", "merge"};

std::optional<double> seconds_of_all(const RunFolder& run) {
  std::vector<double> seconds;
  for (const char* stage : kStages)
    if (const auto number = run.report.number(std::string("/") + stage + "/seconds"))
      seconds.push_back(*number);
  return sum(seconds);
}

FigureGroup alignment_figures() {
  return {"alignment",
          {{"views", "Views", Quantity::kCount, count_of_alignment("/views", "", "")},
           {"views_placed", "Views placed", Quantity::kCount,
            [](const RunFolder& run) {
              return count_in(run, alignment_views(run), [&](const std::string& entry) {
                return run.report.truth(entry + "/aligned").value_or(false);
              });
            }},
           {"views_verified", "Views verified", Quantity::kCount,
            count_of_alignment("/views", "/status", "verified")},
           {"pairs", "Pairs of views", Quantity::kCount, count_of_alignment("/pairs", "", "")},
           {"pairs_firm", "Firm pairs", Quantity::kCount,
            count_of_alignment("/pairs", "/grade", "firm")},
           {"rms", "Residual of the pairs, RMS", Quantity::kLength, in_alignment("/rms")},
           {"pose_std_rotation", "Standard deviation of a rotation, median", Quantity::kAngle,
            pose_std(0, evaluation::degrees(1.0))},
           {"pose_std_translation", "Standard deviation of a position, median", Quantity::kLength,
            pose_std(3, 1.0)},
           {"iterations", "Iterations", Quantity::kCount, in_alignment("/iterations")}}};
}

FigureGroup refinement_figures() {
  return {"refinement",
          {{"samples_compared", "Samples compared with other views", Quantity::kCount,
            sum_of("/compare/views", "/samples_compared")},
           {"samples_contradicted", "Samples contradicted", Quantity::kCount,
            sum_of("/compare/views", "/samples_contradicted")},
           {"samples_corrected", "Samples corrected", Quantity::kCount,
            sum_of("/compare/views", "/samples_corrected")},
           {"views_refined", "Views refined", Quantity::kCount,
            [](const RunFolder& run) {
              return count_in(run, "/refine/views", [&](const std::string& entry) {
                return run.report.text(entry + "/status") == "refined";
              });
            }},
           {"samples_refined", "Samples refined", Quantity::kCount,
            sum_of("/refine/views", "/samples_refined")},
           {"flying_samples", "Flying samples left out", Quantity::kCount,
            sum_of("/refine/views", "/flying_samples")},
           {"filled_samples", "Samples filled in gaps", Quantity::kCount,
            sum_of("/refine/views", "/filled_samples")},
           {"sigma_position", "Noise of ranges, median of the views", Quantity::kLength,
            median_of("/refine/views", "/sigma_position")},
           {"sigma_normal_deg", "Noise of normals, median", Quantity::kAngle,
            median_of("/refine/views", "/sigma_normal_deg")},
           {"rms_change", "Moved by refining, median", Quantity::kLength,
            median_of("/refine/views", "/rms_change")},
           {"median_deviation", "Expected error of a refined sample, median", Quantity::kLength,
            median_of("/refine/views", "/median_deviation")}}};
}

FigureGroup model_figures() {
  return {
      "model",
      {{"vertices", "Vertices", Quantity::kCount, at("/merge/vertices")},
       {"faces", "Faces", Quantity::kCount, at("/merge/faces")},
       {"watertight", "Watertight", Quantity::kTruth, truth_at("/merge/watertight")},
       {"boundary_edges", "Boundary edges", Quantity::kCount, at("/merge/boundary_edges")},
       {"components", "Components", Quantity::kCount, at("/merge/components")},
       {"genus", "Genus (handles)", Quantity::kCount, at("/merge/genus")},
       {"volume", "Volume", Quantity::kVolume, at("/merge/volume")},
       {"area", "Area", Quantity::kArea, of_model(surface_area)},
       {"filled_area_fraction", "Area filled", Quantity::kFraction,
        at("/merge/filled_area_fraction")},
       {"expected_error", "Expected error, median", Quantity::kLength, expected_error(0.5)},
       {"expected_error_p95", "Expected error, 95 % of the vertices", Quantity::kLength,
        expected_error(0.95)},
       {"polish_move", "Moved by polishing, RMS", Quantity::kLength, at("/merge/polish/rms_move")},
       {"voxel_size", "Voxel size", Quantity::kLength, at("/merge/voxel_size")},
       {"components_removed", "Components removed", Quantity::kCount,
        at("/merge/components_removed")}}};
}

FigureGroup cost_figures() {
  return {
      "cost",
      {{"seconds", "Time of all stages", Quantity::kTime, seconds_of_all},
       {"seconds_align", "Time to align", Quantity::kTime, at("/align/seconds")},
       {"seconds_calibrate", "Time to calibrate sensors", Quantity::kTime,
        at("/calibrate/seconds")},
       {"seconds_compare", "Time to compare views", Quantity::kTime, at("/compare/seconds")},
       {"seconds_refine", "Time to refine", Quantity::kTime, at("/refine/seconds")},
       {"seconds_align_again", "Time to align again", Quantity::kTime, at("/align_again/seconds")},
       {"seconds_merge", "Time to merge", Quantity::kTime, at("/merge/seconds")},
       {"peak_memory_mb", "Largest memory", Quantity::kMemory, at("/merge/peak_memory_mb")}}};
}

bool has_length(Quantity quantity) {
  return quantity == Quantity::kLength || quantity == Quantity::kArea ||
         quantity == Quantity::kVolume;
}

}  // namespace

std::optional<double> ComparedFigure::difference() const {
  if (!a || !b || !same_unit || quantity == Quantity::kTruth) return std::nullopt;
  return *b - *a;
}

std::optional<double> ComparedFigure::ratio() const {
  if (!a || !b || !same_unit || quantity == Quantity::kTruth || *a == 0.0) return std::nullopt;
  return *b / *a;
}

std::vector<ComparedFigure> compare_figures(const RunFolder& a, const RunFolder& b) {
  const bool same_unit = a.unit == b.unit || a.unit.empty() || b.unit.empty();
  std::vector<ComparedFigure> figures;
  for (const FigureGroup& group :
       {alignment_figures(), refinement_figures(), model_figures(), cost_figures()})
    for (const FigureSource& source : group.sources)
      figures.push_back({.group = group.name,
                         .key = source.key,
                         .title = source.title,
                         .quantity = source.quantity,
                         .a = source.read(a),
                         .b = source.read(b),
                         .same_unit = same_unit || !has_length(source.quantity)});
  return figures;
}

}  // namespace relief
