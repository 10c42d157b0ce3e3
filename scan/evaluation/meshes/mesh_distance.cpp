#include <algorithm>
#include <string>
#include <utility>

#include "relief/evaluation/mesh_errors.h"
#include "scan/base/parallel.h"
#include "scan/evaluation/base/angles.h"
#include "scan/evaluation/meshes/pseudo_normals.h"
#include "scan/evaluation/meshes/surface_samples.h"
#include "scan/mesh/triangle_tree.h"

namespace relief::evaluation {

namespace {

constexpr std::size_t kGrain = 1024;  // Points of one piece of work; changes no result.

Result<void> check(const TriangleMesh& mesh, const std::string& which) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite())
      return Error{ErrorKind::kBadInput,
                   "vertex " + std::to_string(i) + " of the " + which + " is not finite"};
  if (!(surface_area(mesh) > 0.0))
    return Error{ErrorKind::kBadInput,
                 "the " + which + " has no faces with area: give a surface, not points"};
  return {};
}

double median_edge_length(const TriangleMesh& mesh) {
  std::vector<double> lengths;
  lengths.reserve(mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    lengths.push_back((mesh.corner(f, 1) - mesh.corner(f, 0)).norm());
  return summarize(std::move(lengths)).median;
}

// A mesh with what the comparison needs of it.
struct Surface {
  const TriangleMesh& mesh;
  PagedVector<Eigen::Vector3f> normals;
  TriangleTree tree;

  Surface(const TriangleMesh& m, bool use_own_normals)
      : mesh(m),
        normals(use_own_normals && !m.normals.empty() ? m.normals : vertex_normals(m)),
        tree(m) {}

  Eigen::Vector3d normal(std::uint32_t face, const Eigen::Vector3d& weights) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) sum += weights[k] * normals[mesh.faces[face][k]].cast<double>();
    return sum;
  }

  bool filled(std::uint32_t face, const Eigen::Vector3d& weights) const {
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) sum += weights[k] * mesh.filled[mesh.faces[face][k]];
    return sum >= 0.5;
  }
};

struct PointError {
  double distance = 0.0, angle_deg = 0.0;
  bool filled = false;  // the result, here
  bool inside = false;  // of the other surface
};

bool is_inside(const Eigen::Vector3d& point, const TriangleTree::Closest& closest,
               const PseudoNormals& outward) {
  const Eigen::Vector3d offset = point - closest.on_face.point;
  return offset.dot(outward.at(closest.face, closest.on_face.weights)) < 0.0;
}

// `result` is the one of the two surfaces that knows what was filled.
std::vector<PointError> measure(const Surface& from, const Surface& to, const Surface& result,
                                const MeshDistanceOptions& options, std::uint64_t seed) {
  const auto samples = sample_surface(from.mesh, options.samples, seed);
  const PseudoNormals outward(to.mesh);
  std::vector<PointError> errors(samples.size());
  parallel_for(samples.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& [face, weights] = samples[i];
      const Eigen::Vector3d point = point_at(from.mesh, samples[i]);
      const auto closest = *to.tree.closest(point);
      errors[i].distance = closest.distance;
      errors[i].inside = is_inside(point, closest, outward);
      errors[i].angle_deg = angle_between_deg(from.normal(face, weights),
                                              to.normal(closest.face, closest.on_face.weights));
      if (!result.mesh.filled.empty())
        errors[i].filled = &result == &from ? from.filled(face, weights)
                                            : to.filled(closest.face, closest.on_face.weights);
    }
  });
  return errors;
}

template <typename Select>
DirectedDistance summarize_where(const std::vector<PointError>& errors,
                                 const std::vector<double>& thresholds, const Select& select) {
  std::vector<double> distances, angles;
  for (const PointError& error : errors) {
    if (!select(error)) continue;
    distances.push_back(error.distance);
    angles.push_back(error.angle_deg);
  }
  DirectedDistance summary;
  for (const double threshold : thresholds) {
    const auto near = std::count_if(distances.begin(), distances.end(),
                                    [&](double distance) { return distance <= threshold; });
    summary.within.push_back(distances.empty() ? 0.0
                                               : static_cast<double>(near) /
                                                     static_cast<double>(distances.size()));
  }
  summary.distance = summarize(std::move(distances));
  summary.normals_deg = summarize(std::move(angles));
  return summary;
}

DistanceReport report(const std::vector<PointError>& errors, const std::vector<double>& thresholds,
                      bool split) {
  DistanceReport report;
  report.all = summarize_where(errors, thresholds, [](const PointError&) { return true; });
  if (!split) return report;
  report.measured =
      summarize_where(errors, thresholds, [](const PointError& error) { return !error.filled; });
  report.filled =
      summarize_where(errors, thresholds, [](const PointError& error) { return error.filled; });
  return report;
}

// `edge_length` is the spacing where none is given.
std::vector<double> chosen_thresholds(double edge_length, const MeshDistanceOptions& options) {
  if (!options.thresholds.empty()) return options.thresholds;
  const double spacing = options.spacing > 0.0 ? options.spacing : edge_length;
  return {0.25 * spacing, 0.5 * spacing, spacing, 2.0 * spacing};
}

// Equation (E2).
double harmonic_mean(double a, double b) { return a + b > 0.0 ? 2.0 * a * b / (a + b) : 0.0; }

Result<MeshComparison> compare(const TriangleMesh& result_mesh, const TriangleMesh& truth_mesh,
                               const MeshDistanceOptions& options, const Context& context) {
  if (const auto valid = check(result_mesh, "result mesh"); !valid) return valid.error();
  if (const auto valid = check(truth_mesh, "true mesh"); !valid) return valid.error();
  const Error stopped{ErrorKind::kInterrupted, "comparison of meshes stopped"};
  if (!report_progress(context.progress, 0.0, "compare meshes")) return stopped;
  const Surface result(result_mesh, false), truth(truth_mesh, true);
  if (!report_progress(context.progress, 0.4, "compare meshes")) return stopped;
  const auto to_truth = measure(result, truth, result, options, context.seed);
  if (!report_progress(context.progress, 0.7, "compare meshes")) return stopped;
  const auto to_result = measure(truth, result, result, options, context.seed);

  MeshComparison comparison;
  comparison.thresholds = chosen_thresholds(median_edge_length(truth_mesh), options);
  const bool split = !result_mesh.filled.empty();
  comparison.accuracy = report(to_truth, comparison.thresholds, split);
  comparison.completeness = report(to_result, comparison.thresholds, split);
  for (std::size_t i = 0; i < comparison.thresholds.size(); ++i)
    comparison.f_score.push_back(
        harmonic_mean(comparison.accuracy.all.within[i], comparison.completeness.all.within[i]));
  if (split)
    comparison.filled_fraction = static_cast<double>(comparison.accuracy.filled->distance.count) /
                                 static_cast<double>(to_truth.size());
  for (const PointError& error : to_truth)
    comparison.signed_accuracy.push_back(error.inside ? -error.distance : error.distance);
  for (const PointError& error : to_result)
    comparison.completeness_distances.push_back(error.distance);
  report_progress(context.progress, 1.0, "compare meshes");
  return comparison;
}

Result<MutualDistances> compare_both(const TriangleMesh& a_mesh, const TriangleMesh& b_mesh,
                                     const MeshDistanceOptions& options, const Context& context) {
  if (const auto valid = check(a_mesh, "first mesh"); !valid) return valid.error();
  if (const auto valid = check(b_mesh, "second mesh"); !valid) return valid.error();
  const Error stopped{ErrorKind::kInterrupted, "comparison of meshes stopped"};
  if (!report_progress(context.progress, 0.0, "compare meshes")) return stopped;
  const Surface a(a_mesh, false), b(b_mesh, false);
  if (!report_progress(context.progress, 0.4, "compare meshes")) return stopped;
  const auto a_to_b = measure(a, b, a, options, context.seed);
  if (!report_progress(context.progress, 0.7, "compare meshes")) return stopped;
  const auto b_to_a = measure(b, a, b, options, context.seed);

  MutualDistances distances;
  distances.thresholds =
      chosen_thresholds(std::max(median_edge_length(a_mesh), median_edge_length(b_mesh)), options);
  distances.a_to_b = report(a_to_b, distances.thresholds, !a_mesh.filled.empty());
  distances.b_to_a = report(b_to_a, distances.thresholds, !b_mesh.filled.empty());
  report_progress(context.progress, 1.0, "compare meshes");
  return distances;
}

}  // namespace

Result<MeshComparison> compare_meshes(const TriangleMesh& result_mesh,
                                      const TriangleMesh& truth_mesh,
                                      const MeshDistanceOptions& options, const Context& context) {
  return run_in(context, [&] { return compare(result_mesh, truth_mesh, options, context); });
}

Result<MutualDistances> mutual_distances(const TriangleMesh& a, const TriangleMesh& b,
                                         const MeshDistanceOptions& options,
                                         const Context& context) {
  return run_in(context, [&] { return compare_both(a, b, options, context); });
}

std::vector<double> signed_distances(const TriangleMesh& mesh, const TriangleMesh& truth) {
  const TriangleTree tree(truth);
  const PseudoNormals normals(truth);
  std::vector<double> distances(mesh.vertices.size());
  parallel_for(distances.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto closest = *tree.closest(mesh.vertices[i]);
      const bool inside = is_inside(mesh.vertices[i], closest, normals);
      distances[i] = inside ? -closest.distance : closest.distance;
    }
  });
  return distances;
}

}  // namespace relief::evaluation
