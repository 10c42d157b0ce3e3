#include "scan/grid/grid_normals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Dense>

#include "scan/base/parallel.h"

namespace relief {

namespace {

const Eigen::Vector3f kNoNormal =
    Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());

Eigen::Vector3f facing_sensor(const Eigen::Vector3d& normal, const Ray& ray) {
  return (normal.dot(ray.direction) > 0.0 ? (-normal).eval() : normal).cast<float>();
}

// Sums over points, of their coordinates and the products of these.
struct Moments {
  double count = 0.0, x = 0.0, y = 0.0, z = 0.0;
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;

  void add(const Eigen::Vector3d& p) {
    count += 1.0;
    x += p.x();
    y += p.y();
    z += p.z();
    xx += p.x() * p.x();
    xy += p.x() * p.y();
    xz += p.x() * p.z();
    yy += p.y() * p.y();
    yz += p.y() * p.z();
    zz += p.z() * p.z();
  }
  void add(const Moments& m, double times = 1.0) {
    count += times * m.count;
    x += times * m.x;
    y += times * m.y;
    z += times * m.z;
    xx += times * m.xx;
    xy += times * m.xy;
    xz += times * m.xz;
    yy += times * m.yy;
    yz += times * m.yz;
    zz += times * m.zz;
  }
};

// The samples of the window round (u,v) that are connected to it inside the window.
class ConnectedWindow {
 public:
  ConnectedWindow(const Grid<Eigen::Vector3d>& points, const GridEdges& edges, int radius)
      : points_(points),
        edges_(edges),
        radius_(radius),
        reached_(2 * radius + 1, 2 * radius + 1, 0) {}

  // Their moments relative to the one at (u,v).
  Moments collect(int u, int v) {
    std::fill(reached_.begin(), reached_.end(), std::uint8_t{0});
    queue_.assign(1, {u, v});
    Moments sum;
    reached_(radius_, radius_) = 1;
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      const auto [pu, pv] = queue_[next];
      sum.add(points_(pu, pv) - points_(u, v));
      const auto reach = [&, to_u = radius_ - u, to_v = radius_ - v](int qu, int qv) {
        if (!reached_.contains(qu + to_u, qv + to_v) || reached_(qu + to_u, qv + to_v)) return;
        reached_(qu + to_u, qv + to_v) = 1;
        queue_.emplace_back(qu, qv);
      };
      if (edges_.right(pu, pv)) reach(pu + 1, pv);
      if (pu > 0 && edges_.right(pu - 1, pv)) reach(pu - 1, pv);
      if (edges_.down(pu, pv)) reach(pu, pv + 1);
      if (pv > 0 && edges_.down(pu, pv - 1)) reach(pu, pv - 1);
    }
    return sum;
  }

 private:
  const Grid<Eigen::Vector3d>& points_;
  const GridEdges& edges_;
  int radius_;
  Grid<std::uint8_t> reached_;
  std::vector<std::pair<int, int>> queue_;
};

// Moments of whole windows along one row of the grid, from sums over columns that neighbours share.
// A window is the one before with a column more and one less; since all are relative to one point
// of the row, rounding stays far below what the samples are known to.
class RowOfWindows {
 public:
  RowOfWindows(const Grid<Eigen::Vector3d>& points, int radius)
      : points_(points), radius_(radius), columns_(static_cast<std::size_t>(points.width())) {}

  // Goes to row v.
  void start(int v) {
    v_ = v;
    next_ = 0;
    before_ = -2;
  }

  // Of the window round column u, which lies in the grid and has all samples, relative to a point
  // of the row. Columns are asked for from left to right.
  Moments at(int u) {
    if (next_ == 0) origin_ = points_(u, v_);
    next_ = std::max(next_, u - radius_);
    for (; next_ <= u + radius_; ++next_) columns_[static_cast<std::size_t>(next_)] = column(next_);
    if (u == before_ + 1) {
      sum_.add(columns_[static_cast<std::size_t>(u + radius_)]);
      sum_.add(columns_[static_cast<std::size_t>(u - radius_ - 1)], -1.0);
    } else {
      sum_ = {};
      for (int x = u - radius_; x <= u + radius_; ++x)
        sum_.add(columns_[static_cast<std::size_t>(x)]);
    }
    before_ = u;
    return sum_;
  }

 private:
  Moments column(int u) const {
    Moments sum;
    for (int v = v_ - radius_; v <= v_ + radius_; ++v) sum.add(points_(u, v) - origin_);
    return sum;
  }

  const Grid<Eigen::Vector3d>& points_;
  int radius_;
  int v_ = 0, next_ = 0;  // The row, and the first column without a sum.
  int before_ = -2;       // The last window's middle,
  Moments sum_;           // and its moments.
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<Moments> columns_;
};

// The eigenvector of a covariance's least eigenvalue; nothing if the second is no larger than
// rounding makes it, as of collinear points.
std::optional<Eigen::Vector3d> least_direction(const Eigen::Matrix3d& c) {
  // Newton's method from 0 on det(C - x I), which falls and is convex up to its least root. The
  // trigonometric solution costs several times as much. A double root halves the error each step:
  // 30 leave 1e-9.
  constexpr int kMostSteps = 30;
  const double trace = c.trace();
  const double minors = c(0, 0) * c(1, 1) - c(0, 1) * c(0, 1) + c(0, 0) * c(2, 2) -
                        c(0, 2) * c(0, 2) + c(1, 1) * c(2, 2) - c(1, 2) * c(1, 2);
  const double determinant = c.determinant();
  double x = 0.0;
  for (int i = 0; i < kMostSteps; ++i) {
    const double value = determinant - x * (minors - x * (trace - x));
    const double slope = minors - x * (2.0 * trace - 3.0 * x);
    const double step = slope > 0.0 ? value / slope : 0.0;
    x += step;
    if (!(std::abs(step) > 1e-12 * trace)) break;
  }
  // The others' product and sum.
  const double product = minors - x * (trace - x), sum = trace - x;
  if (!(product > 1e-6 * sum * sum)) return std::nullopt;
  Eigen::Matrix3d shifted = c;
  shifted.diagonal().array() -= x;
  // Rows of the shifted matrix lie in the plane across the direction.
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d across = shifted.col(k).cross(shifted.col((k + 1) % 3));
    if (across.squaredNorm() > best.squaredNorm()) best = across;
  }
  return best.normalized();
}

// Of what a window is wide across the ray, standard deviations: from here on planes are fitted
// along the ray. Up to there noise turns planes across by two degrees at most, a third of its
// square.
constexpr double kNoisyWindow = 0.32;

// The least-squares plane along the ray, if the noise matters to the window. `c` is the covariance
// of its samples, times their count.
std::optional<Eigen::Vector3d> normal_along_ray(const Eigen::Matrix3d& c, double count,
                                                const Eigen::Vector3d& ray, double noise) {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = ray.unitOrthogonal();
  across.col(1) = ray.cross(across.col(0));
  const Eigen::Matrix2d width = across.transpose() * c * across;
  const double half = 0.5 * width.trace(), determinant = width.determinant();
  const double least = half - std::sqrt(std::max(0.0, half * half - determinant));
  const bool noisy = kNoisyWindow * kNoisyWindow * least < count * noise * noise;
  if (!noisy || !(determinant > 1e-6 * half * half)) return std::nullopt;
  const Eigen::Vector2d slope = width.inverse() * (across.transpose() * c * ray);
  return (ray - across * slope).normalized();
}

// `noise`: standard deviation along the ray [unit]; 0: none.
Eigen::Vector3f plane_normal(const Moments& sum, const Ray& ray, double noise) {
  if (sum.count < 3.0) return kNoNormal;
  const Eigen::Vector3d mean = Eigen::Vector3d(sum.x, sum.y, sum.z) / sum.count;
  Eigen::Matrix3d covariance;
  covariance << sum.xx, sum.xy, sum.xz, sum.xy, sum.yy, sum.yz, sum.xz, sum.yz, sum.zz;
  covariance -= sum.count * mean * mean.transpose();
  auto normal = noise > 0.0
                    ? normal_along_ray(covariance, sum.count, ray.direction.normalized(), noise)
                    : std::nullopt;
  if (!normal) normal = least_direction(covariance);
  return normal ? facing_sensor(*normal, ray) : kNoNormal;
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
  return estimate_normals(view, {points_of(view), edges, boundary_distance(view, edges)}, options);
}

Grid<Eigen::Vector3f> estimate_normals(const RangeView& view, const ConnectedGrid& grid,
                                       const GridNormalOptions& options) {
  Grid<Eigen::Vector3f> normals(view.width(), view.height(), kNoNormal);
  const auto noise_at = [&](int u, int v) {
    return options.noise ? options.noise->sigma_at(u, v) : 0.0;
  };
  const auto rows = [&](std::size_t begin, std::size_t end) {
    ConnectedWindow connected(grid.points, grid.edges, options.radius);
    RowOfWindows whole(grid.points, options.radius);
    for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
      if (v % options.stride != 0) continue;
      whole.start(v);
      for (int u = 0; u < view.width(); u += options.stride) {
        if (!view.has_sample(u, v) || grid.boundary(u, v) < options.margin) continue;
        const bool inside = grid.boundary(u, v) > options.radius;
        normals(u, v) = plane_normal(inside ? whole.at(u) : connected.collect(u, v),
                                     view.camera.ray(u, v), noise_at(u, v));
      }
    }
  };
  parallel_for(static_cast<std::size_t>(view.height()), 16, rows);
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
