// What programs around relief read of its progress.
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace relief {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::ProgramRun;
using testing::run_relief;
using testing::TemporaryFolder;

class RunOfTwoViews : public ::testing::Test {
 protected:
  ProgramRun run(std::vector<std::string> options) {
    options.insert(options.begin(),
                   {"run", scans_ / "scan.json", "--voxel", "6", "-o", out_.path().string()});
    return run_relief(options);
  }
  void SetUp() override {
    ASSERT_EQ(
        run_relief({"simulate", "-q", "--views", "4", "--width", "64", "--height", "64",
                    "--mesh-divisions", "0", "--poses", "exact", "-o", scans_.path().string()})
            .exit_status,
        0);
  }

 private:
  TemporaryFolder scans_, out_;
};

TEST_F(RunOfTwoViews, TellsItsProgressAsJson) {
  const ProgramRun told = run({"--progress", "json"});
  ASSERT_EQ(told.exit_status, 0) << told.standard_error;
  std::istringstream lines(told.standard_error);
  double before = 0.0, seconds = 0.0;
  std::vector<std::string> stages;
  bool model_written = false;
  for (std::string line; std::getline(lines, line);) {
    const json object = json::parse(line);  // Messages as well: nothing else is on standard error.
    if (object.contains("message")) {
      model_written |= object["message"].get<std::string>().find("model.ply") != std::string::npos;
      continue;
    }
    EXPECT_GE(object["seconds"].get<double>(), seconds);
    seconds = object["seconds"];
    for (const char* name : {"fraction", "stage_fraction"}) {
      EXPECT_GE(object[name].get<double>(), 0.0);
      EXPECT_LE(object[name].get<double>(), 1.0);
    }
    EXPECT_FALSE(object["step"].get<std::string>().empty());
    if (stages.empty() || stages.back() != object["stage"]) stages.push_back(object["stage"]);
    if (object["stage"] == "read") continue;  // The plan begins when the views are known.
    EXPECT_GE(object["fraction"].get<double>(), before);
    before = object["fraction"];
  }
  for (const char* stage : {"read", "align", "compare", "refine", "merge", "polish"})
    EXPECT_THAT(stages, Contains(stage));
  EXPECT_TRUE(model_written);
}

TEST_F(RunOfTwoViews, LinesTellTheStageAndItsTime) {
  const ProgramRun lines = run({"--progress", "lines", "-v"});
  ASSERT_EQ(lines.exit_status, 0) << lines.standard_error;
  EXPECT_THAT(lines.standard_error, HasSubstr(" % merge: "));
  EXPECT_THAT(lines.standard_error, HasSubstr("0:0"));
  const ProgramRun off = run({"--progress", "off"});
  EXPECT_THAT(off.standard_error, Not(HasSubstr(" % merge: ")));
}

TEST_F(RunOfTwoViews, TheBarEndsBeforeAMessage) {
  const ProgramRun bar = run({"--progress", "bar"});
  ASSERT_EQ(bar.exit_status, 0) << bar.standard_error;
  EXPECT_THAT(bar.standard_error, HasSubstr("\r["));
  EXPECT_THAT(bar.standard_error, HasSubstr("\nwrote "));
}

TEST_F(RunOfTwoViews, QuietMeansNoProgressEither) {
  EXPECT_EQ(run({"-q", "--progress", "json"}).standard_error, "");
}

TEST(Progress, UnknownFormatsAreWrongUsage) {
  const ProgramRun run = run_relief({"info", "--progress", "loud", "x"});
  EXPECT_NE(run.exit_status, 0);
  EXPECT_THAT(run.standard_error, HasSubstr("--progress"));
}

}  // namespace
}  // namespace relief
