#include "hybrid/normals/normal_correction.h"

#include <array>

#include <Eigen/Geometry>
#include <Eigen/SparseCore>

#include "hybrid/solver/spd_solver.h"
#include "scan/grid/grid_normals.h"

namespace relief::hybrid {

namespace {

using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

struct Pixel {
  int u, v;
};

// Of a movable sample.
Pixel pixel_of(const ViewProblem& problem, Eigen::Index k) {
  const std::uint32_t i = problem.pixels[static_cast<std::size_t>(k)];
  return {problem.grid.u(i), problem.grid.v(i)};
}

// The step from one ray to the next along an axis at one range: central, or one-sided at a border.
Eigen::Vector3d step_across(const RangeView& view, Pixel p, int du, int dv) {
  const double t = view.range(p.u, p.v);
  const bool before = view.range.contains(p.u - du, p.v - dv);
  const bool after = view.range.contains(p.u + du, p.v + dv);
  const Eigen::Vector3d tail = view.camera.ray(p.u - before * du, p.v - before * dv).at(t);
  const Eigen::Vector3d head = view.camera.ray(p.u + after * du, p.v + after * dv).at(t);
  return before && after ? (0.5 * (head - tail)).eval() : (head - tail).eval();
}

// The tangent along `across` whose slope against `normal` is `bias`.
Eigen::Vector3d biased_tangent(const Eigen::Vector3d& across, const Eigen::Vector3d& viewing,
                               const Eigen::Vector3d& normal, double bias) {
  const Eigen::Vector3d unbiased = across - viewing * (normal.dot(across) / normal.dot(viewing));
  return unbiased + viewing * (bias * unbiased.norm() / normal.dot(viewing));
}

Eigen::Vector3d facing(const Eigen::Vector3d& normal, const Eigen::Vector3d& viewing) {
  return normal.dot(viewing) > 0.0 ? (-normal).eval() : normal;
}

// A normal scaled so that its component along the ray is one. In this form it is linear in the
// slopes, and averaging noisy normals does not bend them towards the sensor.
Eigen::Vector3d slope_form(const Eigen::Vector3d& normal, const Eigen::Vector3d& viewing) {
  return normal / -normal.dot(viewing);
}

struct SlopeFields {
  Columns measured, surface;  // slope form; zero where `mass` is
  Eigen::VectorXd mass;
};

SlopeFields slope_fields(const RangeView& view, const GridEdges& edges,
                         const ViewProblem& problem) {
  const auto count = static_cast<Eigen::Index>(problem.size());
  SlopeFields fields{Columns::Zero(count, 3), Columns::Zero(count, 3),
                     Eigen::VectorXd::Zero(count)};
  const Grid<Eigen::Vector3f> surface = finite_difference_normals(view, edges);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Pixel p = pixel_of(problem, k);
    const Eigen::Vector3d viewing = view.camera.ray(p.u, p.v).direction.normalized();
    const Eigen::Vector3d from_range = surface(p.u, p.v).cast<double>();
    if (!view.has_normal(p.u, p.v) || !from_range.allFinite()) continue;
    const Eigen::Vector3d measured = view.normals(p.u, p.v).cast<double>();
    const double cosine = -measured.dot(viewing);
    if (cosine < 0.05 || from_range.dot(viewing) > -0.05) continue;
    fields.measured.row(k) = slope_form(measured, viewing);
    fields.surface.row(k) = slope_form(from_range, viewing);
    fields.mass[k] = double{problem.confidence[k]} * cosine * cosine;
  }
  return fields;
}

// mass + scale^2 L, with a trace of mass everywhere so that it is never singular.
Eigen::SparseMatrix<double> smoothing_matrix(const ViewProblem& problem,
                                             const Eigen::VectorXd& mass, double scale) {
  const auto count = static_cast<Eigen::Index>(problem.size());
  const double stiffness = scale * scale;
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < count; ++i) entries.emplace_back(i, i, mass[i] + 1e-9);
  for (const auto& [a, b] : bias_neighbours(problem)) {
    entries.emplace_back(a, a, stiffness);
    entries.emplace_back(b, b, stiffness);
    entries.emplace_back(std::max(a, b), std::min(a, b), -stiffness);
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

Grid<Eigen::Vector3f> subtract_bias(const RangeView& view, const ViewProblem& problem,
                                    const Eigen::VectorXd& bias) {
  Grid<Eigen::Vector3f> normals = view.normals;
  const auto count = static_cast<Eigen::Index>(problem.size());
  for_each_sample(problem, [&](Eigen::Index k, std::uint32_t) {
    const Pixel p = pixel_of(problem, k);
    if (!view.has_normal(p.u, p.v)) return;
    const Eigen::Vector3d viewing = view.camera.ray(p.u, p.v).direction.normalized();
    const Eigen::Vector3d normal = view.normals(p.u, p.v).cast<double>();
    const Eigen::Vector3d along_u =
        biased_tangent(step_across(view, p, 1, 0), viewing, normal, bias[k]);
    const Eigen::Vector3d along_v =
        biased_tangent(step_across(view, p, 0, 1), viewing, normal, bias[count + k]);
    const Eigen::Vector3d corrected = along_u.cross(along_v).normalized();
    if (corrected.allFinite()) normals(p.u, p.v) = facing(corrected, viewing).cast<float>();
  });
  return normals;
}

TwoStepResult two_step_correction(const RangeView& view, const GridEdges& edges,
                                  const ViewProblem& problem, double scale) {
  TwoStepResult result{view.normals, false};
  const SlopeFields fields = slope_fields(view, edges, problem);
  const Eigen::SparseMatrix<double> matrix = smoothing_matrix(problem, fields.mass, scale);
  SpdSolver solver;
  if (!solver.factorise(matrix)) return result;
  Columns measured = fields.measured, surface = fields.surface;
  for (Columns* field : {&measured, &surface}) {
    for (int axis = 0; axis < 3; ++axis) {
      field->col(axis) = solver.solve(fields.mass.cwiseProduct(field->col(axis)));
    }
  }
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
    const Pixel p = pixel_of(problem, k);
    const Eigen::Vector3d from = measured.row(k), to = surface.row(k);
    if (!view.has_normal(p.u, p.v) || !(from.norm() > 0.0) || !(to.norm() > 0.0)) continue;
    // R takes S(N) to N; the corrected normal is R S(Npos), equation (H1).
    const auto rotation =
        Eigen::Quaterniond::FromTwoVectors(from, view.normals(p.u, p.v).cast<double>());
    result.normals(p.u, p.v) = (rotation * to.normalized()).cast<float>();
  }
  result.solved = true;
  return result;
}

}  // namespace relief::hybrid
