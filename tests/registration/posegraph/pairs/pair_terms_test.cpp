#include "registration/posegraph/pairs/pair_terms.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "registration/pairwise/robust.h"
#include "scan/base/robust_scales.h"

namespace relief::registration {
namespace {

struct Terms {
  std::vector<PlaneResidual> planes;
  std::vector<NormalResidual> normals;

  CompressedTerms compress(const RigidMotion& motion) const {
    return PairTerms{planes, normals}.compress(motion);
  }
};

class RandomTerms {
 public:
  /// Points in a ball; the normals of the planes have a z component times `tilt` less than others.
  Terms make(int planes, int normals, double flatness = 1.0) {
    Terms terms;
    for (int i = 0; i < planes; ++i) {
      const Eigen::Vector3d n =
          Eigen::Vector3d(flatness * number_(engine_), flatness * number_(engine_), 1.0)
              .normalized();
      terms.planes.push_back({vector(), vector(), n, 1.0 + std::abs(number_(engine_))});
    }
    for (int i = 0; i < normals; ++i) {
      NormalResidual term;
      term.source = vector();
      term.target = vector();
      term.normal = vector().normalized();
      const Eigen::Vector3d n = vector().normalized();
      term.basis << n.unitOrthogonal(), n.cross(n.unitOrthogonal());
      term.gradient << vector(), vector();
      term.scale = 1.0 + std::abs(number_(engine_));
      terms.normals.push_back(term);
    }
    return terms;
  }
  RigidMotion motion() {
    RigidTangent tangent;
    tangent << 0.1 * vector(), 0.1 * vector();
    return motion_from_tangent(tangent);
  }

 private:
  Eigen::Vector3d vector() { return {number_(engine_), number_(engine_), number_(engine_)}; }
  std::mt19937 engine_{1};
  std::normal_distribution<double> number_;
};

double cauchy_loss(double squared, double c) { return c * c * std::log1p(squared / (c * c)); }

double loss_at(const Terms& terms, const RigidMotion& motion) {
  double sum = 0.0;
  RigidTangent j;
  std::array<RigidTangent, 2> both;
  for (const auto& plane : terms.planes) {
    const double r = plane.evaluate(motion, j);
    sum += cauchy_loss(r * r, kCauchyScale);
  }
  for (const auto& normal : terms.normals)
    sum += cauchy_loss(normal.evaluate(motion, both).squaredNorm(), std::sqrt(2.0) * kCauchyScale);
  return sum;
}

// sum of w j j^T over all terms.
Matrix6d information_at(const Terms& terms, const RigidMotion& motion) {
  Matrix6d sum = Matrix6d::Zero();
  RigidTangent j;
  std::array<RigidTangent, 2> both;
  for (const auto& plane : terms.planes) {
    const double r = plane.evaluate(motion, j);
    sum += cauchy_weight(r, kCauchyScale) * j * j.transpose();
  }
  for (const auto& normal : terms.normals) {
    const double r = normal.evaluate(motion, both).norm();
    for (const auto& row : both)
      sum += cauchy_weight(r, std::sqrt(2.0) * kCauchyScale) * row * row.transpose();
  }
  return sum;
}

void expect_exact(const Terms& terms, const RigidMotion& motion) {
  const CompressedTerms compressed = terms.compress(motion);
  const double loss = loss_at(terms, motion);
  EXPECT_NEAR(compressed.residuals.squaredNorm(), loss, 1e-11 * loss);
  const Matrix6d information = information_at(terms, motion);
  EXPECT_LT((compressed.derivative.transpose() * compressed.derivative - information).norm(),
            1e-11 * information.norm());
  const RigidTangent gradient = 2.0 * compressed.derivative.transpose() * compressed.residuals;
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 6; ++k) {
    double values[2];
    for (const int side : {0, 1})
      values[side] = loss_at(terms, motion_from_tangent((side ? kStep : -kStep) *
                                                        RigidTangent(RigidTangent::Unit(k))) *
                                        motion);
    EXPECT_NEAR(gradient[k], (values[1] - values[0]) / (2 * kStep), 1e-6 * gradient.norm());
  }
}

TEST(PairTerms, SevenResidualsStandForAll) {
  RandomTerms random;
  expect_exact(random.make(2000, 0), random.motion());
  expect_exact(random.make(500, 300), random.motion());
  expect_exact(random.make(0, 300), random.motion());
}

TEST(PairTerms, FewTermsDetermineFewDirections) {
  RandomTerms random;
  expect_exact(random.make(3, 0), random.motion());
  expect_exact(random.make(1, 0), random.motion());
}

TEST(PairTerms, NothingHoldsAMotionAlongAPlane) {
  RandomTerms random;
  Terms terms = random.make(500, 0, 0.0);
  expect_exact(terms, random.motion());
  const CompressedTerms compressed = terms.compress(RigidMotion::Identity());
  RigidTangent along;
  along << 0.0, 0.0, 1.0, 1.0, -2.0, 0.0;
  EXPECT_LT((compressed.derivative * along).norm(), 1e-6 * compressed.derivative.norm());
}

TEST(PairTerms, UnitsChangeNoResidual) {
  RandomTerms random;
  Terms terms = random.make(500, 0);
  RigidMotion motion = random.motion();
  const CompressedTerms before = terms.compress(motion);
  constexpr double kUnit = 1e6;
  for (auto& plane : terms.planes) {
    plane.source *= kUnit;
    plane.target *= kUnit;
    plane.scale /= kUnit;
  }
  motion.translation() *= kUnit;
  const CompressedTerms after = terms.compress(motion);
  EXPECT_LT((after.residuals.cwiseAbs() - before.residuals.cwiseAbs()).norm(),
            1e-8 * before.residuals.norm());
}

TEST(PairTerms, NoTermsSayNothing) {
  const CompressedTerms compressed = PairTerms().compress(RigidMotion::Identity());
  EXPECT_EQ(compressed.residuals.norm(), 0.0);
  EXPECT_EQ(compressed.derivative.norm(), 0.0);
}

}  // namespace
}  // namespace relief::registration
