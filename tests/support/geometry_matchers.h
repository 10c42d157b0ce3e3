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

template <typename Expected>
class NearMatcher {
 public:
  using is_gtest_matcher = void;

  NearMatcher(Expected expected, double tolerance)
      : expected_(std::move(expected)), tolerance_(tolerance) {}

  template <typename Actual>
  bool MatchAndExplain(const Actual& actual, std::ostream* out) const {
    if (out) explain(actual, expected_, out);
    return static_cast<double>((actual - expected_).norm()) < tolerance_;
  }
  void DescribeTo(std::ostream* out) const { describe("is nearer than ", out); }
  void DescribeNegationTo(std::ostream* out) const { describe("is not nearer than ", out); }

 private:
  void describe(const char* verb, std::ostream* out) const {
    *out << verb << tolerance_ << " to ";
    show(expected_, out);
  }
  Expected expected_;
  double tolerance_;
};

/// Matches a vector or matrix whose difference from `expected` has a norm below `tolerance` (the
/// Frobenius norm for a matrix) [unit of the entries].
template <typename Derived>
auto IsNear(const Eigen::MatrixBase<Derived>& expected, double tolerance) {
  return NearMatcher(evaluated(expected), tolerance);
}

template <typename Expected>
class ApproxMatcher {
 public:
  using is_gtest_matcher = void;

  ApproxMatcher(Expected expected, double precision)
      : expected_(std::move(expected)), precision_(precision) {}

  template <typename Actual>
  bool MatchAndExplain(const Actual& actual, std::ostream* out) const {
    if (out) explain(actual, expected_, out);
    return actual.isApprox(expected_, precision_);
  }
  void DescribeTo(std::ostream* out) const { describe("is", out); }
  void DescribeNegationTo(std::ostream* out) const { describe("is not", out); }

 private:
  void describe(const char* verb, std::ostream* out) const {
    *out << verb << ", to " << precision_ << " of its norm, ";
    show(expected_, out);
  }
  Expected expected_;
  double precision_;
};

/// Matches what `isApprox` of Eigen calls equal: the difference from `expected` is at most
/// `precision` of the smaller norm. Poses are compared as 4x4 matrices.
template <typename Expected>
auto IsApprox(const Expected& expected,
              double precision = Eigen::NumTraits<double>::dummy_precision()) {
  return ApproxMatcher(evaluated(expected), precision);
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
