#pragma once

#include <ostream>
#include <string>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "relief/scan/camera.h"
#include "relief/scan/mesh_check.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// How GoogleTest prints a camera: its model and the size of its grid.
inline void PrintTo(const Camera& camera, std::ostream* out) {
  *out << to_string(camera.model()) << ' ' << camera.width() << 'x' << camera.height();
}

/// How GoogleTest prints what a mesh is: sizes, and what keeps it from being a valid solid.
inline void PrintTo(const MeshCheck& check, std::ostream* out) {
  *out << check.vertices << " vertices, " << check.faces << " faces, " << check.components
       << " components, genus " << check.genus << ", volume " << check.volume;
  const std::pair<std::size_t, const char*> faults[] = {
      {check.boundary_edges, "boundary edges"},
      {check.non_manifold_edges, "non-manifold edges"},
      {check.inconsistent_edges, "inconsistent edges"},
      {check.non_manifold_vertices, "non-manifold vertices"},
      {check.unused_vertices, "unused vertices"},
      {check.degenerate_faces, "degenerate faces"},
      {check.duplicate_vertices, "duplicate vertices"},
      {check.invalid_faces, "invalid faces"},
      {check.non_finite_vertices, "non-finite vertices"}};
  for (const auto& [count, name] : faults)
    if (count > 0) *out << ", " << count << ' ' << name;
}

/// How GoogleTest prints a mesh.
inline void PrintTo(const TriangleMesh& mesh, std::ostream* out) {
  *out << mesh.vertices.size() << " vertices, " << mesh.faces.size() << " faces";
}

namespace testing {

/// Vectors and matrices on one line.
template <typename Derived>
void show(const Eigen::MatrixBase<Derived>& value, std::ostream* out) {
  static const Eigen::IOFormat format(Eigen::FullPrecision, Eigen::DontAlignCols, ", ", "; ");
  if constexpr (Derived::ColsAtCompileTime == 1) {
    *out << value.transpose().format(format);
  } else {
    *out << value.format(format);
  }
}
inline void show(const RigidMotion& pose, std::ostream* out) { show(pose.matrix(), out); }

/// The value of an expression.
template <typename Derived>
typename Derived::PlainObject evaluated(const Eigen::MatrixBase<Derived>& value) {
  return value;
}
inline RigidMotion evaluated(const RigidMotion& pose) { return pose; }

/// Says how far `actual` is from `expected`.
template <typename Actual, typename Expected>
void explain(const Eigen::MatrixBase<Actual>& actual, const Expected& expected, std::ostream* out) {
  *out << (actual - expected).norm() << " away";
}
inline void explain(const RigidMotion& actual, const RigidMotion& expected, std::ostream* out) {
  *out << "turned by " << rotation_angle(expected.inverse() * actual) << " rad and moved by "
       << (actual.translation() - expected.translation()).norm();
}

/// Compares with `expected` as `Rule` says, and tells how far away the value is.
template <typename Expected, typename Rule>
class ClosenessMatcher {
 public:
  using is_gtest_matcher = void;

  ClosenessMatcher(Expected expected, Rule rule)
      : expected_(std::move(expected)), rule_(std::move(rule)) {}

  template <typename Actual>
  bool MatchAndExplain(const Actual& actual, std::ostream* out) const {
    if (out) explain(actual, expected_, out);
    return rule_.holds(actual, expected_);
  }
  void DescribeTo(std::ostream* out) const { describe("is", out); }
  void DescribeNegationTo(std::ostream* out) const { describe("is not", out); }

 private:
  void describe(const char* verb, std::ostream* out) const {
    *out << verb;
    rule_.describe(out);
    show(expected_, out);
  }
  Expected expected_;
  Rule rule_;
};

struct IsNearer {
  double tolerance;

  template <typename Actual, typename Expected>
  bool holds(const Actual& actual, const Expected& expected) const {
    return static_cast<double>((actual - expected).norm()) < tolerance;
  }
  void describe(std::ostream* out) const { *out << " nearer than " << tolerance << " to "; }
};

struct IsApproximately {
  double precision;

  template <typename Actual, typename Expected>
  bool holds(const Actual& actual, const Expected& expected) const {
    return actual.isApprox(expected, precision);
  }
  void describe(std::ostream* out) const { *out << ", to " << precision << " of its norm, "; }
};

/// Matches a vector or matrix whose difference from `expected` has a norm below `tolerance` (the
/// Frobenius norm for a matrix) [unit of the entries].
template <typename Derived>
auto IsNear(const Eigen::MatrixBase<Derived>& expected, double tolerance) {
  return ClosenessMatcher(evaluated(expected), IsNearer{tolerance});
}

/// Matches what `isApprox` of Eigen calls equal: the difference from `expected` is at most
/// `precision` of the smaller norm. Poses are compared as 4x4 matrices.
template <typename Expected>
auto IsApprox(const Expected& expected,
              double precision = Eigen::NumTraits<double>::dummy_precision()) {
  return ClosenessMatcher(evaluated(expected), IsApproximately{precision});
}

/// Matches a mesh, or what check_mesh says of one, that is a valid solid.
class IsWatertight {
 public:
  using is_gtest_matcher = void;

  bool MatchAndExplain(const MeshCheck& check, std::ostream*) const { return check.watertight(); }
  bool MatchAndExplain(const TriangleMesh& mesh, std::ostream* out) const {
    const MeshCheck check = check_mesh(mesh);
    if (out) PrintTo(check, out);
    return check.watertight();
  }
  void DescribeTo(std::ostream* out) const { *out << "is watertight"; }
  void DescribeNegationTo(std::ostream* out) const { *out << "is not watertight"; }
};

}  // namespace testing

// Like those of results, without using declarations.
using testing::IsApprox;
using testing::IsNear;
using testing::IsWatertight;

}  // namespace relief

namespace Eigen {

/// How GoogleTest prints a pose.
inline void PrintTo(const Isometry3d& pose, std::ostream* out) { relief::testing::show(pose, out); }

}  // namespace Eigen
