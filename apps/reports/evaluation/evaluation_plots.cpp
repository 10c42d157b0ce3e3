#include "apps/reports/evaluation/evaluation_plots.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "apps/reports/evaluation/gnuplot.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

namespace {

constexpr const char* kSvg =
    "set terminal svg size 800,560 dynamic background 'white' font 'sans,14'\n"
    "set encoding utf8\nset grid\nset key above\nset style data lines\n";

std::string in_unit(const std::string& what, const std::string& unit) {
  return gnuplot_text(unit.empty() ? what : what + " [" + unit + "]");
}

Result<void> write_spectrum(const evaluation::ErrorSpectrum& spectrum,
                            const std::filesystem::path& file) {
  std::string text = "frequency\tdensity\tarea\ttile\ttiles\n";
  for (const evaluation::SpectrumBand& band : spectrum.bands)
    text += fmt::format("{}\t{}\t{}\t{}\t{}\n", band.frequency, band.density, band.area, band.tile,
                        band.tiles);
  return write_file(file, text);
}

// Rows of two columns for a growing fraction of the values: as many as a curve needs.
std::string cumulative_rows(std::vector<double> values) {
  constexpr std::size_t kRows = 1000;
  std::sort(values.begin(), values.end());
  std::string text = "distance\tfraction\n";
  for (std::size_t i = 1; i <= kRows && !values.empty(); ++i) {
    const std::size_t rank = (i * values.size() - 1) / kRows;
    text += fmt::format("{}\t{}\n", values[rank], static_cast<double>(i) / kRows);
  }
  return text;
}

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  const auto place = values.begin() +
                     static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

std::vector<double> magnitudes(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return values;
}

// Equal bins over +-`range`, as densities whose integral over all errors is 1.
std::string histogram_rows(const std::vector<double>& errors, double range) {
  constexpr int kBins = 121;
  std::vector<double> counts(kBins, 0.0);
  const double width = 2.0 * range / kBins;
  for (const double error : errors) {
    const double bin = std::floor((error + range) / width);
    if (bin >= 0.0 && bin < kBins) ++counts[static_cast<std::size_t>(bin)];
  }
  std::string text = "error\tdensity\n";
  for (int i = 0; i < kBins; ++i)
    text += fmt::format("{}\t{}\n", (i + 0.5) * width - range,
                        counts[i] / (width * static_cast<double>(errors.size())));
  return text;
}

Result<void> plot_cumulative(const evaluation::MeshComparison& comparison, const std::string& unit,
                             const std::filesystem::path& folder) {
  const auto accuracy = magnitudes(comparison.signed_accuracy);
  const double range =
      std::max(quantile(accuracy, 0.995), quantile(comparison.completeness_distances, 0.995));
  if (auto done = write_file(folder / "accuracy.tsv", cumulative_rows(accuracy)); !done)
    return done;
  if (auto done = write_file(folder / "completeness.tsv",
                             cumulative_rows(comparison.completeness_distances));
      !done)
    return done;
  std::string script = std::string(kSvg) + "set output 'distances.svg'\n";
  script += "set xlabel " + in_unit("distance", unit) + "\n";
  script += "set ylabel 'fraction of the surface at most so far'\nset yrange [0:1]\n";
  if (range > 0.0) script += fmt::format("set xrange [0:{}]\n", range);
  script +=
      "plot 'accuracy.tsv' skip 1 lw 2 title 'accuracy: result to truth', \\\n"
      "     'completeness.tsv' skip 1 lw 2 title 'completeness: truth to result'\n";
  return run_gnuplot(folder, "distances", script);
}

Result<void> plot_histogram(const evaluation::MeshComparison& comparison, const std::string& unit,
                            const std::filesystem::path& folder) {
  const double range = quantile(magnitudes(comparison.signed_accuracy), 0.995);
  if (!(range > 0.0)) return {};
  if (auto done =
          write_file(folder / "histogram.tsv", histogram_rows(comparison.signed_accuracy, range));
      !done)
    return done;
  std::string script = std::string(kSvg) + "set output 'histogram.svg'\nunset key\n";
  script += "set xlabel " + in_unit("error of the result, negative inside", unit) + "\n";
  script +=
      "set ylabel " + in_unit("density of the surface", unit.empty() ? "" : "1/" + unit) + "\n";
  script += fmt::format("set xrange [{}:{}]\nset yrange [0:*]\n", -range, range);
  script += "plot 'histogram.tsv' skip 1 with fillsteps fs solid 0.6\n";
  return run_gnuplot(folder, "histogram", script);
}

// One picture with a colour bar over [low, high].
Result<void> plot_image(const Grid<float>& image, const std::string& name, const std::string& label,
                        double low, double high, const std::filesystem::path& folder) {
  const std::string data = name + ".f32";
  const std::string_view bytes(reinterpret_cast<const char*>(image.data()),
                               image.size() * sizeof(float));
  if (auto done = write_file(folder / data, bytes); !done) return done;
  const double scale = std::clamp(900.0 / image.width(), 1.0, 8.0);
  std::string script = fmt::format(
      "set terminal pngcairo size {},{} background 'white' font 'sans,12'\n",
      static_cast<int>(scale * image.width()) + 160, static_cast<int>(scale * image.height()) + 60);
  script += "set output " + gnuplot_text(name + ".png") + "\n";
  script += "set size ratio -1\nunset tics\nset cbtics\nunset key\nset autoscale fix\n";
  script += "set yrange [] reverse\nset cblabel " + label + "\n";
  script += fmt::format("set cbrange [{}:{}]\n", low, high);
  script += low < 0.0 ? "set palette defined (-1 '#3b4cc0', 0 '#dddddd', 1 '#b40426')\n"
                      : "set palette defined (0 '#440154', 1 '#3b528b', 2 '#21918c', "
                        "3 '#5ec962', 4 '#fde725')\n";
  script += "plot " + gnuplot_text(data) +
            fmt::format(" binary array=({},{}) format='%float32' with image\n", image.width(),
                        image.height());
  return run_gnuplot(folder, name, script);
}

double largest_shown(const Grid<float>& image) {
  std::vector<double> values;
  for (const float value : image)
    if (std::isfinite(value)) values.push_back(std::abs(value));
  const double shown = quantile(std::move(values), 0.98);
  return shown > 0.0 ? shown : 1.0;
}

// A view's name as part of a file's.
std::string file_stem(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

}  // namespace

Result<void> plot_spectra(const evaluation::ViewSpectra& spectra, const std::string& unit,
                          const std::filesystem::path& folder) {
  struct Curve {
    const evaluation::ErrorSpectrum* spectrum;
    std::string file, title, axes;
  };
  const std::vector<Curve> curves = {
      {&spectra.position_normals, "spectrum-geometry-normals.tsv", "normals of the positions",
       "x1y1"},
      {&spectra.map_normals, "spectrum-map-normals.tsv", "normal maps", "x1y1"},
      {&spectra.depth, "spectrum-depth.tsv", "depth (right axis)", "x1y2"}};
  std::string plot;
  for (const Curve& curve : curves) {
    if (!(curve.spectrum->variance() > 0.0)) continue;
    if (auto done = write_spectrum(*curve.spectrum, folder / curve.file); !done) return done;
    plot += (plot.empty() ? "plot " : ", \\\n     ") + gnuplot_text(curve.file) +
            " skip 1 using 1:2 axes " + curve.axes + " with linespoints lw 2 pt 7 ps 0.4 title " +
            gnuplot_text(curve.title);
  }
  if (plot.empty()) return {};
  std::string script = std::string(kSvg) + "set output 'spectra.svg'\nset logscale xyy2\n";
  script += "set format y '10^{%L}'\nset format y2 '10^{%L}'\nset y2tics\nset ytics nomirror\n";
  script += "set xrange [*:0.72]\nset xlabel 'spatial frequency [cycles per sample]'\n";
  script += "set ylabel 'normal error density [rad^2 / (cycle/sample)^2]'\n";
  script += "set y2label " +
            gnuplot_text("depth error density [" + unit + "^2 / (cycle/sample)^2]") + "\n";
  if (spectra.crossing_wavelength) {
    const double frequency = 1.0 / *spectra.crossing_wavelength;
    script +=
        fmt::format("set arrow from {},graph 0 to {},graph 1 nohead dt 2\n", frequency, frequency);
    script += fmt::format("set label 'crossing: {:.3g} samples' at {},graph 0.05 offset 0.5,0\n",
                          *spectra.crossing_wavelength, frequency);
  }
  return run_gnuplot(folder, "spectra", script + plot + "\n");
}

Result<void> plot_distances(const evaluation::MeshComparison& comparison, const std::string& unit,
                            const std::filesystem::path& folder) {
  if (auto done = plot_cumulative(comparison, unit, folder); !done) return done;
  return plot_histogram(comparison, unit, folder);
}

Result<void> plot_error_maps(const evaluation::ViewErrorMaps& maps, const std::string& unit,
                             const std::filesystem::path& folder) {
  const std::string stem = file_stem(maps.name);
  const double depth = largest_shown(maps.depth);
  if (auto done = plot_image(maps.depth, stem + "-depth", in_unit("depth error", unit), -depth,
                             depth, folder);
      !done)
    return done;
  // Both kinds of normals on one scale, so that the eye can compare them.
  const double angle =
      std::max(largest_shown(maps.position_normals_deg),
               maps.map_normals_deg.empty() ? 0.0 : largest_shown(maps.map_normals_deg));
  if (auto done = plot_image(maps.position_normals_deg, stem + "-geometry-normals",
                             "'normal error of the positions [deg]'", 0.0, angle, folder);
      !done || maps.map_normals_deg.empty())
    return done;
  return plot_image(maps.map_normals_deg, stem + "-map-normals",
                    "'normal error of the normal map [deg]'", 0.0, angle, folder);
}

}  // namespace relief
