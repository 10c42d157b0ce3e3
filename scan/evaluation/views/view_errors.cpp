#include "relief/evaluation/view_errors.h"

#include <algorithm>
#include <utility>

#include "relief/scan/discontinuities.h"
#include "scan/base/parallel.h"
#include "scan/evaluation/base/angles.h"
#include "scan/evaluation/views/view_pairs.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/grid_normals.h"

namespace relief::evaluation {

namespace {

struct SplitErrors {
  std::vector<double> inner, edge;

  void add(double error, bool at_edge) { (at_edge ? edge : inner).push_back(error); }
  void append(const SplitErrors& other) {
    inner.insert(inner.end(), other.inner.begin(), other.inner.end());
    edge.insert(edge.end(), other.edge.begin(), other.edge.end());
  }
  SplitStatistics statistics() const {
    std::vector<double> all = inner;
    all.insert(all.end(), edge.begin(), edge.end());
    return {summarize(std::move(all)), summarize(inner), summarize(edge)};
  }
};

// The errors of all samples of one view or of several.
struct ErrorList {
  SplitErrors depth, position_normals, sampled_normals, map_normals;
  std::size_t missing = 0, extra = 0;

  void append(const ErrorList& other) {
    depth.append(other.depth);
    position_normals.append(other.position_normals);
    sampled_normals.append(other.sampled_normals);
    map_normals.append(other.map_normals);
    missing += other.missing;
    extra += other.extra;
  }

  ViewErrors summarized(const std::string& name) const {
    ViewErrors errors;
    errors.name = name;
    errors.depth = depth.statistics();
    double sum = 0.0;
    for (const double error : depth.inner) sum += error;
    for (const double error : depth.edge) sum += error;
    if (errors.depth.all.count > 0)
      errors.depth_bias = sum / static_cast<double>(errors.depth.all.count);
    errors.position_normals_deg = position_normals.statistics();
    errors.sampled_normals_deg = sampled_normals.statistics();
    errors.map_normals_deg = map_normals.statistics();
    errors.missing = missing;
    errors.extra = extra;
    return errors;
  }
};

// Edges and neighbours are those of the truth, so that every result is measured by the same yard.
ErrorList compare(const ViewAndTruth& pair, int edge_pixels) {
  const RangeView &view = *pair.view, &truth = *pair.truth;
  const GridEdges edges = connect_samples(truth);
  const Grid<std::uint8_t> to_boundary = boundary_distance(truth, edges);
  const Grid<Eigen::Vector3f> position_normals = finite_difference_normals(view, edges);
  const Grid<Eigen::Vector3f> sampled_normals = finite_difference_normals(truth, edges);
  const Grid<Eigen::Vector3f>& true_normals = truth.has_normals() ? truth.normals : sampled_normals;
  ErrorList list;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      list.missing += truth.has_sample(u, v) && !view.has_sample(u, v);
      list.extra += view.has_sample(u, v) && !truth.has_sample(u, v);
      if (!view.has_sample(u, v) || !truth.has_sample(u, v)) continue;
      const bool at_edge = to_boundary(u, v) <= edge_pixels;
      list.depth.add(depth_error(pair, u, v), at_edge);
      const auto compare_normals = [&](const Grid<Eigen::Vector3f>& normals,
                                       const Grid<Eigen::Vector3f>& exact, SplitErrors& errors) {
        if (normals(u, v).allFinite() && exact(u, v).allFinite())
          errors.add(angle_between_deg(normals(u, v), exact(u, v)), at_edge);
      };
      compare_normals(position_normals, true_normals, list.position_normals);
      compare_normals(position_normals, sampled_normals, list.sampled_normals);
      if (view.has_normal(u, v)) compare_normals(view.normals, true_normals, list.map_normals);
    }
  }
  return list;
}

}  // namespace

Result<ViewErrorReport> evaluate_views(const ScanProject& result, const ScanProject& truth,
                                       const ViewErrorOptions& options, const Context& context) {
  return run_in(context, [&]() -> Result<ViewErrorReport> {
    const auto pairs = pair_views(result, truth);
    if (!pairs) return pairs.error();
    if (!report_progress(context.progress, 0.0, "evaluate views"))
      return Error{ErrorKind::kInterrupted, "evaluation of views stopped"};

    std::vector<ErrorList> lists(pairs->size());
    parallel_for(lists.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        lists[i] = compare((*pairs)[i], options.edge_pixels);
    });

    ViewErrorReport report;
    ErrorList overall;
    for (std::size_t i = 0; i < lists.size(); ++i) {
      report.views.push_back(lists[i].summarized(result.views[i].name));
      overall.append(lists[i]);
    }
    report.overall = overall.summarized("overall");
    for (const RangeView& view : truth.views)
      if (!find_view(result, view.name)) report.unmatched.push_back(view.name);
    report_progress(context.progress, 1.0, "evaluate views");
    return report;
  });
}

}  // namespace relief::evaluation
