#include <cmath>

#include <Eigen/Dense>

#include "relief/scan/projections.h"
#include "scan/views/projection_fits.h"

namespace relief {

namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

struct Ratio {
  Eigen::Vector4d numerator, denominator;
};

// min |num . P - pixel den . P|^2 over |(num, den)| = 1, as in the direct linear transform, on
// coordinates normalised to unit spread; a second smallest eigenvalue near zero means that the
// points determine no unique ratio.
std::optional<Ratio> fit_ratio(const std::vector<Eigen::Vector3d>& points,
                               const Eigen::VectorXd& pixels, const Eigen::Vector3d& centre,
                               double scale) {
  const double pixel_mean = pixels.mean();
  const double pixel_scale =
      std::max(1e-12, std::sqrt((pixels.array() - pixel_mean).square().mean()));
  Matrix8d normal_matrix = Matrix8d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector4d p = ((points[i] - centre) / scale).homogeneous();
    const double s = (pixels[static_cast<Eigen::Index>(i)] - pixel_mean) / pixel_scale;
    Vector8d row;
    row << p, -s * p;
    normal_matrix.selfadjointView<Eigen::Lower>().rankUpdate(row);
  }
  normal_matrix /= static_cast<double>(points.size());
  const Eigen::SelfAdjointEigenSolver<Matrix8d> eigen(normal_matrix);
  if (eigen.eigenvalues()[1] < 1e-12) return std::nullopt;

  // Undo the normalisation: pixel = pixel_mean + pixel_scale num / den, P -> (P - centre) / scale.
  Eigen::Matrix4d normalise = Eigen::Matrix4d::Identity();
  normalise.topLeftCorner<3, 3>() /= scale;
  normalise.topRightCorner<3, 1>() = -centre / scale;
  const Vector8d solution = eigen.eigenvectors().col(0);
  Ratio ratio;
  ratio.denominator = normalise.transpose() * solution.tail<4>();
  ratio.numerator =
      pixel_scale * (normalise.transpose() * solution.head<4>()) + pixel_mean * ratio.denominator;
  // Positive denominators on the samples' side of the sensor.
  if (ratio.denominator.dot(centre.homogeneous()) < 0.0) {
    ratio.denominator = -ratio.denominator;
    ratio.numerator = -ratio.numerator;
  }
  return ratio;
}

}  // namespace

std::optional<Eigen::Vector2d> RationalProjection::project(const Eigen::Vector3d& point) const {
  const Eigen::Vector4d p = point.homogeneous();
  const double u_scale = u_denominator.dot(p), v_scale = v_denominator.dot(p);
  if (!(u_scale > 0.0) || !(v_scale > 0.0)) return std::nullopt;
  return Eigen::Vector2d(u_numerator.dot(p) / u_scale, v_numerator.dot(p) / v_scale);
}

Ray RationalProjection::ray(double u, double v, const Eigen::Vector3d& towards) const {
  const Eigen::Vector4d u_plane = u_numerator - u * u_denominator;
  const Eigen::Vector4d v_plane = v_numerator - v * v_denominator;
  Ray ray;
  ray.direction = u_plane.head<3>().cross(v_plane.head<3>()).normalized();
  if (ray.direction.dot(towards) < 0.0) ray.direction = -ray.direction;
  Eigen::Matrix3d system;
  system << u_plane.head<3>().transpose(), v_plane.head<3>().transpose(), ray.direction.transpose();
  ray.origin = system.partialPivLu().solve(Eigen::Vector3d(-u_plane[3], -v_plane[3], 0.0));
  return ray;
}

std::optional<RationalProjectionFit> fit_rational_projection(
    const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector2d>& pixels) {
  if (points.size() < 12 || points.size() != pixels.size()) return std::nullopt;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& p : points) centre += p;
  centre /= static_cast<double>(points.size());
  double spread = 0.0;
  for (const auto& p : points) spread += (p - centre).squaredNorm();
  const double scale = std::sqrt(spread / static_cast<double>(points.size()));
  if (!(scale > 0.0)) return std::nullopt;

  Eigen::VectorXd us(points.size()), vs(points.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    us[static_cast<Eigen::Index>(i)] = pixels[i].x();
    vs[static_cast<Eigen::Index>(i)] = pixels[i].y();
  }
  const auto u_ratio = fit_ratio(points, us, centre, scale);
  const auto v_ratio = fit_ratio(points, vs, centre, scale);
  if (!u_ratio || !v_ratio) return std::nullopt;

  RationalProjectionFit fit;
  fit.projection = {u_ratio->numerator, u_ratio->denominator, v_ratio->numerator,
                    v_ratio->denominator};
  double squares = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = fit.projection.project(points[i]);
    if (!pixel) return std::nullopt;
    squares += (*pixel - pixels[i]).squaredNorm();
  }
  fit.rms_pixels = std::sqrt(squares / static_cast<double>(points.size()));
  return fit;
}

}  // namespace relief
