// What `relief simulate` records and writes of the defects it is asked for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace relief {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::TemporaryFolder;

ProgramRun simulate(const TemporaryFolder& folder, std::vector<std::string> options) {
  std::vector<std::string> words = {"simulate",         "-q", "--views",  "2",
                                    "--width",          "64", "--height", "64",
                                    "--mesh-divisions", "8",  "-o",       folder.path().string()};
  words.insert(words.end(), options.begin(), options.end());
  return run_relief(words);
}

json truth_of(const TemporaryFolder& folder) {
  return json::parse(read_text(folder / "truth.json"));
}

TEST(Simulate, RecordsEveryDefect) {
  const TemporaryFolder scans;
  const ProgramRun run = simulate(scans, {"--background",
                                          "--background-tilt",
                                          "30",
                                          "--noise-half",
                                          "5",
                                          "--view-warp",
                                          "0.5",
                                          "--glare",
                                          "--glare-lamps",
                                          "3",
                                          "--outliers",
                                          "0.02",
                                          "--quantisation",
                                          "2",
                                          "--missing",
                                          "0.15",
                                          "--wrong-normals",
                                          "flip-y",
                                          "--undeclared-normals",
                                          "--focal-factor",
                                          "1.005",
                                          "--scale-factor",
                                          "0.99"});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  const json defects = truth_of(scans)["defects"];
  EXPECT_EQ(defects["background"]["tilt_deg"], 30.0);
  EXPECT_EQ(defects["background"]["distance"], 0.75);
  EXPECT_EQ(defects["noise_half"], 5.0);
  EXPECT_EQ(defects["view_warp"], 0.5);
  EXPECT_EQ(defects["glare"]["lamps"], 3);
  EXPECT_EQ(defects["outlier_fraction"], 0.02);
  EXPECT_EQ(defects["quantisation"], 2.0);
  EXPECT_EQ(defects["missing_fraction"], 0.15);
  EXPECT_EQ(defects["normal_mistake"], "flip-y");
  EXPECT_EQ(defects["undeclared_normals"], true);
  EXPECT_EQ(defects["focal_factor"], 1.005);
  EXPECT_EQ(defects["scale_factor"], 0.99);
  const json view = json::parse(read_text(scans / "scan.json"))["views"][0];
  EXPECT_FALSE(view["normals"].contains("axes"));
  EXPECT_FALSE(view["normals"].contains("space"));
}

TEST(Simulate, DefectsOfNoSizeLeaveTheBytesAsTheyAre) {
  const TemporaryFolder plain, zero;
  ASSERT_EQ(simulate(plain, {}).exit_status, 0);
  ASSERT_EQ(simulate(zero, {"--noise-half", "1", "--view-warp", "0", "--outliers", "0",
                            "--quantisation", "0", "--missing", "0", "--wrong-normals", "none",
                            "--focal-factor", "1", "--scale-factor", "1"})
                .exit_status,
            0);
  EXPECT_FALSE(truth_of(plain).contains("defects"));
  for (const char* file : {"truth.json", "scan.json", "v001_depth.tiff", "v001_normal.tiff"})
    EXPECT_EQ(read_text(plain / file), read_text(zero / file)) << file;
}

TEST(Simulate, KnowsDepthCameras) {
  const TemporaryFolder rgbd, flight;
  ASSERT_EQ(simulate(rgbd, {"--range-sensor", "rgbd"}).exit_status, 0);
  EXPECT_EQ(truth_of(rgbd)["range_sensor"]["disparity_step"], 0.125);
  ASSERT_EQ(simulate(flight, {"--range-sensor", "tof", "--multipath", "1.5"}).exit_status, 0);
  EXPECT_EQ(truth_of(flight)["range_sensor"]["model"], "time of flight");
  EXPECT_EQ(truth_of(flight)["range_sensor"]["multipath"], 1.5);
}

TEST(Simulate, RefusesParametersOfWhatIsNotThere) {
  const TemporaryFolder scans;
  const auto refused = [&](std::vector<std::string> options, const char* needs) {
    const ProgramRun run = simulate(scans, std::move(options));
    EXPECT_EQ(run.exit_status, 2);
    EXPECT_THAT(run.standard_error, HasSubstr(needs));
  };
  refused({"--background-tilt", "30"}, "--background");
  refused({"--glare-width", "3"}, "--glare");
  refused({"--multipath", "1"}, "--range-sensor tof");
  refused({"--rays", "line", "--undeclared-normals"}, "--rays pinhole");
  refused({"--rays", "line", "--focal-factor", "1.01"}, "pinhole");
  refused({"--missing", "1"}, "missing_fraction");
}

}  // namespace
}  // namespace relief
