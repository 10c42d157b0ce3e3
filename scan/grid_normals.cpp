#include "scan/grid_normals.h"

#include <array>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>

#include "scan/parallel.h"

namespace relief {

namespace {

const Eigen::Vector3f kNoNormal =
    Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
constexpr std::array<std::pair<int, int>, 4> kNeighbours{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

Eigen::Vector3f facing_sensor(const Eigen::Vector3d& normal, const Ray& ray) {
  return (normal.dot(ray.direction) > 0.0 ? (-normal).eval() : normal).cast<float>();
}

// The samples of the window round (u,v) that are connected to it inside the window.
class ConnectedWindow {
 public:
  ConnectedWindow(const Grid<Eigen::Vector3d>& points, const GridEdges& edges, int radius)
      : points_(points),
        edges_(edges),
        radius_(radius),
        reached_(2 * radius + 1, 2 * radius + 1, 0) {}

  const std::vector<Eigen::Vector3d>& collect(int u, int v) {
    std::fill(reached_.begin(), reached_.end(), std::uint8_t{0});
    queue_.assign(1, {u, v});
    members_.clear();
    reached_(radius_, radius_) = 1;
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      const auto [pu, pv] = queue_[next];
      members_.push_back(points_(pu, pv));
      for (const auto& [du, dv] : kNeighbours) {
        const int wu = pu + du - u + radius_, wv = pv + dv - v + radius_;
        if (!reached_.contains(wu, wv) || reached_(wu, wv) || !edges_.connected(pu, pv, du, dv))
          continue;
        reached_(wu, wv) = 1;
        queue_.emplace_back(pu + du, pv + dv);
      }
    }
    return members_;
  }

 private:
  const Grid<Eigen::Vector3d>& points_;
  const GridEdges& edges_;
  int radius_;
  Grid<std::uint8_t> reached_;
  std::vector<std::pair<int, int>> queue_;
  std::vector<Eigen::Vector3d> members_;
};

Eigen::Vector3f plane_normal(const std::vector<Eigen::Vector3d>& members, const Ray& ray) {
  if (members.size() < 3) return kNoNormal;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : members) mean += p;
  mean /= static_cast<double>(members.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& p : members) covariance += (p - mean) * (p - mean).transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(covariance);
  if (!(eigen.eigenvalues()[1] > 1e-6 * eigen.eigenvalues()[2])) return kNoNormal;  // collinear
  return facing_sensor(eigen.eigenvectors().col(0), ray);
}

// The tangent along (du,dv) from the connected neighbours on either side; zero where there is none.
Eigen::Vector3d tangent(const Grid<Eigen::Vector3d>& points, const GridEdges& edges, int u, int v,
                        int du, int dv) {
  const bool after = edges.connected(u, v, du, dv), before = edges.connected(u, v, -du, -dv);
  const Eigen::Vector3d& head = after ? points(u + du, v + dv) : points(u, v);
  const Eigen::Vector3d& tail = before ? points(u - du, v - dv) : points(u, v);
  return head - tail;
}

}  // namespace

Grid<Eigen::Vector3f> estimate_normals(const RangeView& view, const GridEdges& edges,
                                       const GridNormalOptions& options) {
  const Grid<Eigen::Vector3d> points = points_of(view);
  Grid<Eigen::Vector3f> normals(view.width(), view.height(), kNoNormal);
  const auto rows = [&](std::size_t begin, std::size_t end) {
    ConnectedWindow window(points, edges, options.radius);
    for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
      if (v % options.stride != 0) continue;
      for (int u = 0; u < view.width(); u += options.stride)
        if (view.has_sample(u, v))
          normals(u, v) = plane_normal(window.collect(u, v), view.camera.ray(u, v));
    }
  };
  parallel_for(static_cast<std::size_t>(view.height()), 16, options.threads, rows);
  return normals;
}

Grid<Eigen::Vector3f> finite_difference_normals(const RangeView& view, const GridEdges& edges) {
  const Grid<Eigen::Vector3d> points = points_of(view);
  Grid<Eigen::Vector3f> normals(view.width(), view.height(), kNoNormal);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Eigen::Vector3d normal =
          tangent(points, edges, u, v, 1, 0).cross(tangent(points, edges, u, v, 0, 1));
      const double length = normal.norm();
      if (length > 0.0) normals(u, v) = facing_sensor(normal / length, view.camera.ray(u, v));
    }
  }
  return normals;
}

}  // namespace relief
