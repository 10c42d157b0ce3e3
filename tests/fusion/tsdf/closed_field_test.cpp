#include "fusion/tsdf/closed_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/scenes.h"
#include "tests/support/memory_store.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

using testing::MemoryStore;

// A sphere seen from one side: half of its surface is for the field to find.
std::vector<ViewSampler> half_a_sphere() {
  auto views = testing::views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 14, 60, 50.0);
  views.resize(3);
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views)
    samplers.push_back(std::move(ViewSampler::create(view, {})).value());
  return samplers;
}

TEST(ClosedField, IsSolvedToItsToleranceOrSaysThatItIsNot) {
  const auto views = half_a_sphere();
  ClosedFieldOptions options;
  options.voxel_size = 1.0;
  options.truncation = 3.0;
  const auto solved = value_of(compute_closed_field(views, options, {}));
  EXPECT_EQ(solved.moving_blocks, 0u);
  options.max_sweeps = 10;
  const auto cut_short = value_of(compute_closed_field(views, options, {}));
  EXPECT_GT(cut_short.moving_blocks, 0u);
}

class KeptLevels : public ::testing::Test {
 protected:
  Result<ClosedField> compute(UnitStore* store, const Progress& progress = {}) {
    ClosedFieldOptions options;
    options.voxel_size = 1.0;
    options.truncation = 3.0;
    options.max_sweeps = 30;
    options.units = FieldUnits(store, "half a sphere");
    return compute_closed_field(views_, options, progress);
  }

  void expect_same(const ClosedField& a, const ClosedField& b) {
    EXPECT_EQ(a.moving_blocks, b.moving_blocks);
    ASSERT_EQ(a.levels.size(), b.levels.size());
    for (std::size_t level = 0; level < a.levels.size(); ++level) {
      const SparseFieldBlocks first = a.levels[level]->blocks(), second = b.levels[level]->blocks();
      EXPECT_EQ(first.keys, second.keys);
      EXPECT_EQ(first.active, second.active);
      EXPECT_EQ(first.values, second.values);
    }
  }

  const std::vector<ViewSampler> views_ = half_a_sphere();
  const ClosedField without_store_ = value_of(compute(nullptr));
  const int coarser_ = static_cast<int>(without_store_.levels.size()) - 1;
};

TEST_F(KeptLevels, AreAllButTheFinestAndChangeNoValue) {
  MemoryStore store;
  expect_same(value_of(compute(&store)), without_store_);
  EXPECT_GE(coarser_, 2);
  EXPECT_EQ(store.computed["field"], coarser_);
  expect_same(value_of(compute(&store)), without_store_);
  EXPECT_EQ(store.found["field"], coarser_);
  EXPECT_EQ(store.computed["field"], coarser_);
}

TEST_F(KeptLevels, OutliveAnInterruption) {
  MemoryStore store;
  ASSERT_FALSE(compute(&store, [&](double, std::string_view) { return store.units.size() < 1; }));
  EXPECT_EQ(store.computed["field"], 1);
  expect_same(value_of(compute(&store)), without_store_);
  EXPECT_EQ(store.found["field"], 1);
  EXPECT_EQ(store.computed["field"], coarser_);
}

TEST_F(KeptLevels, AreComputedAgainWhereTheyAreDamaged) {
  MemoryStore store;
  ASSERT_TRUE(compute(&store));
  for (auto& [hash, content] : store.units) content.pop_back();
  expect_same(value_of(compute(&store)), without_store_);
  EXPECT_EQ(store.computed["field"], 2 * coarser_);
}

}  // namespace
}  // namespace relief::fusion
