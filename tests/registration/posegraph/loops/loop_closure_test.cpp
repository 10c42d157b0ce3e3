#include "registration/posegraph/loops/loop_closure.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/posegraph/joint/joint_refinement.h"
#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

using testing::poses_of;
using testing::ring_of_views;

using Cycle = std::vector<std::size_t>;

constexpr double kRadius = 2.0;
const Eigen::Vector3d kCentre(3.0, -2.0, 1.0);

// Four views, each a pair with each other one, whose residuals are zero at the poses of the step.
class Square {
 public:
  explicit Square(unsigned seed = 3) : generator_(seed) {
    last_.centre = kCentre;
    last_.step_gain = 0.8;
    last_.tangents.assign(4, RigidTangent::Zero());
    for (std::size_t a = 0; a < 4; ++a) {
      views_.push_back({kCentre + vector(1.0), kRadius});
      for (std::size_t b = a + 1; b < 4; ++b) add(a, b);
    }
  }

  RigidTangent tangent(double size) {
    RigidTangent tangent;
    tangent << vector(size), vector(size);
    return tangent;
  }

  // Residuals that are least where view a moved by `motion` relative to view b.
  void ask_for(std::size_t a, std::size_t b, const RigidTangent& motion) {
    for (PairInformation& pair : last_.pairs)
      if (std::minmax(pair.source, pair.target) == std::minmax(a, b))
        pair.score -= (pair.source == a ? 1.0 : -1.0) * last_.step_gain * pair.information * motion;
  }

  // Residuals of `patches` patches, seen by both views of each pair, scatter.
  void scatter(int patches) {
    for (PairInformation& pair : last_.pairs) {
      pair.patches.clear();
      const Matrix6d root =
          Matrix6d(last_.step_gain * last_.step_gain * pair.information).llt().matrixL();
      for (int i = 0; i < patches; ++i) {
        const RigidTangent score = root * tangent(1.0) / std::sqrt(patches);
        pair.patches.push_back(
            {static_cast<std::uint64_t>(pair.source < pair.target ? i : i + 1000), score});
        pair.score += score;
      }
    }
  }

  PoseGraphLastStep& last() { return last_; }
  std::vector<PairFit>& fits() { return fits_; }
  const std::vector<PlacedView>& views() const { return views_; }

  std::vector<LoopClosure> close() const {
    return close_loops(views_, motions_of_pairs(last_, fits_), fits_, kCentre,
                       last_.variance_inflation);
  }

 private:
  Eigen::Vector3d vector(double size) {
    return size * Eigen::Vector3d(normal_(generator_), normal_(generator_), normal_(generator_));
  }

  void add(std::size_t a, std::size_t b) {
    PairFit fit;
    fit.a = a;
    fit.b = b;
    fit.overlap = 0.5 - 0.01 * static_cast<double>(a + b);
    fits_.push_back(fit);
    for (const auto& [source, target] : {std::pair(a, b), std::pair(b, a)}) {
      PairInformation pair;
      pair.source = source;
      pair.target = target;
      pair.count = 40;
      for (int i = 0; i < 40; ++i) {
        const RigidTangent j = tangent(100.0);
        pair.information += j * j.transpose();
      }
      last_.pairs.push_back(pair);
    }
  }

  std::mt19937 generator_;
  std::normal_distribution<double> normal_;
  PoseGraphLastStep last_;
  std::vector<PlacedView> views_;
  std::vector<PairFit> fits_;
};

bool passes(const Cycle& cycle, std::size_t a, std::size_t b) {
  for (std::size_t i = 0; i < cycle.size(); ++i)
    if (std::minmax(cycle[i], cycle[(i + 1) % cycle.size()]) == std::minmax(a, b)) return true;
  return false;
}

TEST(LoopClosure, IsZeroForExactMotions) {
  const Square square;
  const auto loops = square.close();
  ASSERT_EQ(loops.size(), 3u);
  for (const LoopClosure& loop : loops) {
    EXPECT_EQ(loop.length, 0.0);
    EXPECT_EQ(loop.angle, 0.0);
    EXPECT_DOUBLE_EQ(loop.radius, kRadius);
  }
}

// Residuals that are all least at other poses than the present ones, but at the same ones.
TEST(LoopClosure, IsZeroWhereAllPairsAskForTheSamePoses) {
  Square square;
  std::vector<RigidTangent> poses;
  for (int i = 0; i < 4; ++i) poses.push_back(square.tangent(1e-4));
  for (const PairFit& fit : square.fits())
    square.ask_for(fit.a, fit.b, poses[fit.a] - poses[fit.b]);
  for (const LoopClosure& loop : square.close()) EXPECT_LT(loop.length, 1e-6);
  square.last().tangents = poses;  // Those of the joint solution.
  for (const LoopClosure& loop : square.close()) EXPECT_LT(loop.length, 1e-12);
}

TEST(LoopClosure, ShowsThePerturbedPairInItsLoopsAlone) {
  Square square;
  const RigidTangent motion = square.tangent(0.01);
  square.ask_for(1, 2, motion);
  int with = 0;
  for (const LoopClosure& loop : square.close()) {
    if (!passes(loop.views, 1, 2)) {
      EXPECT_LT(loop.length, 1e-15);
      continue;
    }
    ++with;
    // Points on the sphere around the views of the loop, moved.
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const std::size_t view : loop.views)
      middle += square.views()[view].centre / static_cast<double>(loop.views.size());
    const RigidMotion moved = motion_from_tangent(motion);
    double squares = 0.0;
    for (int k = 0; k < 6; ++k) {
      Eigen::Vector3d point = middle - kCentre;
      point[k / 2] += k % 2 == 0 ? kRadius : -kRadius;
      squares += (moved * point - point).squaredNorm() / 6.0;
    }
    EXPECT_NEAR(loop.length, std::sqrt(squares), 1e-3 * std::sqrt(squares));
    EXPECT_NEAR(loop.angle, motion.head<3>().norm(), 1e-9);
  }
  EXPECT_GE(with, 1);
}

// Along what a pair does not determine its own motion would be as far off as it likes.
TEST(LoopClosure, LeavesDegenerateDirectionsAlone) {
  Square square;
  RigidTangent sliding = RigidTangent::Zero();
  sliding[4] = 1.0;
  for (PairInformation& pair : square.last().pairs) {
    Matrix6d rest = Matrix6d::Identity();
    rest(4, 4) = 1e-6;
    if (pair.source + pair.target == 1) pair.information = rest * pair.information * rest;
  }
  square.ask_for(0, 1, 5.0 * sliding);
  EXPECT_GT(square.close().front().length, 1.0);
  DegenerateDirection direction;
  direction.motion = sliding;
  direction.centre = Eigen::Vector3d(7.0, 8.0, 9.0);
  square.fits().front().degenerate_directions = {direction};
  for (const LoopClosure& loop : square.close()) EXPECT_LT(loop.length, 1e-4);
}

TEST(LoopClosure, KnowsHowFarNoiseMissesIt) {
  double lengths = 0.0, angles = 0.0;
  int count = 0;
  for (unsigned seed = 0; seed < 150; ++seed) {
    Square square(seed);
    square.scatter(60);
    for (const LoopClosure& loop : square.close()) {
      lengths += std::pow(loop.ratio(), 2);
      angles += std::pow(loop.angle / loop.angle_std, 2);
      ++count;
    }
  }
  // Residuals here are not fitted to poses, so no degree of freedom is missing.
  const double factor = 60.0 * 2.0 / (60.0 * 2.0 - 6.0);
  EXPECT_NEAR(factor * lengths / count, 1.0, 0.12);
  EXPECT_NEAR(factor * angles / count, 1.0, 0.12);
}

// The noise of a view on a patch of the surface moves both of its pairs, and cancels.
TEST(LoopClosure, CountsNoiseOfACommonPatchOnce) {
  Square square;
  for (PairInformation& pair : square.last().pairs) pair.information = 1e4 * Matrix6d::Identity();
  const std::vector<RigidTangent> of_view{square.tangent(1.0), square.tangent(1.0),
                                          square.tangent(1.0), square.tangent(1.0)};
  for (PairInformation& pair : square.last().pairs) {
    if (pair.source > pair.target) continue;
    const RigidTangent score = of_view[pair.source] - of_view[pair.target];
    pair.patches = {{5, score}};
    pair.score = score;
  }
  for (const LoopClosure& loop : square.close()) {
    EXPECT_LT(loop.length, 1e-6);
    EXPECT_LT(loop.length_std, 1e-6);
  }
}

std::vector<LoopClosure> loops_of(const std::vector<RangeView>& views) {
  std::vector<ViewSurface> surfaces;
  for (const RangeView& view : views) surfaces.emplace_back(view);
  const auto refined = refine_jointly(surfaces, poses_of(views),
                                      std::vector<ViewRole>(views.size(), ViewRole::kFree));
  EXPECT_TRUE(refined);
  return refined->loops;
}

TEST(LoopClosure, OfNoisyViewsIsWhatNoiseExplains) {
  double squares = 0.0;
  std::size_t count = 0;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    for (const LoopClosure& loop : loops_of(ring_of_views({.seed = seed}))) {
      squares += std::pow(loop.ratio(), 2);
      ++count;
    }
  }
  ASSERT_GT(count, 10u);
  const double mean = squares / static_cast<double>(count);
  RecordProperty("mean_square_ratio", std::to_string(mean));
  EXPECT_GT(mean, 0.4);
  EXPECT_LT(mean, 1.8);
}

// A view whose sensor bends what it sees fits each of the others differently.
TEST(LoopClosure, TellsOfAViewThatIsBent) {
  auto views = ring_of_views({.seed = 4});
  const double straight = loops_of(views).front().ratio();
  RangeView& bent = views[3];
  for (int v = 0; v < bent.height(); ++v)
    for (int u = 0; u < bent.width(); ++u)
      bent.range(u, v) *= 1.0 + 0.02 * std::pow(2.0 * u / bent.width() - 1.0, 2);
  const auto loops = loops_of(views);
  ASSERT_FALSE(loops.empty());
  EXPECT_GT(loops.front().ratio(), 1.5 * straight);
  EXPECT_THAT(loops.front().views, ::testing::Contains(3u));
  EXPECT_TRUE(std::is_sorted(loops.begin(), loops.end(),
                             [](const auto& a, const auto& b) { return a.ratio() > b.ratio(); }));
}

}  // namespace
}  // namespace relief::registration
