// What the program says, returns and leaves behind when its input or its surroundings are bad.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/support/program.h"
#include "tests/support/scenes/simulated_scans.h"

namespace relief {
namespace {

using nlohmann::json;
using ::testing::AnyOf;
using testing::files_below;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::TemporaryFolder;
using testing::write_text;

// A good project of three small simulated views, made once, that each test copies and spoils.
class BadInput : public testing::SimulatedScans<BadInput> {
 public:
  static std::vector<std::string> simulation() {
    return {"--views", "3", "--width", "64", "--height", "64", "--mesh-divisions", "0"};
  }

 protected:
  void SetUp() override {
    std::filesystem::copy(scans().path(), project_.path(),
                          std::filesystem::copy_options::recursive);
    scan_ = json::parse(read_text(project_ / "scan.json"));
  }

  void save() { write_text(project_ / "scan.json", scan_.dump(1)); }

  std::string depth_file() const {
    return project_ / scan_["views"][0]["depth"]["file"].get<std::string>();
  }

  // Each command that takes a project must fail with `status`, say `words`, and leave no output.
  void expect_failure(int status, const std::string& words) {
    const TemporaryFolder out;
    const std::vector<std::vector<std::string>> commands = {
        {"info", project_ / "scan.json"},
        {"align", project_ / "scan.json", "-o", out / "aligned.json"},
        {"refine", project_ / "scan.json", "-o", out / "refined"},
        {"merge", project_ / "scan.json", "-o", out / "model.ply"},
        {"run", project_ / "scan.json", "-o", out / "run"}};
    for (const auto& command : commands) {
      const ProgramRun run = run_relief(command);
      EXPECT_EQ(run.exit_status, status) << command[0] << ": " << run.standard_error;
      EXPECT_THAT(run.standard_error, HasSubstr(words)) << command[0];
      EXPECT_THAT(files_below(out.path()), IsEmpty()) << command[0];
    }
  }

  TemporaryFolder project_;
  json scan_;
};

TEST_F(BadInput, MissingProject) {
  std::filesystem::remove(project_ / "scan.json");
  expect_failure(2, "scan.json");
}

TEST_F(BadInput, MissingDepthFile) {
  std::filesystem::remove(depth_file());
  expect_failure(2, std::filesystem::path(depth_file()).filename());
}

TEST_F(BadInput, TruncatedDepthFile) {
  const std::string bytes = read_text(depth_file());
  write_text(depth_file(), bytes.substr(0, bytes.size() / 2));
  expect_failure(2, std::filesystem::path(depth_file()).filename());
}

// Known before any work, and told then.
TEST_F(BadInput, ExportsThatCannotHoldTheViews) {
  const TemporaryFolder out;
  const std::string scan_file = project_ / "scan.json";
  for (const char* const file : {"poses.aln", "poses.conf", "views.pcd"})
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"run", scan_file, "-o", out / "r"},
          {"align", scan_file, "-o", out / "a.json"}}) {
      auto words = command;
      words.insert(words.end(), {"--export", out / file});
      const ProgramRun run = run_relief(words);
      EXPECT_EQ(run.exit_status, 2) << file;
      EXPECT_THAT(run.standard_error, HasSubstr(file)) << command[0];
      EXPECT_THAT(files_below(out.path()), IsEmpty()) << command[0];
    }
}

// Also through a link, and by files of scans that have the names of results.
TEST_F(BadInput, OutputOverTheInput) {
  const std::string folder = project_.path(), scan_file = project_ / "scan.json";
  const TemporaryFolder grids, out;
  ASSERT_EQ(run_relief({"convert", scan_file, "--grids", "-o", grids.path()}).exit_status, 0);
  std::filesystem::remove(grids / "scan.json");
  std::filesystem::create_directory_symlink(project_.path(), out / "link");
  const auto texts = [&] {
    std::vector<std::string> all;
    for (const auto& input : {project_.path(), grids.path()})
      for (const std::string& file : files_below(input))
        all.push_back(file + read_text(input / file));
    return all;
  };
  const std::vector<std::string> before = texts();
  const std::string view = scan_["views"][0]["name"];
  const std::string grid = grids / (view + ".ply");
  const std::vector<std::pair<std::vector<std::string>, std::string>> commands = {
      {{"run", folder, "-o", folder}, "scan.json"},
      {{"run", scan_file, "-o", out / "link"}, "link/scan.json"},
      {{"run", scan_file, "-o", out / "run", "--report", depth_file()}, depth_file()},
      {{"run", grids.path(), "-o", grids.path()}, grid},
      {{"step", "align", scan_file, "-o", folder}, "scan.json"},
      {{"refine", scan_file, "-o", folder}, "scan.json"},
      {{"calibrate", folder, "-o", folder}, "scan.json"},
      {{"align", folder, "-o", scan_file}, "scan.json"},
      {{"merge", grids.path(), "-o", grid}, grid},
      {{"convert", grid, "-o", grid}, grid},
      {{"convert", scan_file, "-o", folder}, "scan.json"}};
  for (const auto& [command, file] : commands) {
    const ProgramRun run = run_relief(command);
    EXPECT_EQ(run.exit_status, 2) << command[0] << ": " << run.standard_error;
    EXPECT_THAT(run.standard_error, HasSubstr(file + ": is one of the input files")) << command[0];
  }
  EXPECT_EQ(texts(), before);
  EXPECT_THAT(files_below(out.path()), IsEmpty());
}

TEST_F(BadInput, ProjectThatIsNotJson) {
  write_text(project_ / "scan.json", "{ \"format\": \"relief-scan\", oops }");
  expect_failure(2, "scan.json");
}

TEST_F(BadInput, TextWhereANumberBelongs) {
  scan_["views"][1]["camera"]["fx"] = "nine hundred";
  save();
  expect_failure(2, "fx");
}

TEST_F(BadInput, ZeroFocalLength) {
  scan_["views"][1]["camera"]["fx"] = 0;
  save();
  expect_failure(2, "fx");
}

TEST_F(BadInput, PoseThatIsNoRotation) {
  scan_["views"][2]["world_from_view"] = {{2, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  save();
  expect_failure(2, "world_from_view");
}

TEST_F(BadInput, UnknownKey) {
  scan_["views"][0]["camera"]["focal"] = 900;
  save();
  expect_failure(2, "focal");
}

TEST_F(BadInput, DepthAndNormalsOfDifferentSizes) {
  const TemporaryFolder other;
  ASSERT_EQ(run_relief({"simulate", "-q", "--views", "3", "--width", "48", "--height", "48",
                        "--mesh-divisions", "0", "-o", other.path().string()})
                .exit_status,
            0);
  const json scan = json::parse(read_text(other / "scan.json"));
  scan_["views"][0]["normals"]["file"] =
      (other / scan["views"][0]["normals"]["file"].get<std::string>()).string();
  save();
  expect_failure(2, "48");
}

TEST_F(BadInput, ViewWithoutSamples) {
  const int width = 64, height = 64;
  std::string pfm = "Pf\n64 64\n-1.0\n";
  pfm.append(static_cast<std::size_t>(width) * height * 4, '\0');  // zero: no sample
  write_text(project_ / "empty.pfm", pfm);
  scan_["views"][0]["depth"]["file"] = "empty.pfm";
  scan_["views"][0].erase("normals");
  save();
  expect_failure(1, scan_["views"][0]["name"]);
}

TEST_F(BadInput, UnwritableOutput) {
  write_text(project_ / "file", "not a folder");
  const std::string below_a_file = (project_ / "file/out").string();
  const std::vector<std::vector<std::string>> commands = {
      {"align", project_ / "scan.json", "-o", below_a_file + "/aligned.json"},
      {"refine", project_ / "scan.json", "-o", below_a_file},
      {"merge", project_ / "scan.json", "-o", below_a_file + "/model.ply"},
      {"run", project_ / "scan.json", "-o", below_a_file},
      {"simulate", "-o", below_a_file}};
  for (const auto& command : commands) {
    const ProgramRun run = run_relief(command);
    EXPECT_EQ(run.exit_status, 2) << command[0] << ": " << run.standard_error;
    EXPECT_THAT(run.standard_error, HasSubstr("file/out")) << command[0];
  }
}

TEST_F(BadInput, UnknownMeshEnding) {
  const ProgramRun run =
      run_relief({"merge", project_ / "scan.json", "-o", project_ / "model.xyz"});
  EXPECT_EQ(run.exit_status, 2);
  EXPECT_THAT(run.standard_error, HasSubstr(".xyz"));
}

// Every output file larger than the limit fails as it would on a full disk.
TEST_F(BadInput, FullDiskLeavesNothingHalfWritten) {
  const TemporaryFolder out;
  const ProgramRun merged = run_relief({"merge", project_ / "scan.json", "-o", out / "model.ply"},
                                       {.file_size_bytes = 8192});
  EXPECT_EQ(merged.exit_status, 2) << merged.standard_error;
  EXPECT_THAT(merged.standard_error, HasSubstr("model.ply"));
  EXPECT_THAT(files_below(out.path()), IsEmpty());

  const ProgramRun refined = run_relief({"refine", project_ / "scan.json", "-o", out / "refined"},
                                        {.file_size_bytes = 4096});
  EXPECT_EQ(refined.exit_status, 2) << refined.standard_error;
  EXPECT_FALSE(std::filesystem::exists(out / "refined/scan.json"));
}

TEST_F(BadInput, OlderOutputSurvivesAFailure) {
  write_text(project_ / "model.ply", "older");
  const ProgramRun run = run_relief({"merge", project_ / "scan.json", "-o", project_ / "model.ply"},
                                    {.file_size_bytes = 8192});
  EXPECT_EQ(run.exit_status, 2);
  EXPECT_EQ(read_text(project_ / "model.ply"), "older");
}

TEST_F(BadInput, OneViewOnlyStillGivesAClosedModel) {
  scan_["views"].erase(1);
  scan_["views"].erase(1);
  save();
  const TemporaryFolder out;
  const ProgramRun run = run_relief({"run", project_ / "scan.json", "-o", out.path().string()});
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  const json report = json::parse(read_text(out / "report.json"));
  EXPECT_TRUE(report["merge"]["watertight"]);
}

TEST_F(BadInput, GivenPosesThatNothingConfirmsAreKeptWithOneWarning) {
  scan_["views"].erase(2);
  scan_["views"][1]["world_from_view"] = {
      {1, 0, 0, 9000}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  scan_["views"][1]["pose_is"] = "guess";
  save();
  const TemporaryFolder out;
  const ProgramRun run = run_relief({"align", project_ / "scan.json", "-o", out / "aligned.json"});
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  const auto name = [&](int i) { return scan_["views"][i]["name"].get<std::string>(); };
  EXPECT_THAT(run.standard_error,
              HasSubstr("views " + name(0) + ", " + name(1) +
                        " are kept at poses that are not verified: of each, it overlaps no other"));
  const json view = json::parse(read_text(out / "report.json"))["align"]["views"][1];
  EXPECT_TRUE(view["aligned"]);
  EXPECT_EQ(view["status"], "unverified");
  EXPECT_EQ(view["world_from_view"], scan_["views"][1]["world_from_view"]);
}

TEST(WrongUsage, IsExitStatusTwo) {
  const std::vector<std::vector<std::string>> commands = {
      {}, {"polish"}, {"align"}, {"merge", "scan.json"}, {"info", "a", "--no-such-option"}};
  for (const auto& command : commands) {
    const ProgramRun run = run_relief(command);
    EXPECT_EQ(run.exit_status, 2) << run.standard_error;
    EXPECT_FALSE(run.standard_error.empty());
    EXPECT_TRUE(run.standard_output.empty());
  }
}

TEST(WrongUsage, NumbersOutOfRangeAreNamedInFewWords) {
  for (const char* value : {"0", "-1", "inf", "many"}) {
    const ProgramRun run = run_relief({"info", "a", "--depth-scale", value});
    EXPECT_EQ(run.exit_status, 2);
    EXPECT_THAT(run.standard_error,
                HasSubstr("--depth-scale: '" + std::string(value) + "' is no positive number"));
  }
}

TEST(WrongUsage, AMeshIsNoScanUnlessItIsCalledOne) {
  const TemporaryFolder folder;
  write_text(folder / "a.obj", "v 0 0 5\nv 1 0 5\nv 0 1 5\nf 1 2 3\n");
  const ProgramRun run = run_relief({"convert", folder / "a.obj", "-o", folder / "a.e57"});
  EXPECT_EQ(run.exit_status, 2);
  EXPECT_THAT(run.standard_error, HasSubstr("is a mesh"));
  EXPECT_THAT(run.standard_error, HasSubstr("--as-views"));
}

// Such a file is a cloud, which becomes a view, not a mesh.
TEST(WrongUsage, AFileThatDeclaresNoFacesIsACloud) {
  const TemporaryFolder folder;
  write_text(folder / "cloud.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
             "property float z\nelement face 0\nproperty list uchar int vertex_indices\n"
             "end_header\n0 0 5\n1 0 5\n0 1 5\n1 1 5\n");
  const ProgramRun run = run_relief(
      {"convert", folder / "cloud.ply", "--viewpoint", "0", "0", "0", "-o", folder / "a.pcd"});
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_TRUE(std::filesystem::exists(folder / "a.pcd"));
}

// What `merge` says of a 2x2 range grid with these vertex lines.
void expect_bad_grid(const std::string& vertices, const std::string& words) {
  const TemporaryFolder folder;
  write_text(folder / "scan.ply",
             "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n"
             "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n" +
                 vertices);
  const ProgramRun run = run_relief({"merge", folder / "scan.ply", "-o", folder / "model.ply"});
  EXPECT_EQ(run.exit_status, 2);
  EXPECT_THAT(run.standard_error, HasSubstr("scan.ply"));
  EXPECT_THAT(run.standard_error, HasSubstr(words));
  EXPECT_FALSE(std::filesystem::exists(folder / "model.ply"));
}

TEST(BadGrid, Truncated) { expect_bad_grid("0 0 1\n1 0 1\n", "truncated"); }

TEST(BadGrid, TextWhereANumberBelongs) {
  expect_bad_grid("0 0 1\n1 0 nan\n0 one 1\n1 1 1\n1 0\n1 1\n1 2\n1 3\n", "one");
}

TEST(BadGrid, IndexOutOfRange) {
  expect_bad_grid("0 0 1\n1 0 1\n0 1 1\n1 1 1\n1 0\n1 1\n1 2\n1 7\n", "7");
}

}  // namespace
}  // namespace relief
