#include <cstring>

#include <gtest/gtest.h>

#include "hybrid/refine_memory.h"
#include "relief/hybrid/refine_view.h"
#include "relief/scan/context.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

constexpr int kSize = 64;

std::vector<RangeView> noisy_views(int count) {
  std::vector<RangeView> views;
  for (int i = 0; i < count; ++i) {
    const auto seed = static_cast<std::uint32_t>(i);
    RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(kSize, kSize));
    testing::add_range_noise(view, 0.3, 2 * seed + 1);
    testing::add_normal_noise(view, 0.02, 2 * seed + 2);
    view.name = "v" + std::to_string(i);
    views.push_back(std::move(view));
  }
  return views;
}

bool same_ranges(const RangeView& a, const RangeView& b) {
  return a.range.size() == b.range.size() && std::memcmp(&*a.range.begin(), &*b.range.begin(),
                                                         a.range.size() * sizeof(a.range[0])) == 0;
}

TEST(RefineViews, AreAsManyAtOnceAsThreadsAndMemoryAllow) {
  const std::vector<RangeView> views = noisy_views(3);
  const auto at_once_on = [&](int threads) {
    return on_threads(threads, [&] { return views_at_once(views, {}); });
  };
  EXPECT_EQ(at_once_on(2), 2);
  EXPECT_EQ(at_once_on(8), 3);
  EXPECT_EQ(views_at_once(views, {}, 1), 1);
  EXPECT_EQ(views_at_once({}, {}), 1);
}

TEST(RefineViews, MaskedViewsNeedMemoryForTheirPartOnly) {
  RangeView masked = noisy_views(1)[0];
  const std::size_t whole = memory_to_refine(masked, Solver::kMultigrid);
  std::size_t kept = 0;
  for (int v = 0; v < kSize; ++v)
    for (int u = 0; u < kSize; ++u)
      if (u < 8 && v < 8)
        kept += masked.has_sample(u, v);
      else
        masked.range(u, v) = kNoSample;
  ASSERT_EQ(kept, 64);
  const std::size_t part = memory_to_refine(masked, Solver::kMultigrid);
  // 8 samples and a margin of 16 pixels: 24 of 64 columns and rows.
  EXPECT_NEAR(static_cast<double>(part), (100 * 24 * 24 + 300 * 64), 1.0);
  EXPECT_LT(part, whole / 10);
}

TEST(RefineViews, NeitherMemoryNorThreadsChangeAByte) {
  const std::vector<RangeView> views = noisy_views(3);
  const auto together = value_of(refine_views(views, {}, {.threads = 4}));
  const auto one_by_one = value_of(refine_views(views, {}, {.threads = 1, .memory = 1}));
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(together[i].view.name, views[i].name);
    EXPECT_TRUE(same_ranges(together[i].view, one_by_one[i].view)) << i;
  }
}

TEST(RefineViews, AViewThatCannotBeRefinedStaysAsMeasuredAmongTheOthers) {
  std::vector<RangeView> views = noisy_views(3);
  views[1].normals = {};
  const auto refined = value_of(refine_views(views));
  EXPECT_EQ(refined[0].status, RefineStatus::kRefined);
  EXPECT_EQ(refined[1].status, RefineStatus::kNoNormals);
  EXPECT_TRUE(same_ranges(refined[1].view, views[1]));
  EXPECT_EQ(refined[2].status, RefineStatus::kRefined);
}

TEST(RefineViews, StopOnRequest) {
  const auto stopped = refine_views(noisy_views(2), {},
                                    {.progress = [](double, std::string_view) { return false; }});
  EXPECT_THAT(stopped, HasError(ErrorKind::kInterrupted));
}

}  // namespace
}  // namespace relief::hybrid
