#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "relief/evaluation/view_errors.h"
#include "relief/scan/discontinuities.h"
#include "scan/base/median.h"
#include "scan/base/parallel.h"
#include "scan/evaluation/views/error_spectrum.h"
#include "scan/evaluation/views/view_pairs.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/grid_normals.h"

namespace relief::evaluation {

namespace {

using Normals = Grid<Eigen::Vector3f>;

// The errors of some views, by what is wrong.
struct Spectra {
  TileSpectra depth, map_normals, position_normals;

  void add(const Spectra& other) {
    depth.add(other.depth);
    map_normals.add(other.map_normals);
    position_normals.add(other.position_normals);
  }
};

ErrorGrid no_errors(const RangeView& view) {
  return {view.width(), view.height(), std::numeric_limits<double>::quiet_NaN()};
}

// The rotation from the true normal to the other as a tangent vector of its angle's length. The
// tangent frame follows the grid's x axis, so that neighbours have nearly the same.
std::complex<double> tangent_error(const Eigen::Vector3f& normal,
                                   const Eigen::Vector3f& true_normal) {
  const Eigen::Vector3d n = normal.cast<double>(), t = true_normal.cast<double>();
  const Eigen::Vector3d first = (Eigen::Vector3d::UnitX() - t.x() * t).stableNormalized();
  const Eigen::Vector3d off = n - n.dot(t) * t;
  const double sine = off.norm();
  const double factor = sine > 0.0 ? std::atan2(sine, n.dot(t)) / sine : 1.0;
  return factor * std::complex(off.dot(first), off.dot(t.cross(first)));
}

ErrorGrid normal_errors(const Normals& normals, const Normals& true_normals,
                        const ErrorGrid& where) {
  ErrorGrid errors = where;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (std::isnan(errors[i].real())) continue;
    errors[i] = normals[i].allFinite() && true_normals[i].allFinite()
                    ? tangent_error(normals[i], true_normals[i])
                    : std::numeric_limits<double>::quiet_NaN();
  }
  return errors;
}

Spectra spectra_of(const ViewAndTruth& pair, int edge_pixels) {
  const RangeView &view = *pair.view, &truth = *pair.truth;
  const GridEdges edges = connect_samples(truth);
  const Grid<std::uint8_t> to_boundary = boundary_distance(truth, edges);
  ErrorGrid depth = no_errors(view);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v) && truth.has_sample(u, v) && to_boundary(u, v) > edge_pixels)
        depth(u, v) = depth_error(pair, u, v);
  const Normals from_true_positions = finite_difference_normals(truth, edges);
  Spectra spectra;
  spectra.depth.add(depth);
  spectra.position_normals.add(
      normal_errors(finite_difference_normals(view, edges), from_true_positions, depth));
  if (view.has_normals())
    spectra.map_normals.add(normal_errors(
        view.normals, truth.has_normals() ? truth.normals : from_true_positions, depth));
  return spectra;
}

double median_spacing(const std::vector<ViewAndTruth>& pairs) {
  std::vector<double> spacings;
  for (const ViewAndTruth& pair : pairs) spacings.push_back(sample_spacing(*pair.truth));
  return median(spacings);
}

}  // namespace

Result<ViewSpectra> evaluate_spectra(const ScanProject& result, const ScanProject& truth,
                                     const ViewErrorOptions& options, const Context& context) {
  return run_in(context, [&]() -> Result<ViewSpectra> {
    const auto pairs = pair_views(result, truth);
    if (!pairs) return pairs.error();
    Spectra all;
    // A few views at a time bound the memory; the order of the sums is fixed.
    const std::size_t at_once = static_cast<std::size_t>(thread_count());
    for (std::size_t first = 0; first < pairs->size(); first += at_once) {
      if (!report_progress(context.progress,
                           static_cast<double>(first) / static_cast<double>(pairs->size()),
                           "spectra of errors"))
        return Error{ErrorKind::kInterrupted, "spectra of errors stopped"};
      std::vector<Spectra> some(std::min(at_once, pairs->size() - first));
      parallel_for(some.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          some[i] = spectra_of((*pairs)[first + i], options.edge_pixels);
      });
      for (const Spectra& spectra : some) all.add(spectra);
    }
    ViewSpectra spectra;
    spectra.depth = all.depth.spectrum();
    spectra.map_normals = all.map_normals.spectrum();
    spectra.position_normals = all.position_normals.spectrum();
    spectra.spacing = median_spacing(*pairs);
    if (const auto crossing = crossing_frequency(spectra.position_normals, spectra.map_normals))
      spectra.crossing_wavelength = 1.0 / *crossing;
    report_progress(context.progress, 1.0, "spectra of errors");
    return spectra;
  });
}

}  // namespace relief::evaluation
