// The steps of `run` as commands, and their plan: the bytes of `run` in any order.
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace relief {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::files_below;
using ::testing::HasSubstr;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::run_relief_until;
using testing::TemporaryFolder;

using Words = std::vector<std::string>;

class Steps : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const ProgramRun simulated =
        run_relief({"simulate", "-q", "--views", "5", "--width", "72", "--height", "72",
                    "--mesh-divisions", "0", "-o", *folder_ / "scans"});
    ASSERT_EQ(simulated.exit_status, 0) << simulated.standard_error;
    const ProgramRun whole =
        run_relief({"run", scan(), "-o", whole_run(), "--no-html-report", "--cache-limit", "0"});
    ASSERT_EQ(whole.exit_status, 0) << whole.standard_error;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static fs::path scan() { return *folder_ / "scans/scan.json"; }
  static fs::path whole_run() { return *folder_ / "whole"; }

  ProgramRun step(const Words& words, const Words& further = {}) const {
    Words arguments{"step", words.front(), scan()};
    arguments.insert(arguments.end(), words.begin() + 1, words.end());
    arguments.insert(arguments.end(), {"-o", out_ / "run", "--no-html-report"});
    arguments.insert(arguments.end(), further.begin(), further.end());
    return run_relief(arguments);
  }
  void do_step(const Words& words, const Words& further = {}) const {
    const ProgramRun done = step(words, further);
    EXPECT_EQ(done.exit_status, 0) << words.front() << "\n" << done.standard_error;
  }
  void require_step(const Words& words) const { do_step(words, {"--require-inputs"}); }

  std::map<std::string, std::string> planned_states() const {
    const ProgramRun plan =
        run_relief({"plan", scan(), "-o", out_ / "run", "--json", "-q", "--blocks", "2"});
    EXPECT_EQ(plan.exit_status, 0) << plan.standard_error;
    std::map<std::string, std::string> states;
    const json planned = json::parse(plan.standard_output);
    for (const json& step : planned["steps"])
      states[step["name"]] = step.contains("depends_on")
                                 ? "depends on " + step["depends_on"].get<std::string>()
                                 : step["state"].get<std::string>();
    return states;
  }

  // All but the report, which contains times.
  void expect_bytes_of_whole_run() const {
    for (const std::string& file : files_below(whole_run())) {
      if (file == "report.json" || file.rfind(".relief", 0) == 0) continue;
      EXPECT_EQ(read_text(out_ / "run" / file), read_text(whole_run() / file)) << file;
    }
  }

  static inline TemporaryFolder* folder_ = nullptr;
  const TemporaryFolder out_;
};

TEST_F(Steps, OneAfterTheOtherGiveTheBytesOfRun) {
  for (const Words& words : std::vector<Words>{{"pairs", "--block", "2/2"},
                                               {"align"},
                                               {"calibrate"},
                                               {"compare"},
                                               {"refine", "--block", "2/2"},
                                               {"refine", "v001"},
                                               {"refine", "--views", "0..1"},
                                               {"align-again"},
                                               {"merge"},
                                               {"polish"},
                                               {"finish"}})
    require_step(words);
  expect_bytes_of_whole_run();
  const json cache = json::parse(read_text(out_ / "run/report.json"))["run"]["cache"];
  for (const auto& [kind, counts] : cache.items()) EXPECT_EQ(counts["computed"], 0) << kind;
}

TEST_F(Steps, InAnyOrderGiveTheBytesOfRun) {
  do_step({"refine", "3"});
  do_step({"merge"}, {"--threads", "1"});
  do_step({"align"});
  require_step({"compare"});
  do_step({"refine"});
  const ProgramRun run = run_relief({"run", scan(), "-o", out_ / "run", "--no-html-report"});
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_THAT(run.standard_error, HasSubstr("5 of 5 refined views from an earlier run"));
  expect_bytes_of_whole_run();
}

TEST_F(Steps, OfOneUnitAtTheSameTimeDoNoHarm) {
  do_step({"compare"});
  std::vector<std::thread> others;
  for (const Words& words :
       std::vector<Words>{{"refine"}, {"refine"}, {"refine", "--block", "1/2"}, {"align-again"}})
    others.emplace_back([this, words] { do_step(words); });
  for (std::thread& other : others) other.join();
  require_step({"align-again"});
  do_step({"finish"});
  expect_bytes_of_whole_run();
}

TEST_F(Steps, NameTheStepWhoseResultsAreMissing) {
  const ProgramRun first = step({"refine"}, {"--require-inputs"});
  EXPECT_EQ(first.exit_status, 2);
  EXPECT_THAT(first.standard_error, HasSubstr("step align comes first"));
  do_step({"compare"});
  do_step({"refine", "0"});
  const ProgramRun second = step({"merge"}, {"--require-inputs"});
  EXPECT_EQ(second.exit_status, 2);
  EXPECT_THAT(second.standard_error, HasSubstr("view v001: step refine comes first"));
  const ProgramRun last = step({"finish"}, {"--require-inputs"});
  EXPECT_EQ(last.exit_status, 2);
  EXPECT_THAT(last.standard_error, HasSubstr("step refine comes first"));
  // Of other options nothing is there.
  EXPECT_THAT(step({"refine"}, {"--require-inputs", "--correspondences", "500"}).standard_error,
              HasSubstr("step align comes first"));
}

TEST_F(Steps, KeepRunsOutAndAreKeptOutByThem) {
  const fs::path out = out_ / "run";
  const auto started = [&] { return fs::exists(out / ".relief/lock"); };
  ProgramRun second, other_step;
  run_relief_until(
      [&] {
        if (!started()) return false;
        second = run_relief({"run", scan(), "-o", out, "--no-html-report"});
        other_step = step({"align"});
        return true;
      },
      {"step", "align", scan(), "-o", out, "--threads", "1"});
  // The step may have ended before; both then do what they are asked for.
  if (second.exit_status != 0) {
    EXPECT_EQ(second.exit_status, 2);
    EXPECT_THAT(second.standard_error, HasSubstr("steps work in this folder"));
  }
  EXPECT_EQ(other_step.exit_status, 0) << other_step.standard_error;
  ProgramRun kept_out;
  const ProgramRun run = run_relief_until(
      [&] {
        if (read_text(out / ".relief/lock").find("UTC") == std::string::npos ||
            read_text(out / ".relief/lock").rfind("step", 0) == 0)
          return false;
        kept_out = step({"align"});
        return true;
      },
      {"run", scan(), "-o", out, "--no-html-report", "--fresh", "--threads", "1"});
  EXPECT_EQ(run.exit_status, 128 + SIGKILL);
  EXPECT_EQ(kept_out.exit_status, 2);
  EXPECT_THAT(kept_out.standard_error, HasSubstr("a run works in this folder already (process "));
}

TEST_F(Steps, SayWhatIsWrongWithTheirArguments) {
  EXPECT_EQ(step({"sharpen"}).exit_status, 2);
  EXPECT_THAT(step({"merge", "v001"}).standard_error, HasSubstr("only refine takes VIEW"));
  EXPECT_THAT(step({"pairs", "v001"}).standard_error, HasSubstr("only refine takes VIEW"));
  EXPECT_THAT(step({"pairs", "--block", "3/2"}).standard_error, HasSubstr("--block 3/2"));
  EXPECT_THAT(step({"refine", "v999"}).standard_error, HasSubstr("the project has 5 views"));
  EXPECT_THAT(step({"refine", "--views", "3..5"}).standard_error, HasSubstr("indices from 0"));
  EXPECT_THAT(step({"refine", "--block", "0/2"}).standard_error, HasSubstr("--block 0/2"));
  EXPECT_THAT(step({"align"}, {"--cache-limit", "0"}).standard_error,
              HasSubstr("leave out --cache-limit 0"));
  EXPECT_FALSE(fs::exists(out_ / "run/.relief/cache"));
}

TEST_F(Steps, EndWithAnErrorWhereTheirResultsFindNoRoom) {
  do_step({"compare"});
  const ProgramRun full =
      run_relief({"step", "refine", scan(), "-o", out_ / "run"}, {.file_size_bytes = 10'000});
  EXPECT_EQ(full.exit_status, 2);
  EXPECT_THAT(full.standard_error, HasSubstr("could not be kept for the steps that need them"));
  do_step({"refine"});
  require_step({"align-again"});
}

TEST_F(Steps, ArePlannedWithWhatIsThere) {
  EXPECT_EQ(planned_states()["align"], "missing");
  EXPECT_FALSE(fs::exists(out_ / "run"));
  EXPECT_EQ(planned_states()["finish"], "depends on align");
  do_step({"compare"});
  do_step({"refine", "--block", "2/2"});
  auto states = planned_states();
  EXPECT_EQ(states["align"], "done");
  EXPECT_EQ(states["refine-1"], "missing");
  EXPECT_EQ(states["refine-2"], "done");
  EXPECT_EQ(states["merge"], "depends on refine");
  do_step({"merge"});
  states = planned_states();
  EXPECT_EQ(states["merge"], "done");
  EXPECT_EQ(states["polish"], "missing");
  do_step({"polish"});
  EXPECT_EQ(planned_states()["polish"], "done");
}

TEST_F(Steps, ArePlannedWithBlocksOfPairsWherePosesAreMissing) {
  const Words ignore{"--poses", "ignore"};
  const auto planned = [&] {
    const ProgramRun plan = run_relief({"plan", scan(), "-o", out_ / "run", "--json", "-q",
                                        "--poses", "ignore", "--pair-blocks", "2"});
    EXPECT_EQ(plan.exit_status, 0) << plan.standard_error;
    return json::parse(plan.standard_output)["steps"];
  };
  json steps = planned();
  EXPECT_EQ(steps[0]["name"], "pairs-1");
  EXPECT_EQ(steps[1]["arguments"], json({"--block", "2/2"}));
  EXPECT_EQ(steps[1]["state"], "missing");
  EXPECT_EQ(steps[2]["name"], "align");
  EXPECT_EQ(steps[2]["after"], json({"pairs-1", "pairs-2"}));
  do_step({"pairs", "--block", "2/2"}, ignore);
  steps = planned();
  EXPECT_EQ(steps[0]["state"], "missing");
  EXPECT_EQ(steps[1]["state"], "done");
  do_step({"align"}, ignore);
  EXPECT_EQ(planned()[0]["state"], "done");
  EXPECT_EQ(planned_states().count("pairs-1"), 0);
}

TEST_F(Steps, IntegrateTheFieldInBricksAheadOfMerging) {
  const auto states = [&] {
    const ProgramRun plan =
        run_relief({"plan", scan(), "-o", out_ / "run", "--json", "-q", "--bricks", "2"});
    EXPECT_EQ(plan.exit_status, 0) << plan.standard_error;
    std::map<std::string, json> steps;
    const json planned = json::parse(plan.standard_output);
    for (const json& step : planned["steps"]) steps[step["name"]] = step;
    return steps;
  };
  do_step({"align-again"});
  auto steps = states();
  EXPECT_EQ(steps["coarse-field"]["after"], json({"align-again"}));
  EXPECT_EQ(steps["field-2"]["after"], json({"coarse-field"}));
  EXPECT_EQ(steps["field-2"]["arguments"], json({"--block", "2/2"}));
  EXPECT_EQ(steps["merge"]["after"], json({"coarse-field", "field-1", "field-2"}));
  EXPECT_EQ(steps["coarse-field"]["state"], "missing");
  require_step({"coarse-field"});
  require_step({"field", "--block", "2/2"});
  steps = states();
  EXPECT_EQ(steps["coarse-field"]["state"], "done");
  EXPECT_EQ(steps["field-1"]["state"], "missing");
  EXPECT_EQ(steps["field-2"]["state"], "done");
  require_step({"field", "--block", "1/2"});
  do_step({"finish"});
  expect_bytes_of_whole_run();
  EXPECT_EQ(states()["field-1"]["state"], "done");
  const ProgramRun wrong = step({"field", "--views", "0..1"});
  EXPECT_EQ(wrong.exit_status, 2);
  EXPECT_THAT(wrong.standard_error, HasSubstr("only refine, pairs and field take --block"));
}

TEST_F(Steps, ArePlannedWithCostsAndTheBuildTheyNeed) {
  const ProgramRun plan = run_relief(
      {"plan", scan(), "-o", out_ / "run", "-q", "--calibration", "off", "--no-polish", "--json"});
  ASSERT_EQ(plan.exit_status, 0) << plan.standard_error;
  const json planned = json::parse(plan.standard_output);
  EXPECT_EQ(planned["program"],
            json::parse(read_text(whole_run() / "report.json"))["run"]["program"]);
  Words names;
  for (const json& step : planned["steps"]) {
    names.push_back(step["step"]);
    EXPECT_GT(step["cpu_seconds"], 0.0);
    EXPECT_GT(step["memory_mb"], 10.0);
  }
  EXPECT_EQ(names.front(), "align");
  EXPECT_EQ(names[1], "compare");
  EXPECT_EQ(names.back(), "finish");
  EXPECT_EQ(planned["steps"].back()["after"], json({"merge"}));
  const ProgramRun table = run_relief({"plan", scan(), "-o", out_ / "run", "-q"});
  EXPECT_THAT(table.standard_output, HasSubstr(planned["program"].get<std::string>()));
  EXPECT_THAT(table.standard_output, HasSubstr("depends on align"));
}

}  // namespace
}  // namespace relief
