#include "registration/global/view_groups.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "registration/global/links/link_limits.h"
#include "registration/global/links/pair_support.h"
#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

RigidMotion turn_about_z(double angle) {
  RigidTangent tangent = RigidTangent::Zero();
  tangent[2] = angle;
  return motion_from_tangent(tangent);
}

std::vector<ViewSurface> surfaces_of(const std::vector<RangeView>& views) {
  std::vector<ViewSurface> surfaces;
  for (const RangeView& view : views) surfaces.emplace_back(view);
  return surfaces;
}

// Moves a square of a view's samples towards the sensor, as where a face moves between two scans.
void move_part(RangeView& view, double distance) {
  const int size = view.width() / 3;
  for (int v = size; v < 2 * size; ++v)
    for (int u = size; u < 2 * size; ++u) view.range(u, v) -= distance;
}

// Two groups of three neighbours each on a ring, each in a frame of its own, and the one link that
// joins them, off by `link_error`.
ViewGroups join_halves(const std::vector<RangeView>& views, const RigidMotion& link_error) {
  const std::vector<ViewSurface> surfaces = surfaces_of(views);
  ViewGroups start;
  start.group = {0, 0, 0, 3, 3, 3};
  for (std::size_t i = 0; i < views.size(); ++i)
    start.group_from_view.push_back((i < 3 ? RigidMotion::Identity() : turn_about_z(1.0)) *
                                    views[i].world_from_view);
  PoseLink link;
  link.a = 2;
  link.b = 3;
  const RigidMotion truth = views[3].world_from_view.inverse() * views[2].world_from_view;
  link.b_from_a = link_error * truth;
  link.evidence = judge_pose(surfaces[2], surfaces[3], truth);
  JudgedPairs judged(surfaces);
  return join_views(surfaces, {link}, start, std::vector<bool>(views.size(), false), {}, judged);
}

std::vector<RangeView> six_neighbours() {
  auto views = testing::ring_of_views({.views = 16, .pixels = 128});
  views.resize(6);
  return views;
}

TEST(ViewGroups, JoinAtTheTruePose) {
  const auto views = six_neighbours();
  const ViewGroups joined = join_halves(views, RigidMotion::Identity());
  EXPECT_TRUE(joined.all_in_one());
  EXPECT_TRUE(joined.group_from_view[5].isApprox(views[5].world_from_view, 1e-6));
}

TEST(ViewGroups, OnePairALittleBeyondItsLimitsIsOutweighed) {
  auto views = six_neighbours();
  const double spacing = ViewSurface(views[4]).spacing();
  move_part(views[4], 1.5 * spacing);
  EXPECT_TRUE(join_halves(views, RigidMotion::Identity()).all_in_one());
}

TEST(ViewGroups, StayApartWhereMostPairsDeny) {
  const auto views = six_neighbours();
  RigidTangent error = RigidTangent::Zero();
  error[0] = 0.1;
  EXPECT_FALSE(join_halves(views, motion_from_tangent(error)).all_in_one());
}

// Clouds are often cut: the one view misses much that it should have seen. That speaks against a
// pose, unless the pair by itself was found there.
TEST(PairSupport, CoverageIsNotMissedWhereAPairWasFoundByItself) {
  auto views = six_neighbours();
  views.resize(2);
  RangeView& cut = views[1];
  for (int v = 0; v < cut.height() / 2; ++v)
    for (int u = 0; u < cut.width(); ++u) cut.range(u, v) = kNoSample;
  const std::vector<ViewSurface> surfaces = surfaces_of(views);
  const RigidMotion truth = views[0].world_from_view.inverse() * cut.world_from_view;
  const PoseLink link{1, 0, truth, judge_pose(surfaces[1], surfaces[0], truth)};
  ASSERT_TRUE(plausible(link.evidence, surfaces[1], surfaces[0]));
  ASSERT_TRUE(misses_coverage(link.evidence));
  const ViewGroupOptions options;
  const std::vector<PoseLink> none, found{link};
  JudgedPairs judged(surfaces);
  EXPECT_LT(PairSupport(surfaces, none, {}, options, judged).support(0, 1, truth), 0.0);
  EXPECT_EQ(PairSupport(surfaces, found, {}, options, judged).support(0, 1, truth),
            link.evidence.overlap);
}

std::vector<RangeView> two_neighbours() {
  auto views = six_neighbours();
  views.resize(2);
  return views;
}

// Two neighbours and the link between them at the true pose.
struct LinkedPair {
  std::vector<ViewSurface> surfaces;
  PoseLink link;
};

// `views` are two, and outlive the pair.
LinkedPair linked_pair(const std::vector<RangeView>& views) {
  LinkedPair pair{surfaces_of(views), {}};
  const RigidMotion truth = views[1].world_from_view.inverse() * views[0].world_from_view;
  pair.link = {0, 1, truth, judge_pose(pair.surfaces[0], pair.surfaces[1], truth)};
  return pair;
}

// Views of a street fit along it, too, with smaller deviations than where they belong.
TEST(LinkLimits, APoseThatSlidesTellsNothingOfErrors) {
  const auto views = two_neighbours();
  const LinkedPair pair = linked_pair(views);
  PoseLink found = pair.link, sliding = pair.link;
  found.evidence.normal_rms = 0.2;
  sliding.evidence.rms *= 0.5;
  sliding.evidence.normal_rms = 0.05;
  sliding.evidence.degenerate = true;
  const ViewGroupOptions options;
  const auto normals = [&](const std::vector<PoseLink>& links) {
    return fit_link_limits(pair.surfaces, links, std::vector<int>(links.size(), 0), options)
        .lone.max_normal_rms;
  };
  EXPECT_EQ(normals({found, sliding}), normals({found}));
  EXPECT_LT(normals({sliding}), normals({found}));
}

// As those of a body of revolution, or of what stands still before the sensor.
TEST(LinkLimits, LoopsOfViewsLaidOnEachOtherConfirmNothing) {
  const auto views = six_neighbours();
  const std::vector<ViewSurface> surfaces = surfaces_of(views);
  const auto loops_at = [&](const auto& pose) {
    std::vector<PoseLink> links;
    for (const auto& [a, b] : {std::pair{0u, 1u}, std::pair{1u, 2u}, std::pair{0u, 2u}})
      links.push_back({a, b, pose(b).inverse() * pose(a), {}});
    return count_loops(surfaces, links);
  };
  EXPECT_EQ(loops_at([&](std::size_t i) { return views[i].world_from_view; }),
            (std::vector<int>{1, 1, 1}));
  EXPECT_EQ(loops_at([](std::size_t) { return RigidMotion::Identity(); }),
            (std::vector<int>{0, 0, 0}));
  EXPECT_EQ(loops_at([](std::size_t i) { return turn_about_z(0.01 * static_cast<double>(i)); }),
            (std::vector<int>{0, 0, 0}));
}

// Two exposures from one place have the same errors, and fit at the same wrong poses.
TEST(LinkLimits, ViewsTakenAgainConfirmNothing) {
  const auto views = six_neighbours();
  const std::vector<ViewSurface> surfaces = surfaces_of({views[0], views[0], views[1]});
  const RigidMotion wrong = turn_about_z(1.0), none = RigidMotion::Identity();
  EXPECT_EQ(count_loops(surfaces, {{0, 1, none, {}}, {0, 2, wrong, {}}, {1, 2, wrong, {}}}),
            (std::vector<int>{1, 0, 0}));
  PoseLink repeated{0, 1, none, {}}, other{0, 2, wrong, {}};
  repeated.evidence.overlap = other.evidence.overlap = 0.5;
  repeated.evidence.rms = 0.1 * surfaces[0].spacing();
  other.evidence.rms = 0.5 * surfaces[0].spacing();
  const auto limit = [&](const std::vector<PoseLink>& links) {
    return fit_link_limits(surfaces, links, std::vector<int>(links.size(), 0), {}).lone.max_rms;
  };
  EXPECT_EQ(limit({repeated, other}), limit({other}));
  EXPECT_LT(limit({repeated}), limit({other}));
}

TEST(LinkLimits, NeighboursOfATurntableAreNotTakenForOneView) {
  auto views = testing::ring_of_views({.views = 24, .pixels = 48, .tilts = {0.2, 0.2}});
  views.resize(4);
  const std::vector<ViewSurface> surfaces = surfaces_of(views);
  std::vector<PoseLink> links;
  for (const auto& [a, b] : {std::pair{0u, 1u}, std::pair{1u, 3u}, std::pair{0u, 3u}})
    links.push_back({a, b, views[b].world_from_view.inverse() * views[a].world_from_view, {}});
  EXPECT_EQ(count_loops(surfaces, links), (std::vector<int>{1, 1, 1}));
}

TEST(LinkLimits, FollowFourPairsThatCloseLoopsAtOnePlace) {
  const auto views = six_neighbours();
  const std::vector<ViewSurface> surfaces = surfaces_of(views);
  const auto link = [&](std::size_t a, std::size_t b, double turned = 0.0) {
    PoseLink found{
        a,
        b,
        turn_about_z(turned) * views[b].world_from_view.inverse() * views[a].world_from_view,
        {}};
    found.evidence.overlap = 0.5;
    found.evidence.coherent_rms = 0.5 * coarser_spacing(surfaces[a], surfaces[b]);
    return found;
  };
  const auto coherent = [&](const std::vector<PoseLink>& links) {
    return fit_link_limits(surfaces, links, std::vector<int>(links.size(), 1), {})
        .lone.max_coherent_rms;
  };
  const double general = VerificationThresholds().max_coherent_rms;
  EXPECT_GT(coherent({link(0, 1), link(1, 2), link(2, 3), link(0, 2)}), 0.5);
  EXPECT_EQ(coherent({link(0, 1), link(1, 2), link(0, 2), link(1, 0), link(0, 1)}), general);
  EXPECT_EQ(coherent({link(0, 1), link(1, 2), link(2, 3), link(0, 2), link(0, 2, 1.0)}), general);
}

// Small patches fit better than errors bend the whole.
TEST(LinkLimits, DoNotFollowLinksThatShareTooLittleToBeBelieved) {
  const auto views = six_neighbours();
  const std::vector<ViewSurface> surfaces = surfaces_of(views);
  const auto link = [&](std::size_t a, std::size_t b, double overlap, double rms) {
    PoseLink found{a, b, views[b].world_from_view.inverse() * views[a].world_from_view, {}};
    found.evidence.overlap = overlap;
    found.evidence.rms = rms * coarser_spacing(surfaces[a], surfaces[b]);
    return found;
  };
  const auto limit = [&](const std::vector<PoseLink>& links, int loops) {
    return fit_link_limits(surfaces, links, std::vector<int>(links.size(), loops), {}).lone.max_rms;
  };
  const PoseLink large = link(0, 1, 0.4, 0.5), small = link(2, 3, 0.2, 0.2);
  EXPECT_EQ(limit({large, small}, 0), limit({large}, 0));
  EXPECT_LT(limit({large, small}, 1), limit({large}, 1));  // Confirmed links tell their errors.
  EXPECT_LT(limit({small}, 0), limit({large}, 0));         // So do small ones without others.
}

// Noise depends on the pair: some right pairs deviate by three times what the better quarter does.
TEST(LinkLimits, FollowTheDeviationsOfPairsThatSeveralLoopsClose) {
  const auto views = six_neighbours();
  const std::vector<ViewSurface> surfaces = surfaces_of(views);
  const auto link = [&](std::size_t a, std::size_t b, double rms, double turned = 0.0) {
    PoseLink found{
        a,
        b,
        turn_about_z(turned) * views[b].world_from_view.inverse() * views[a].world_from_view,
        {}};
    found.evidence.overlap = 0.5;
    found.evidence.rms = rms * coarser_spacing(surfaces[a], surfaces[b]);
    return found;
  };
  const auto limits = [&](const std::vector<PoseLink>& links, int loops) {
    return fit_link_limits(surfaces, links, std::vector<int>(links.size(), loops), {});
  };
  const std::vector<PoseLink> links = {link(0, 1, 0.2), link(1, 2, 0.2), link(2, 3, 0.2),
                                       link(3, 4, 0.2), link(0, 2, 0.6), link(1, 3, 0.6)};
  const double largest = relative_rms(links[4].evidence, surfaces[0], surfaces[2]);
  const LinkLimits several = limits(links, 2), one = limits(links, 1);
  EXPECT_EQ(one.loop_confirmed.max_rms, one.confirmed.max_rms);
  EXPECT_EQ(several.confirmed.max_rms, one.confirmed.max_rms);
  EXPECT_LT(several.confirmed.max_rms, 0.9 * largest);
  EXPECT_NEAR(several.loop_confirmed.max_rms, largest, 0.1 * largest);
  // Loops that close at two places tell nothing.
  const std::vector<PoseLink> twice = {link(0, 1, 0.2), link(1, 2, 0.2), link(2, 3, 0.2),
                                       link(3, 4, 0.2), link(0, 2, 0.6), link(0, 2, 0.6, 1.0)};
  EXPECT_EQ(limits(twice, 2).loop_confirmed.max_rms, limits(twice, 2).confirmed.max_rms);
}

TEST(PoseEvidence, MeasuresCoherentMisfitsByTheSizeOfViewsWhoseSamplesAreFine) {
  const auto views = testing::ring_of_views({.views = 2, .pixels = 100});
  const auto fine_views = testing::ring_of_views({.views = 2, .pixels = 400});
  const auto coarse = surfaces_of(views), fine = surfaces_of(fine_views);
  EXPECT_EQ(coherence_scale(coarse[0], coarse[1]), coarser_spacing(coarse[0], coarse[1]));
  const double radius = std::min(fine[0].radius(), fine[1].radius());
  EXPECT_EQ(coherence_scale(fine[0], fine[1]), 0.01 * radius);
  EXPECT_GT(coherence_scale(fine[0], fine[1]), coarser_spacing(fine[0], fine[1]));
}

TEST(ViewGroups, OffPlaneSamplesAllowLargerErrorsThatNeighboursShare) {
  const auto views = two_neighbours();
  LinkedPair pair = linked_pair(views);
  pair.link.evidence.coherent_rms =
      0.5 * pair.surfaces[0].spacing();  // More than a link alone may have.
  const auto joined = [&](bool off_plane_confirmed) {
    pair.link.off_plane_confirmed = off_plane_confirmed;
    JudgedPairs judged(pair.surfaces);
    return join_views(pair.surfaces, {pair.link}, ViewGroups::singles(2), {false, false}, {},
                      judged)
        .all_in_one();
  };
  EXPECT_FALSE(joined(false));
  EXPECT_TRUE(joined(true));
}

}  // namespace
}  // namespace relief::registration
