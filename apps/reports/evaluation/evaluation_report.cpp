#include "apps/reports/evaluation/evaluation_report.h"

#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "apps/reports/stages/model_report.h"
#include "scan/evaluation/base/angles.h"

namespace relief {

namespace {

Json to_json(const evaluation::ErrorStatistics& statistics) {
  return {{"count", statistics.count}, {"mean", statistics.mean}, {"median", statistics.median},
          {"rms", statistics.rms},     {"p95", statistics.p95},   {"max", statistics.max}};
}

// The figures over everything at the top, those of the parts below it.
Json to_json(const evaluation::SplitStatistics& split) {
  Json json = to_json(split.all);
  json["inner"] = to_json(split.inner);
  json["edge"] = to_json(split.edge);
  return json;
}

Json to_json(const evaluation::DirectedDistance& direction) {
  Json json = to_json(direction.distance);
  json["normals_deg"] = to_json(direction.normals_deg);
  json["within"] = direction.within;
  return json;
}

Json to_json(const evaluation::ViewErrors& view) {
  return {{"name", view.name},
          {"depth", to_json(view.depth)},
          {"depth_bias", view.depth_bias},
          {"geometry_normals_deg", to_json(view.position_normals_deg)},
          {"sampled_normals_deg", to_json(view.sampled_normals_deg)},
          {"map_normals_deg", to_json(view.map_normals_deg)},
          {"missing", view.missing},
          {"extra", view.extra}};
}

// Columns, so that a plotting tool can take them as they are.
Json to_json(const evaluation::ErrorSpectrum& spectrum) {
  Json json = {{"variance", spectrum.variance()},
               {"coverage", {spectrum.finest_coverage, spectrum.coarsest_coverage}}};
  for (const char* column : {"frequency", "density", "area", "tile", "tiles"})
    json[column] = Json::array();
  for (const evaluation::SpectrumBand& band : spectrum.bands) {
    json["frequency"].push_back(band.frequency);
    json["density"].push_back(band.density);
    json["area"].push_back(band.area);
    json["tile"].push_back(band.tile);
    json["tiles"].push_back(band.tiles);
  }
  return json;
}

// The error at wavelengths of [shorter, longer) samples, RMS; nothing when none were seen.
std::optional<double> deviation_between(const evaluation::ErrorSpectrum& spectrum, double shorter,
                                        double longer) {
  std::optional<double> power;
  for (const evaluation::SpectrumBand& band : spectrum.bands)
    if (shorter <= 1.0 / band.frequency && 1.0 / band.frequency < longer)
      power = power.value_or(0.0) + band.density * band.area;
  return power ? std::optional(std::sqrt(*power)) : std::nullopt;
}

void print_spectrum(const std::string& what, const evaluation::ErrorSpectrum& spectrum,
                    double factor) {
  if (spectrum.bands.empty()) return;
  fmt::print("{:<34}", what);
  for (const auto& [shorter, longer] :
       {std::pair{0.0, 4.0}, {4.0, 16.0}, {16.0, 64.0}, {64.0, 1e9}}) {
    const auto deviation = deviation_between(spectrum, shorter, longer);
    fmt::print(" {:>10}", deviation ? fmt::format("{:.4g}", factor * *deviation) : "-");
  }
  fmt::print("\n");
}

void print_head(const std::string& title) {
  fmt::print("{:<34} {:>10} {:>10} {:>10} {:>10} {:>10}\n", title, "mean", "median", "RMS", "95 %",
             "max");
}

void print_row(const std::string& what, const evaluation::ErrorStatistics& s) {
  if (s.count == 0) return;
  fmt::print("{:<34} {:>10.4g} {:>10.4g} {:>10.4g} {:>10.4g} {:>10.4g}\n", what, s.mean, s.median,
             s.rms, s.p95, s.max);
}

void print_faults(const MeshCheck& check) {
  const auto print = [](std::size_t count, const char* what) {
    if (count > 0) fmt::print("  {} {}\n", count, what);
  };
  print(check.boundary_edges, "boundary edges");
  print(check.non_manifold_edges, "edges of more than two faces");
  print(check.non_manifold_vertices, "vertices of more than one fan");
  print(check.inconsistent_edges, "edges between faces of opposite orientation");
  print(check.degenerate_faces, "faces without area");
  print(check.duplicate_vertices, "vertices at the place of another");
  print(check.unused_vertices, "vertices without a face");
  if (!check.self_intersections) return;
  const auto& found = *check.self_intersections;
  if (found.pairs.empty()) fmt::print("  no self-intersections\n");
  print(found.pairs.size(),
        found.complete ? "pairs of faces intersect" : "pairs of faces intersect, and more");
}

void print_direction(const std::string& what,
                     const std::optional<evaluation::DirectedDistance>& direction) {
  if (!direction) return;
  print_row(what, direction->distance);
  print_row("  normals [deg]", direction->normals_deg);
}

}  // namespace

Json to_json(const evaluation::DistanceReport& report) {
  Json json = to_json(report.all);
  if (report.measured) json["measured"] = to_json(*report.measured);
  if (report.filled) json["filled"] = to_json(*report.filled);
  return json;
}

Json to_json(const evaluation::MeshComparison& comparison, const MeshCheck& check) {
  return {{"accuracy", to_json(comparison.accuracy)},
          {"completeness", to_json(comparison.completeness)},
          {"thresholds", comparison.thresholds},
          {"f_score", comparison.f_score},
          {"filled_area_fraction", comparison.filled_fraction},
          {"topology", to_json(check)}};
}

Json to_json(const evaluation::ViewErrorReport& report) {
  Json json = to_json(report.overall);
  json.erase("name");
  json["unmatched"] = report.unmatched;
  json["views"] = Json::array();
  for (const evaluation::ViewErrors& view : report.views) json["views"].push_back(to_json(view));
  return json;
}

Json to_json(const evaluation::ViewSpectra& spectra) {
  Json json = {{"spacing", spectra.spacing},
               {"depth", to_json(spectra.depth)},
               {"geometry_normals", to_json(spectra.position_normals)},
               {"map_normals", to_json(spectra.map_normals)}};
  if (spectra.crossing_wavelength) {
    json["crossing_wavelength_samples"] = *spectra.crossing_wavelength;
    json["crossing_wavelength"] = *spectra.crossing_wavelength * spectra.spacing;
  }
  return json;
}

Json to_json(const evaluation::PoseErrorReport& report) {
  Json json = {{"mean_rotation_deg", report.mean_rotation_deg},
               {"max_rotation_deg", report.max_rotation_deg},
               {"mean_translation", report.mean_translation},
               {"max_translation", report.max_translation},
               {"mean_displacement", report.mean_displacement},
               {"rms_displacement", report.rms_displacement},
               {"max_displacement", report.max_displacement},
               {"truth_from_result", to_json(report.truth_from_result)},
               {"unmatched", report.unmatched},
               {"views", Json::array()}};
  for (const evaluation::PoseError& view : report.views)
    json["views"].push_back({{"name", view.name},
                             {"rotation_deg", view.rotation_deg},
                             {"translation", view.translation},
                             {"mean_displacement", view.mean_displacement},
                             {"rms_displacement", view.rms_displacement}});
  return json;
}

void print_table(const evaluation::MeshComparison& comparison, const MeshCheck& check,
                 const std::string& unit) {
  print_head(unit.empty() ? "distances" : "distances [" + unit + "]");
  print_direction("result to truth", comparison.accuracy.all);
  print_direction("  measured part", comparison.accuracy.measured);
  print_direction("  filled part", comparison.accuracy.filled);
  print_direction("truth to result", comparison.completeness.all);
  for (std::size_t i = 0; i < comparison.thresholds.size(); ++i) {
    const auto& accuracy = comparison.accuracy;
    fmt::print("within {:<8.4g} result {:6.2f} %", comparison.thresholds[i],
               100.0 * accuracy.all.within[i]);
    if (accuracy.measured)
      fmt::print(" (measured {:6.2f} %)", 100.0 * accuracy.measured->within[i]);
    fmt::print(", truth {:6.2f} %, F-score {:.4f}\n", 100.0 * comparison.completeness.all.within[i],
               comparison.f_score[i]);
  }
  fmt::print("{}: {} vertices, {} faces, {} components, genus {}, volume {:.6g}, {:.2f} % filled\n",
             check.watertight() ? "watertight" : "NOT watertight", check.vertices, check.faces,
             check.components, check.genus, check.volume, 100.0 * comparison.filled_fraction);
  print_faults(check);
}

void print_table(const evaluation::MutualDistances& distances, const std::string& unit) {
  print_head("distances [" + unit + "]");
  const auto print_way = [](const std::string& name, const evaluation::DistanceReport& way) {
    print_direction(name, way.all);
    print_direction("  measured part", way.measured);
    print_direction("  filled part", way.filled);
  };
  print_way("A to B", distances.a_to_b);
  print_way("B to A", distances.b_to_a);
  for (std::size_t i = 0; i < distances.thresholds.size(); ++i)
    fmt::print("within {:<8.4g} A {:6.2f} %, B {:6.2f} %\n", distances.thresholds[i],
               100.0 * distances.a_to_b.all.within[i], 100.0 * distances.b_to_a.all.within[i]);
}

void print_table(const evaluation::ViewErrorReport& report, const std::string& unit) {
  print_head(fmt::format("{} views", report.views.size()));
  const evaluation::ViewErrors& all = report.overall;
  print_row("depth [" + unit + "]", all.depth.all);
  print_row("  away from edges", all.depth.inner);
  print_row("  at edges", all.depth.edge);
  print_row("normals of the geometry [deg]", all.position_normals_deg.all);
  print_row("  away from edges", all.position_normals_deg.inner);
  print_row("  at edges", all.position_normals_deg.edge);
  print_row("  against exact samples'", all.sampled_normals_deg.all);
  print_row("normal maps [deg]", all.map_normals_deg.all);
}

void print_table(const evaluation::ViewSpectra& spectra, const std::string& unit) {
  if (spectra.depth.bands.empty()) return;
  fmt::print("{:<34} {:>10} {:>10} {:>10} {:>10}\n", "RMS by wavelength [samples]", "< 4", "4-16",
             "16-64", "> 64");
  print_spectrum("depth [" + unit + "]", spectra.depth, 1.0);
  print_spectrum("normals of the geometry [deg]", spectra.position_normals,
                 evaluation::degrees(1.0));
  print_spectrum("normal maps [deg]", spectra.map_normals, evaluation::degrees(1.0));
  if (spectra.crossing_wavelength)
    fmt::print(
        "normal maps are better than positions at wavelengths below {:.3g} samples = {:.4g} {}\n",
        *spectra.crossing_wavelength, *spectra.crossing_wavelength * spectra.spacing, unit);
}

void print_table(const evaluation::PoseErrorReport& report, const std::string& unit) {
  fmt::print(
      "poses: displacement of the samples mean {:.4g}, RMS {:.4g}, worst view {:.4g} {}; "
      "rotation mean {:.4g}, max {:.4g} deg; translation mean {:.4g}, max {:.4g} {}\n",
      report.mean_displacement, report.rms_displacement, report.max_displacement, unit,
      report.mean_rotation_deg, report.max_rotation_deg, report.mean_translation,
      report.max_translation, unit);
}

}  // namespace relief
