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

TEST(ReconstructPart, SearchesPairsInBlocksAheadOfAligning) {
  std::vector<RangeView> views = few_scans();
  for (RangeView& view : views) view.pose = PoseKind::kAbsent;
  const ReconstructionOptions options;
  MemoryStore alone, blocks;
  const auto align = [&](MemoryStore& store) {
    store.start_again();
    return value_of(reconstruct_part(views, {.last = Stage::kAlign}, options, {.store = &store}));
  };
  const Reconstruction expected = align(alone);
  std::vector<int> searched;
  for (std::size_t b = 0; b < 3; ++b) {
    blocks.start_again();
    const ReconstructionPart part{.last = Stage::kAlign,
                                  .searched_pairs = registration::PairBlock{2 - b, 3}};
    ASSERT_THAT(reconstruct_part(views, part, options, {.store = &blocks}), IsOk());
    EXPECT_EQ(blocks.computed["align"], 0);
    searched.push_back(blocks.computed["pair"]);
    // The same again is there.
    blocks.start_again();
    ReconstructionPart again = part;
    again.find_last = true;
    EXPECT_THAT(reconstruct_part(views, again, options, {.store = &blocks}), IsOk());
    EXPECT_EQ(blocks.computed["pair"], 0);
  }
  // Two pairs a view come first.
  EXPECT_THAT(searched, ElementsAre(4, 4, 4));
  const Reconstruction found = align(blocks);
  EXPECT_EQ(blocks.found["pair"], 12);
  EXPECT_EQ(blocks.computed["pair"], alone.computed["pair"] - 12);
  EXPECT_EQ(blocks.computed["symmetry"], 0);
  for (std::size_t i = 0; i < views.size(); ++i)
    EXPECT_EQ(found.first_alignment.views[i].world_from_view.matrix(),
              expected.first_alignment.views[i].world_from_view.matrix());
}

TEST(ReconstructPart, SearchesNoPairsWherePosesHold) {
  MemoryStore store;
  ASSERT_THAT(
      part_with(store, {.last = Stage::kAlign, .searched_pairs = registration::PairBlock{0, 2}}),
      IsOk());
  EXPECT_EQ(store.computed["pair"], 0);
  EXPECT_EQ(store.computed["pairs"], 1);
  const auto none =
      part_with(store, {.last = Stage::kAlign, .searched_pairs = registration::PairBlock{2, 2}});
  EXPECT_THAT(none, HasError("there is no such block of pairs"));
}

TEST(ReconstructPart, IntegratesTheFieldInBricksAheadOfMerging) {
  const ReconstructionOptions options{
      .model = {.merge = {.voxel_size = 0.33 * sample_spacing(few_scans().front())}}};
  MemoryStore alone, bricks;
  const ReconstructionPart merged{.last = Stage::kMerge};
  const auto whole = reconstruct_part(few_scans(), merged, options, {.store = &alone});
  const auto part_of_field = [&](const fusion::FieldPart& part) {
    bricks.start_again();
    return reconstruct_part(few_scans(), {.last = Stage::kMerge, .field = part}, options,
                            {.store = &bricks});
  };
  ASSERT_THAT(part_of_field({}), IsOk());
  EXPECT_EQ(bricks.computed["field"], alone.computed["field"]);
  EXPECT_EQ(bricks.computed["field_group"], 0);
  int groups = 0;
  for (const std::size_t brick : {1, 0}) {
    ASSERT_THAT(part_of_field({brick, 2}), IsOk());
    EXPECT_EQ(bricks.computed["field"], 0);
    EXPECT_GT(bricks.computed["field_group"], 0);
    groups += bricks.computed["field_group"];
  }
  bricks.start_again();
  const auto found = reconstruct_part(few_scans(), merged, options, {.store = &bricks});
  EXPECT_EQ(bricks.found["field_group"], groups);
  EXPECT_EQ(model_of(value_of(found)), model_of(value_of(whole)));
  EXPECT_THAT(part_of_field({2, 2}), HasError("there is no such brick of the field"));
}

TEST(ReconstructPart, FindsNothingWithoutAStore) {
  EXPECT_THAT(reconstruct_part(few_scans(), {.last = Stage::kRefine, .find_former = true}),
              HasError(ErrorKind::kBadInput, "step align comes first"));
}

}  // namespace
}  // namespace relief::reconstruction
