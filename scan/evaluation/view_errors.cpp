#include "scan/evaluation/view_errors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scan/discontinuities.h"
#include "scan/evaluation/angles.h"
#include "scan/grid_normals.h"
#include "scan/parallel.h"

namespace relief {

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
  SplitErrors depth, position_normals, map_normals;
  std::size_t missing = 0, extra = 0;

  void append(const ErrorList& other) {
    depth.append(other.depth);
    position_normals.append(other.position_normals);
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
    errors.map_normals_deg = map_normals.statistics();
    errors.missing = missing;
    errors.extra = extra;
    return errors;
  }
};

// How far apart the two rays of a pixel are: at most `kRayTolerance` of a pixel. Files keep
// intrinsics and ray tables to about seven digits.
constexpr double kRayTolerance = 1e-2;

bool same_rays(const RangeView& a, const RangeView& b) {
  const int right = a.width() - 1, bottom = a.height() - 1;
  for (const auto& [u, v] : {std::pair{0, 0}, {right, 0}, {0, bottom}, {right, bottom}}) {
    const Ray ra = a.camera.ray(u, v), rb = b.camera.ray(u, v);
    const Ray next = b.camera.ray(u + (u == 0 && right > 0 ? 1 : -(right > 0)), v);
    const double range = 1.0;  // rays are compared at this multiple of their directions
    const Eigen::Vector3d direction = rb.direction.normalized();
    const auto off_ray = [&](const Eigen::Vector3d& point) {
      const Eigen::Vector3d offset = point - rb.origin;
      return (offset - offset.dot(direction) * direction).norm();
    };
    const double pixel = off_ray(next.at(range)) + off_ray(next.origin);
    if (off_ray(ra.at(range)) + off_ray(ra.origin) > kRayTolerance * pixel ||
        ra.direction.dot(rb.direction) <= 0.0)
      return false;
  }
  return true;
}

Error mismatch(const RangeView& view, const std::string& what) {
  return {ErrorKind::kBadInput,
          "view " + view.name + " cannot be compared with its truth: " + what};
}

Result<void> check_comparable(const RangeView& view, const RangeView& truth) {
  if (view.width() != truth.width() || view.height() != truth.height())
    return mismatch(view, "it has " + std::to_string(view.width()) + "x" +
                              std::to_string(view.height()) + " pixels, the truth " +
                              std::to_string(truth.width()) + "x" + std::to_string(truth.height()));
  if (view.width() == 0 || view.height() == 0) return mismatch(view, "they have no pixels");
  if (!same_rays(view, truth)) return mismatch(view, "their cameras have different rays");
  return {};
}

// Equation (E3): the signed distance between two points of one ray, whose ranges may be in
// different scales.
double depth_error(const RangeView& view, const RangeView& truth, int u, int v) {
  const Eigen::Vector3d offset = view.point(u, v) - truth.point(u, v);
  return offset.dot(truth.camera.ray(u, v).direction.normalized());
}

// Edges and neighbours are those of the truth, so that every result is measured by the same yard.
ErrorList compare(const RangeView& view, const RangeView& truth, int edge_pixels) {
  const GridEdges edges = connect_samples(truth);
  const Grid<std::uint8_t> to_boundary = boundary_distance(truth, edges);
  const Grid<Eigen::Vector3f> position_normals = finite_difference_normals(view, edges);
  const Grid<Eigen::Vector3f> true_normals =
      truth.has_normals() ? truth.normals : finite_difference_normals(truth, edges);
  ErrorList list;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      list.missing += truth.has_sample(u, v) && !view.has_sample(u, v);
      list.extra += view.has_sample(u, v) && !truth.has_sample(u, v);
      if (!view.has_sample(u, v) || !truth.has_sample(u, v)) continue;
      const bool at_edge = to_boundary(u, v) <= edge_pixels;
      list.depth.add(depth_error(view, truth, u, v), at_edge);
      const Eigen::Vector3f& true_normal = true_normals(u, v);
      if (!true_normal.allFinite()) continue;
      if (position_normals(u, v).allFinite())
        list.position_normals.add(angle_between_deg(position_normals(u, v), true_normal), at_edge);
      if (view.has_normal(u, v))
        list.map_normals.add(angle_between_deg(view.normals(u, v), true_normal), at_edge);
    }
  }
  return list;
}

}  // namespace

Result<ViewErrorReport> evaluate_views(const ScanProject& result, const ScanProject& truth,
                                       const ViewErrorOptions& options, const Progress& progress) {
  std::vector<const RangeView*> true_views;
  for (const RangeView& view : result.views) {
    true_views.push_back(find_view(truth, view.name));
    if (!true_views.back()) return mismatch(view, "the truth has no view of this name");
    if (const auto valid = check_comparable(view, *true_views.back()); !valid) return valid.error();
  }
  if (!report_progress(progress, 0.0, "evaluate views"))
    return Error{ErrorKind::kInterrupted, "evaluation of views stopped"};

  std::vector<ErrorList> lists(result.views.size());
  parallel_for(lists.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      lists[i] = compare(result.views[i], *true_views[i], options.edge_pixels);
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
  report_progress(progress, 1.0, "evaluate views");
  return report;
}

}  // namespace relief
