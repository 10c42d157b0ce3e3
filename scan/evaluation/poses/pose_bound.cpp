#include "scan/evaluation/poses/pose_bound.h"

#include <cassert>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

namespace relief::evaluation {

namespace {

// Views see one point when their ranges agree to this many sample spacings over the cosine. The
// nearest sample of a plane is up to sqrt(1/2) away; the rest is for curvature.
constexpr double kAgreement = 1.0;

struct Look {
  std::size_t view;
  double precision;  // Of the position along the normal, per area [1/unit^4].
};

// The area across its ray that a pixel covers at range `t` [unit^2].
double footprint_of(const Camera& camera, int u, int v, double t) {
  const int u1 = u + 1 < camera.width() ? u + 1 : u - 1;
  const int v1 = v + 1 < camera.height() ? v + 1 : v - 1;
  const Ray ray = camera.ray(u, v);
  const Eigen::Vector3d across = camera.ray(u1, v).at(t) - ray.at(t);
  const Eigen::Vector3d down = camera.ray(u, v1).at(t) - ray.at(t);
  return std::abs(across.cross(down).dot(ray.direction.normalized()));
}

// Whether `view` has a sample of the surface at the world point `p`, and how precise it is.
bool sees(const RangeView& view, const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
          double sigma, double& precision) {
  const Eigen::Vector3d local = view.world_from_view.inverse() * p;
  const auto pixel = view.camera.project(local);
  if (!pixel) return false;
  const int u = static_cast<int>(std::lround(pixel->x()));
  const int v = static_cast<int>(std::lround(pixel->y()));
  if (!view.has_sample(u, v)) return false;
  const Ray ray = view.camera.ray(u, v);
  const double cosine = -(view.world_from_view.linear() * ray.direction.normalized()).dot(normal);
  if (cosine < 0.05) return false;
  const double footprint = footprint_of(view.camera, u, v, view.range(u, v));
  if ((view.point(u, v) - local).norm() > kAgreement * std::sqrt(footprint) / cosine) return false;
  // Noise sigma cos(theta) along the normal, one sample per footprint / cos(theta).
  precision = 1.0 / (footprint * cosine * sigma * sigma);
  return true;
}

// All views that see the world point `p`.
std::vector<Look> looks_at(const std::vector<RangeView>& views, const Eigen::Vector3d& p,
                           const Eigen::Vector3d& normal, double sigma) {
  std::vector<Look> looks;
  for (std::size_t i = 0; i < views.size(); ++i) {
    double precision = 0.0;
    if (sees(views[i], p, normal, sigma, precision)) looks.push_back({i, precision});
  }
  return looks;
}

// Adds `area` (diag(w) - w w^T / sum(w)) (x) j j^T.
void add_patch(const std::vector<Look>& looks, double area, const Eigen::Matrix<double, 6, 1>& j,
               Eigen::MatrixXd& information) {
  double total = 0.0;
  for (const Look& look : looks) total += look.precision;
  const Eigen::Matrix<double, 6, 6> jj = area * j * j.transpose();
  for (const Look& a : looks)
    for (const Look& b : looks)
      information.block<6, 6>(static_cast<Eigen::Index>(6 * a.view),
                              static_cast<Eigen::Index>(6 * b.view)) +=
          ((a.view == b.view ? a.precision : 0.0) - a.precision * b.precision / total) * jj;
}

}  // namespace

Eigen::MatrixXd pose_information(const std::vector<RangeView>& truth, double sigma,
                                 const Eigen::Vector3d& centre) {
  const auto size = static_cast<Eigen::Index>(6 * truth.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (const RangeView& view : truth) {
    assert(view.camera.can_project());
    for (int v = 0; v < view.height(); ++v) {
      for (int u = 0; u < view.width(); ++u) {
        if (!view.has_sample(u, v) || !view.has_normal(u, v)) continue;
        const Eigen::Vector3d p = view.world_from_view * view.point(u, v);
        const Eigen::Vector3d n = view.world_from_view.linear() * view.normals(u, v).cast<double>();
        const auto looks = looks_at(truth, p, n, sigma);
        const Eigen::Vector3d d = view.world_from_view.linear() * view.camera.ray(u, v).direction;
        const double cosine = -d.normalized().dot(n);
        if (looks.size() < 2 || cosine <= 0.0) continue;
        // Every view that sees the patch counts it once.
        const double area = footprint_of(view.camera, u, v, view.range(u, v)) / cosine /
                            static_cast<double>(looks.size());
        Eigen::Matrix<double, 6, 1> j;
        j << (p - centre).cross(n), n;
        add_patch(looks, area, j, information);
      }
    }
  }
  return information;
}

}  // namespace relief::evaluation
