#include "relief/reconstruction/reconstruct_part.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/simulation/simulate.h"
#include "scan/units/input_hash.h"
#include "tests/support/memory_store.h"
#include "tests/support/result_matchers.h"

namespace relief::reconstruction {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MemoryStore;
using ::testing::Pair;

constexpr Stage kAllStages[] = {Stage::kAlign,  Stage::kCalibrate,  Stage::kCompare,
                                Stage::kRefine, Stage::kAlignAgain, Stage::kMerge,
                                Stage::kPolish};

const std::vector<RangeView>& few_scans() {
  static const std::vector<RangeView> views = [] {
    simulation::SimulationOptions options;
    options.views = 6;
    options.width = options.height = 80;
    options.mesh_divisions = 0;
    return simulation::simulate(options).value().scans.views;
  }();
  return views;
}

std::string model_of(const Reconstruction& result) {
  ContentHash hash;
  hash.add(result.model.mesh);
  for (const RangeView& view : result.views) hash.add(hash_of_view(view));
  return hash.hex();
}

const std::string& whole_model() {
  static const std::string model = model_of(reconstruct(few_scans()).value());
  return model;
}

Result<Reconstruction> part_with(MemoryStore& store, const ReconstructionPart& part) {
  return reconstruct_part(few_scans(), part, {}, {.store = &store});
}

TEST(ReconstructPart, EachComputesItsOwnStageAlone) {
  MemoryStore store;
  for (const Stage stage : kAllStages) {
    store.start_again();
    ASSERT_THAT(part_with(store, {.last = stage, .find_former = true}), IsOk());
    if (stage == Stage::kRefine) {
      EXPECT_THAT(store.computed, ElementsAre(Pair("refine", 6)));
    }
    if (stage == Stage::kPolish) {
      EXPECT_THAT(store.computed, ElementsAre(Pair("polish", 1)));
    }
  }
  store.start_again();
  const auto all = part_with(store, {.find_former = true, .find_last = true});
  EXPECT_EQ(model_of(value_of(all)), whole_model());
  EXPECT_THAT(store.computed, IsEmpty());
}

TEST(ReconstructPart, ComputesWhatIsMissingBeforeIt) {
  MemoryStore store;
  ASSERT_THAT(part_with(store, {.last = Stage::kMerge}), IsOk());
  EXPECT_EQ(store.computed["refine"], 6);
  EXPECT_EQ(store.computed["merge"], 1);
  EXPECT_EQ(store.computed["polish"], 0);
  EXPECT_EQ(model_of(value_of(part_with(store, {}))), whole_model());
}

TEST(ReconstructPart, RefinesTheViewsThatItIsGiven) {
  MemoryStore store;
  const auto two = part_with(store, {.last = Stage::kRefine, .refined_views = {{4, 1}}});
  ASSERT_THAT(two, IsOk());
  EXPECT_EQ(two->views.size(), 2u);
  EXPECT_EQ(two->views.front().name, few_scans()[1].name);
  EXPECT_EQ(two->refinements.size(), 2u);
  EXPECT_EQ(store.computed["refine"], 2);
  ASSERT_THAT(part_with(store, {.last = Stage::kRefine, .refined_views = {{0, 2, 3, 5}}}), IsOk());
  EXPECT_EQ(store.computed["refine"], 6);
  EXPECT_THAT(part_with(store, {.last = Stage::kAlignAgain, .find_former = true}), IsOk());
}

TEST(ReconstructPart, NamesTheStepWhoseUnitsAreMissing) {
  MemoryStore store;
  EXPECT_THAT(part_with(store, {.last = Stage::kRefine, .find_former = true}),
              HasError(ErrorKind::kBadInput, "step align comes first"));
  ASSERT_THAT(part_with(store, {.last = Stage::kRefine, .refined_views = {{0}}}), IsOk());
  EXPECT_THAT(
      part_with(store, {.last = Stage::kMerge, .find_former = true}),
      HasError(ErrorKind::kBadInput, "view " + few_scans()[1].name, "step refine comes first"));
  EXPECT_THAT(part_with(store, {.last = Stage::kRefine, .find_former = true}), IsOk());
  EXPECT_THAT(part_with(store, {.last = Stage::kMerge, .find_former = true}),
              HasError(ErrorKind::kBadInput, "step align-again comes first"));
  EXPECT_THAT(
      part_with(store, {.last = Stage::kAlignAgain, .find_former = true, .find_last = true}),
      HasError(ErrorKind::kBadInput, "step align-again comes first"));
}

TEST(ReconstructPart, FindsNothingWithoutAStore) {
  EXPECT_THAT(reconstruct_part(few_scans(), {.last = Stage::kRefine, .find_former = true}),
              HasError(ErrorKind::kBadInput, "step align comes first"));
}

}  // namespace
}  // namespace relief::reconstruction
