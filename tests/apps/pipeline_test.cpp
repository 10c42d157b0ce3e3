// The whole way through the program on simulated scans.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace relief {
namespace {

using nlohmann::json;
using testing::files_below;
using ::testing::HasSubstr;
using testing::ProgramLimits;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::TemporaryFolder;
using testing::write_text;

json report_of(const std::filesystem::path& folder) {
  return json::parse(read_text(folder / "report.json"));
}

void simulate(const TemporaryFolder& folder, const std::string& views, const std::string& size,
              const std::string& threads = "0") {
  const ProgramRun run = run_relief({"simulate", "-q", "--views", views, "--width", size,
                                     "--height", size, "--seed", "3", "--mesh-divisions", "100",
                                     "--threads", threads, "-o", folder.path().string()});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
}

json evaluate(const std::string& result, const std::string& truth) {
  const ProgramRun run = run_relief({"evaluate", result, "--truth", truth, "--json", "-q"});
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  return json::parse(run.standard_output)["evaluate"];
}

TEST(Program, AnswersHelpAndVersion) {
  EXPECT_EQ(run_relief({"--version"}).exit_status, 0);
  const ProgramRun help = run_relief({"--help"});
  EXPECT_EQ(help.exit_status, 0);
  for (const char* command : {"info", "align", "refine", "merge", "run", "simulate", "evaluate",
                              "compare", "convert", "report"}) {
    EXPECT_THAT(help.standard_output, HasSubstr(command));
    EXPECT_EQ(run_relief({command, "--help"}).exit_status, 0) << command;
  }
}

// Simulated scans through `run`: closed, aligned, refined, and each stage nearer to the truth.
TEST(Program, RunsTheWholeWay) {
  const TemporaryFolder scans, out;
  simulate(scans, "8", "384");
  const ProgramRun run = run_relief({"run", scans / "scan.json", "-o", out.path().string()});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;

  const json report = report_of(out.path());
  EXPECT_TRUE(report["merge"]["watertight"]);
  EXPECT_TRUE(report["merge"]["manifold_edges"]);
  EXPECT_TRUE(report["merge"]["manifold_vertices"]);
  EXPECT_EQ(report["merge"]["boundary_edges"], 0);
  EXPECT_EQ(report["merge"]["components"], 1);
  EXPECT_GT(report["merge"]["volume"], 0.0);
  for (const json& view : report["align"]["views"]) EXPECT_TRUE(view["aligned"]);
  const json last_solve = report["align"]["solves"].back();
  EXPECT_EQ(last_solve["stage"], "pose graph");
  EXPECT_EQ(last_solve["termination"], "converged");
  EXPECT_LT(last_solve["final_cost"], last_solve["initial_cost"]);
  EXPECT_EQ(report["refine"]["views"].size(), 8u);

  const json raw = evaluate(scans / "scan.json", scans / "truth/scan.json");
  const json refined = evaluate(out / "scan.json", scans / "truth/scan.json");
  EXPECT_LT(refined["depth"]["rms"].get<double>(), 0.5 * raw["depth"]["rms"].get<double>());
  EXPECT_LT(refined["geometry_normals_deg"]["mean"].get<double>(),
            0.2 * raw["geometry_normals_deg"]["mean"].get<double>());
  EXPECT_LT(refined["poses"]["mean_displacement"].get<double>(),
            0.1 * raw["poses"]["mean_displacement"].get<double>());
  const json model = evaluate(out / "model.ply", scans / "truth/model.ply");
  EXPECT_LT(model["accuracy"]["rms"].get<double>(), refined["depth"]["rms"].get<double>());
  EXPECT_LT(model["completeness"]["rms"].get<double>(), refined["depth"]["rms"].get<double>());
}

// The mean displacement of the views at the poses of a section of the report.
double pose_error(const json& section, const TemporaryFolder& scans) {
  json project = json::parse(read_text(scans / "scan.json"));
  for (std::size_t i = 0; i < project["views"].size(); ++i)
    project["views"][i]["world_from_view"] = section["views"][i]["world_from_view"];
  std::ofstream(scans / "with_poses.json") << project.dump();
  return evaluate(scans / "with_poses.json",
                  scans / "truth/scan.json")["poses"]["mean_displacement"];
}

// Both errors have chance in them, so the second may be the larger one, but not by much.
TEST(Program, DoesNotLoseAccuracyByAligningAgain) {
  const TemporaryFolder scans, out;
  simulate(scans, "8", "192");
  const ProgramRun run = run_relief(
      {"run", scans / "scan.json", "--no-polish", "--voxel", "4", "-o", out.path().string()});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  const json report = report_of(out.path());
  const json gain = report["align_again"]["gain"];
  EXPECT_TRUE(gain["kept"]);
  EXPECT_LT(gain["pose_std"]["again"].get<double>(), gain["pose_std"]["first"].get<double>());
  EXPECT_LT(pose_error(report["align_again"], scans), 1.25 * pose_error(report["align"], scans));
}

TEST(Program, ComparesViewsUnlessToldNotTo) {
  const TemporaryFolder scans, corrected, weighed, kept;
  ASSERT_EQ(run_relief({"simulate", "-q", "--views", "12", "--width", "96", "--height", "96",
                        "--mesh-divisions", "0", "--poses", "exact", "-o", scans.path().string()})
                .exit_status,
            0);
  for (const auto& [out, choice] :
       {std::pair(&corrected, "correct"), std::pair(&weighed, "weigh"), std::pair(&kept, "keep")}) {
    const ProgramRun run = run_relief({"run", scans / "scan.json", "--no-polish", "--voxel", "4",
                                       "--contradicted", choice, "-o", out->path().string()});
    ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  }
  for (const TemporaryFolder* out : {&corrected, &weighed}) {
    const json views = report_of(out->path())["compare"]["views"];
    ASSERT_EQ(views.size(), 12u);
    for (const json& view : views) {
      EXPECT_GT(view["samples_compared"].get<int>(), 0);
      EXPECT_GT(view["deviation"].get<double>(), 0.0);
      EXPECT_LT(view["samples_contradicted"].get<int>(), view["samples_compared"].get<int>() / 2);
      EXPECT_LE(view["samples_corrected"].get<int>(), view["samples_contradicted"].get<int>());
    }
  }
  const json only_weighed = report_of(weighed.path());
  for (const json& view : only_weighed["compare"]["views"]) EXPECT_EQ(view["samples_corrected"], 0);
  EXPECT_FALSE(report_of(kept.path()).contains("compare"));
}

// Of each view's samples and of its starting pose: only the view that moved has another hash.
TEST(Program, RecordsTheHashesOfItsInputs) {
  const TemporaryFolder scans, out;
  simulate(scans, "4", "64");
  json project = json::parse(read_text(scans / "scan.json"));
  json& x = project["views"][1]["world_from_view"][0][3];
  x = x.get<double>() + 0.5;
  scans.write("moved.json", project.dump());
  const auto inputs = [&](const std::string& file, const std::string& background) {
    const ProgramRun run =
        run_relief({"run", scans / file, "--poses", "trust", "--no-polish", "--no-html-report",
                    "--background", background, "-o", out / background});
    EXPECT_EQ(run.exit_status, 0) << run.standard_error;
    return report_of(out / background)["run"]["inputs"];
  };
  const json first = inputs("scan.json", "auto"), second = inputs("moved.json", "keep");
  ASSERT_EQ(first.size(), 4u);
  ASSERT_EQ(second.size(), 4u);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i]["name"], project["views"][i]["name"]);
    EXPECT_EQ(first[i]["samples_sha256"], second[i]["samples_sha256"]) << i;
    EXPECT_EQ(first[i]["pose_sha256"] == second[i]["pose_sha256"], i != 1) << i;
    EXPECT_EQ(first[i]["samples_sha256"] == first[0]["samples_sha256"], i == 0) << i;
  }
}

TEST(Program, SimulatesTheSensorsItIsTold) {
  const TemporaryFolder scans, again;
  const auto simulated = [&](const TemporaryFolder& folder, std::vector<std::string> options) {
    options.insert(options.begin(), {"simulate", "-q", "--width", "64", "--height", "64",
                                     "--mesh-divisions", "0", "-o", folder.path().string()});
    return run_relief(options);
  };
  const ProgramRun run =
      simulated(scans, {"--views", "3", "--range-sensor", "laser-line", "--rays", "line",
                        "--normal-sensor", "photometric-stereo", "--warp", "0.7", "--lights", "6"});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  const json truth = json::parse(read_text(scans / "truth.json"));
  EXPECT_EQ(truth["range_sensor"]["model"], "triangulation");
  EXPECT_EQ(truth["range_sensor"]["warp"], 0.7);
  EXPECT_EQ(truth["range_sensor"]["baseline"], 0.5);
  EXPECT_EQ(truth["normal_sensor"]["lights"], 6);
  EXPECT_GT(truth["reflectance"]["dark_fraction"], 0.0);
  const json errors = evaluate(scans / "scan.json", scans / "truth/scan.json");
  EXPECT_LT(errors["depth"]["median"].get<double>(), truth["sample_spacing"].get<double>());

  // The same places once more, with other sensors.
  ASSERT_EQ(simulated(again, {"--poses-from", scans / "truth.json", "--range-sensor", "exact",
                              "--normal-sensor", "none"})
                .exit_status,
            0);
  const json there = json::parse(read_text(again / "truth.json"));
  ASSERT_EQ(there["views"].size(), 3u);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t row = 0; row < 3; ++row)
      EXPECT_NEAR(there["views"][i]["world_from_view"][row][3].get<double>(),
                  truth["views"][i]["world_from_view"][row][3].get<double>(), 1e-9);

  const ProgramRun wrong = simulated(again, {"--range-sensor", "white", "--warp", "1"});
  EXPECT_EQ(wrong.exit_status, 2);
  EXPECT_THAT(wrong.standard_error, HasSubstr("--warp"));
}

TEST(Program, SingleStepsGiveWhatRunGives) {
  const TemporaryFolder scans, out;
  simulate(scans, "6", "96");
  ASSERT_EQ(run_relief({"align", scans / "scan.json", "-o", out / "aligned.json"}).exit_status, 0);
  ASSERT_EQ(run_relief({"refine", out / "aligned.json", "-o", out / "refined"}).exit_status, 0);
  for (const char* model : {"model.ply", "model.obj", "model.stl", "model.vtp", "model.glb"}) {
    const ProgramRun run = run_relief({"merge", out / "refined/scan.json", "-o", out / model});
    EXPECT_EQ(run.exit_status, 0) << model << run.standard_error;
    EXPECT_GT(std::filesystem::file_size(out / model), 1000u);
  }
  EXPECT_EQ(run_relief({"info", out / "refined/scan.json"}).exit_status, 0);
  EXPECT_EQ(run_relief({"convert", out / "model.ply", "-o", out / "copy.stl"}).exit_status, 0);
  EXPECT_EQ(run_relief({"convert", out / "model.vtp", "-o", out / "copy.ply"}).exit_status, 0);
  const ProgramRun tiles = run_relief({"convert", out / "model.ply", "-o", out / "web/model.json"});
  EXPECT_EQ(tiles.exit_status, 0) << tiles.standard_error;
  EXPECT_TRUE(std::filesystem::exists(out / "web/model.json"));
  EXPECT_TRUE(std::filesystem::exists(out / "web/model_tiles/0.glb"));
  EXPECT_EQ(run_relief({"convert", scans / "scan.json", "-o", out / "views.ply"}).exit_status, 0);
  EXPECT_EQ(run_relief({"convert", scans / "scan.json", "-o", out / "copied"}).exit_status, 0);
  EXPECT_EQ(run_relief({"convert", scans / "scan.json", "-o", out / "clouds", "--pcd"}).exit_status,
            0);
  EXPECT_EQ(run_relief({"convert", out / "clouds/v000.pcd", "-o", out / "v.pcd"}).exit_status, 0);
  EXPECT_EQ(run_relief({"convert", scans / "scan.json", "-o", out / "all.pcd"}).exit_status, 2);
  EXPECT_EQ(run_relief({"convert", scans / "scan.json", "-o", out / "poses.tum"}).exit_status, 0);
  EXPECT_EQ(run_relief({"convert", out / "clouds/scan.json", "-o", out / "poses.aln"}).exit_status,
            0);
  const ProgramRun unknown = run_relief({"convert", scans / "scan.json", "-o", out / "poses.xyz"});
  EXPECT_EQ(unknown.exit_status, 2);
  EXPECT_THAT(unknown.standard_error, HasSubstr("unknown ending '.xyz'"));
  const ProgramRun views = run_relief({"convert", scans / "scan.json", "-o", out / "web.json"});
  EXPECT_EQ(views.exit_status, 2);
  EXPECT_THAT(views.standard_error, HasSubstr("tiles are cut from a mesh"));
}

TEST(Program, GivesTheSameBytesOnAnyNumberOfThreads) {
  const TemporaryFolder one_scans, two_scans, one, two;
  simulate(one_scans, "5", "96", "1");
  simulate(two_scans, "5", "96", "2");
  ASSERT_EQ(files_below(one_scans.path()), files_below(two_scans.path()));
  for (const std::string& file : files_below(one_scans.path())) {
    if (file != "report.json") {
      EXPECT_EQ(read_text(one_scans / file), read_text(two_scans / file)) << file;
    }
  }

  ASSERT_EQ(
      run_relief({"run", one_scans / "scan.json", "--threads", "1", "-o", one.path()}).exit_status,
      0);
  ASSERT_EQ(
      run_relief({"run", one_scans / "scan.json", "--threads", "3", "-o", two.path()}).exit_status,
      0);
  // Reports and kept results hold times.
  for (const std::string& file : files_below(one.path())) {
    if (file.find("report") == std::string::npos && file.rfind(".relief/", 0) != 0) {
      EXPECT_EQ(read_text(one / file), read_text(two / file)) << file;
    }
  }
}

TEST(Program, MergesWithinAMemoryLimitToTheSameBytes) {
  const TemporaryFolder scans, free, limited;
  simulate(scans, "5", "96");
  ASSERT_EQ(run_relief({"merge", scans / "scan.json", "-o", free / "model.ply"}).exit_status, 0);
  const ProgramRun run =
      run_relief({"merge", scans / "scan.json", "-o", limited / "model.ply", "--memory", "250"});
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_EQ(read_text(free / "model.ply"), read_text(limited / "model.ply"));

  const ProgramRun low =
      run_relief({"merge", scans / "scan.json", "-o", limited / "low.ply", "--memory", "1"});
  EXPECT_EQ(low.exit_status, 1);
  EXPECT_THAT(low.standard_error, HasSubstr("limit of 1 MiB"));
  EXPECT_FALSE(std::filesystem::exists(limited / "low.ply"));
}

TEST(Program, RunsWithinAMemoryLimitToTheSameBytes) {
  const TemporaryFolder scans, free, limited, low;
  simulate(scans, "5", "96");
  ASSERT_EQ(run_relief({"run", scans / "scan.json", "-o", free.path()}).exit_status, 0);
  const ProgramRun run =
      run_relief({"run", scans / "scan.json", "-o", limited.path(), "--memory", "250M"});
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_EQ(read_text(free / "model.ply"), read_text(limited / "model.ply"));
  EXPECT_EQ(read_text(free / "scan.json"), read_text(limited / "scan.json"));

  const ProgramRun refused =
      run_relief({"run", scans / "scan.json", "-o", low.path(), "--memory", "10M"});
  EXPECT_EQ(refused.exit_status, 1);
  EXPECT_THAT(refused.standard_error, HasSubstr("aligning and refining the views needs about"));
  EXPECT_THAT(refused.standard_error, HasSubstr("more than the memory limit of 10 MiB"));
  EXPECT_FALSE(std::filesystem::exists(low / "model.ply"));
}

TEST(Program, AlignsWithinAMemoryLimitToTheSameBytes) {
  const TemporaryFolder scans;
  simulate(scans, "4", "160");
  const auto align = [&](const std::string& output, const std::string& memory) {
    const ProgramRun run =
        run_relief({"align", scans / "scan.json", "-o", scans / output, "--memory", memory});
    EXPECT_EQ(run.exit_status, 0) << run.standard_error;
    return read_text(scans / output);
  };
  EXPECT_EQ(align("limited.json", "90M"), align("free.json", "0"));
}

// What a container with so much memory tells, in both versions of control groups.
void write_control_groups(const TemporaryFolder& folder, std::size_t mebibytes) {
  const std::string limit = std::to_string(mebibytes << 20);
  write_text(folder / "memory.max", limit);
  write_text(folder / "memory.current", "0");
  write_text(folder / "memory/memory.limit_in_bytes", limit);
  write_text(folder / "memory/memory.usage_in_bytes", "0");
}

TEST(Program, RunsWithinTheLimitOfItsControlGroupToTheSameBytes) {
  const TemporaryFolder scans, free, limited, low, groups;
  simulate(scans, "5", "96");
  ASSERT_EQ(run_relief({"run", scans / "scan.json", "-o", free.path()}).exit_status, 0);
  write_control_groups(groups, 250);
  const ProgramLimits limits{.control_groups = groups.path()};
  const ProgramRun run = run_relief({"run", scans / "scan.json", "-o", limited.path()}, limits);
  if (run.exit_status == ProgramLimits::kNotPermitted)
    GTEST_SKIP() << "mounting other control groups is not permitted";
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_EQ(read_text(free / "model.ply"), read_text(limited / "model.ply"));

  write_control_groups(groups, 1);
  const ProgramRun refused = run_relief({"run", scans / "scan.json", "-o", low.path()}, limits);
  EXPECT_EQ(refused.exit_status, 1);
  EXPECT_THAT(refused.standard_error, HasSubstr("more than the memory limit"));
  const ProgramRun unlimited =
      run_relief({"run", scans / "scan.json", "-o", low.path(), "--memory", "0"}, limits);
  EXPECT_EQ(unlimited.exit_status, 0) << unlimited.standard_error;
}

}  // namespace
}  // namespace relief
