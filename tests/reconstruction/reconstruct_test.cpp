#include "relief/reconstruction/reconstruct.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/simulation/simulate.h"
#include "tests/support/result_matchers.h"
#include "tests/support/sanitizers.h"

namespace relief::reconstruction {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<RangeView>& scans() {
  static const std::vector<RangeView> views = [] {
    simulation::SimulationOptions options;
    options.views = 8;
    options.width = options.height = 96;
    options.mesh_divisions = 0;
    return simulation::simulate(options).value().scans.views;
  }();
  return views;
}

const Reconstruction& reconstruction() {
  static const Reconstruction result = reconstruct(scans()).value();
  return result;
}

TEST(Reconstruct, GivesOneClosedModelOfAllViews) {
  EXPECT_TRUE(reconstruction().complete());
  EXPECT_EQ(reconstruction().views.size(), scans().size());
  EXPECT_TRUE(reconstruction().model.check.watertight());
  EXPECT_EQ(reconstruction().model.check.components, 1u);
  EXPECT_EQ(reconstruction().model.check.faces, reconstruction().model.mesh.faces.size());
}

TEST(Reconstruct, ReportsEveryStage) {
  EXPECT_EQ(reconstruction().first_alignment.views.size(), scans().size());
  EXPECT_EQ(reconstruction().consistency.size(), scans().size());
  EXPECT_EQ(reconstruction().refinements.size(), scans().size());
  ASSERT_TRUE(reconstruction().second_alignment);
  EXPECT_GT(reconstruction().second_alignment->gain.first_pose_std, 0.0);
  ASSERT_TRUE(reconstruction().model.polished);
  EXPECT_EQ(reconstruction().model.polished->status, hybrid::PolishStatus::kPolished);
}

TEST(Reconstruct, SaysWhyMoreFacesAreLeftThanWereWanted) {
  ModelOptions options;
  options.polish.reset();
  options.merge.voxel_size = 3.0;
  options.decimation = {.faces = 4, .max_error = 0.01};
  const Model model = value_of(build_model(reconstruction().views, options));
  const std::string left = std::to_string(model.mesh.faces.size());
  EXPECT_THAT(model.merged.notes,
              Contains(HasSubstr("4 faces were wanted and " + left + " are left")));
  options.decimation = {.faces = 2000};
  EXPECT_THAT(value_of(build_model(reconstruction().views, options)).merged.notes,
              Not(Contains(HasSubstr("faces were wanted"))));
}

TEST(Reconstruct, IsTheSameOnAnyNumberOfThreads) {
  ASSERT_FALSE(reconstruction().model.mesh.faces.empty());  // On all cores.
  if (testing::looks_for_races()) return;                   // One thread has none.
  const Reconstruction again = reconstruct(scans(), {}, {.threads = 1}).value();
  EXPECT_EQ(again.model.mesh.vertices, reconstruction().model.mesh.vertices);
  EXPECT_EQ(again.model.mesh.faces, reconstruction().model.mesh.faces);
}

TEST(Reconstruct, TellsOfTheStagesInOrder) {
  std::vector<std::string> told;
  ReconstructionCallbacks callbacks;
  callbacks.aligned = [&](const registration::Alignment&) {
    told.push_back("aligned");
    return Result<void>{};
  };
  callbacks.calibrated = [&](const registration::SensorCalibration&,
                             const std::vector<RangeView>& views) {
    EXPECT_EQ(views.size(), scans().size());
    told.push_back("calibrated");
    return Result<void>{};
  };
  callbacks.compared = [&](const std::vector<ViewConsistency>& consistency,
                           const std::vector<RangeView>& views) {
    EXPECT_EQ(consistency.size(), views.size());
    told.push_back("compared");
    return Result<void>{};
  };
  callbacks.refined = [&](const std::vector<hybrid::RefineSummary>& refinements,
                          const std::vector<RangeView>& views) {
    EXPECT_EQ(refinements.size(), views.size());
    told.push_back("refined");
    return Result<void>{};
  };
  callbacks.aligned_again = [&](const SecondAlignment&) {
    told.push_back("aligned again");
    return Result<void>{};
  };
  callbacks.views_finished = [&](const std::vector<RangeView>&) {
    told.push_back("views finished");
    return Result<void>{Error{ErrorKind::kCannotWrite, "no room"}};
  };
  const auto result = reconstruct(scans(), {}, {}, callbacks);
  EXPECT_THAT(told, ElementsAre("aligned", "calibrated", "compared", "refined", "aligned again",
                                "views finished"));
  ASSERT_THAT(result, HasError());
  EXPECT_EQ(result.error().message, "no room");
}

TEST(Reconstruct, StopsInEveryStage) {
  for (const Stage last :
       {Stage::kAlign, Stage::kCalibrate, Stage::kCompare, Stage::kRefine, Stage::kMerge}) {
    ReconstructionCallbacks callbacks;
    callbacks.progress = [last](Stage stage, double, std::string_view) { return stage < last; };
    EXPECT_THAT(reconstruct(scans(), {}, {}, callbacks), HasError(ErrorKind::kInterrupted))
        << to_string(last);
  }
}

TEST(Reconstruct, NeedsViews) { EXPECT_THAT(reconstruct({}), HasError(ErrorKind::kBadInput)); }

}  // namespace
}  // namespace relief::reconstruction
