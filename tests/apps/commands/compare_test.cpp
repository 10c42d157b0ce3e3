// `relief compare`: two runs side by side, as tables, JSON, page and models.
#include <cmath>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "relief/io/mesh_io.h"
#include "relief/scan/rigid_motion.h"
#include "tests/support/program.h"

namespace relief {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::TemporaryFolder;
using testing::write_text;

json read_json(const fs::path& path) { return json::parse(read_text(path)); }

void write_json(const fs::path& path, const json& value) { write_text(path, value.dump(2)); }

// Two runs of the same scans, of which the second is not polished.
class Compare : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const ProgramRun simulated =
        run_relief({"simulate", "-q", "--views", "6", "--width", "64", "--height", "64",
                    "--mesh-divisions", "0", "-o", *folder_ / "scans"});
    ASSERT_EQ(simulated.exit_status, 0) << simulated.standard_error;
    run(a(), {});
    run(b(), {"--no-polish", "--calibration", "auto"});
    compare(a(), b(), {"-o", page(), "--report", *folder_ / "page/compare.json"});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static void run(const fs::path& out, const std::vector<std::string>& options) {
    std::vector<std::string> arguments{
        "run", "-q", *folder_ / "scans/scan.json", "--no-html-report", "-o", out};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramRun run = run_relief(arguments);
    ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  }

  static fs::path a() { return *folder_ / "a"; }
  static fs::path b() { return *folder_ / "b"; }

  static fs::path page() { return *folder_ / "page/compare.html"; }  // Of A and B.

  // A copy of run A to change.
  fs::path copy_of_a() const {
    const fs::path copy = out_ / "copy";
    fs::create_directories(copy);
    for (const auto& entry : fs::directory_iterator(a()))
      if (entry.is_regular_file()) fs::copy_file(entry.path(), copy / entry.path().filename());
    return copy;
  }

  // The section of the report, which goes to standard output.
  static json compare(const fs::path& a, const fs::path& b,
                      const std::vector<std::string>& options = {}, int status = 0) {
    std::vector<std::string> arguments{"compare", a, b, "-q", "--json", "--samples", "20000"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramRun run = run_relief(arguments);
    EXPECT_EQ(run.exit_status, status) << run.standard_error;
    return json::parse(run.standard_output)["comparison"];
  }

  const TemporaryFolder out_;
  static inline TemporaryFolder* folder_ = nullptr;
};

TEST_F(Compare, NamesTheOptionThatDiffersAndTheSameInputs) {
  const json comparison = compare(a(), b());
  std::vector<json> matter;
  for (const json& option : comparison["options"])
    if (option["changes_result"]) matter.push_back(option);
  ASSERT_EQ(matter.size(), 1u);
  EXPECT_EQ(matter[0]["name"], "--no-polish");
  EXPECT_TRUE(matter[0]["a"].is_null());
  EXPECT_FALSE(matter[0]["b"].is_null());
  ASSERT_EQ(comparison["views"].size(), 6u);
  for (const json& view : comparison["views"]) EXPECT_EQ(view["input"], "same");
  EXPECT_TRUE(comparison["complete"]);
  EXPECT_EQ(comparison["notes"], json::array());
  EXPECT_EQ(comparison["a"]["program"], comparison["b"]["program"]);
}

TEST_F(Compare, ShowsTheWordsOfOptions) {
  EXPECT_EQ(read_json(b() / "report.json")["run"]["options"]["--calibration"], "auto");
  const fs::path other = copy_of_a();
  json report = read_json(other / "report.json");
  EXPECT_EQ(report["run"]["options"]["--calibration"], "auto");
  report["run"]["options"]["--calibration"] = "off";
  write_json(other / "report.json", report);
  const json options = compare(a(), other)["options"];
  ASSERT_EQ(options.size(), 1u);
  EXPECT_EQ(options[0]["name"], "--calibration");
  EXPECT_EQ(options[0]["a"], "auto");
  EXPECT_EQ(options[0]["b"], "off");
}

TEST_F(Compare, HasTheFiguresOfBothReports) {
  const json comparison = compare(a(), b());
  const json report_a = read_json(a() / "report.json"), report_b = read_json(b() / "report.json");
  const json& model = comparison["figures"]["model"];
  EXPECT_EQ(model["vertices"]["a"], report_a["merge"]["vertices"]);
  EXPECT_EQ(model["genus"]["b"], report_b["merge"]["genus"]);
  EXPECT_EQ(model["filled_area_fraction"]["b"], report_b["merge"]["filled_area_fraction"]);
  EXPECT_EQ(model["watertight"]["a"], true);
  EXPECT_EQ(model["polish_move"]["a"], report_a["merge"]["polish"]["rms_move"]);
  EXPECT_TRUE(model["polish_move"]["b"].is_null());
  EXPECT_TRUE(model["polish_move"]["difference"].is_null());
  const json& alignment = comparison["figures"]["alignment"];
  EXPECT_EQ(alignment["views_placed"]["a"], 6);
  const char* kept = report_b["align_again"]["gain"]["kept"] ? "align_again" : "align";
  EXPECT_EQ(alignment["rms"]["b"], report_b[kept]["rms"]);
  const json& memory = comparison["figures"]["cost"]["peak_memory_mb"];
  const double in_a = report_a["merge"]["peak_memory_mb"],
               in_b = report_b["merge"]["peak_memory_mb"];
  EXPECT_DOUBLE_EQ(memory["difference"], in_b - in_a);
  EXPECT_DOUBLE_EQ(memory["ratio"], in_b / in_a);
  EXPECT_EQ(comparison["views"][2]["median_deviation"]["a"],
            report_a["refine"]["views"][2]["median_deviation"]);
  EXPECT_EQ(comparison["views"][5]["status"]["b"], report_b[kept]["views"][5]["status"]);
}

// The poses are those of the same computation, so the frames are one, and `evaluate` measures the
// same points of A.
TEST_F(Compare, MeasuresTheDistancesThatEvaluateMeasures) {
  const json comparison = compare(a(), b());
  EXPECT_EQ(comparison["frame"]["views"], 6);
  EXPECT_LT(comparison["frame"]["shift"].get<double>(), 1e-9);
  EXPECT_LT(comparison["poses"]["max_displacement"].get<double>(), 1e-9);
  const auto evaluate = [](const fs::path& result, const fs::path& truth) {
    const ProgramRun run = run_relief({"evaluate", result / "model.ply", "--truth",
                                       truth / "model.ply", "--samples", "20000", "--json", "-q"});
    EXPECT_EQ(run.exit_status, 0) << run.standard_error;
    return json::parse(run.standard_output)["evaluate"]["accuracy"];
  };
  const json there = evaluate(a(), b()), back = evaluate(b(), a());
  for (const char* figure : {"mean", "median", "rms", "p95", "max"}) {
    EXPECT_NEAR(comparison["models"]["a_to_b"][figure], there[figure], 1e-9) << figure;
    EXPECT_NEAR(comparison["models"]["b_to_a"]["measured"][figure], back["measured"][figure], 1e-9);
    EXPECT_NEAR(comparison["models"]["b_to_a"]["filled"][figure], back["filled"][figure], 1e-9);
  }
  EXPECT_GT(comparison["models"]["a_to_b"]["rms"].get<double>(), 0.0);
}

void move_model(const fs::path& file, const RigidMotion& motion) {
  auto mesh = read_mesh(file);
  ASSERT_TRUE(mesh) << mesh.error().message;
  for (auto& vertex : mesh->vertices) vertex = motion * vertex;
  ASSERT_TRUE(write_mesh(*mesh, file));
}

void move_poses(const fs::path& file, const RigidMotion& motion) {
  json report = read_json(file);
  for (const char* section : {"align", "align_again"}) {
    if (!report.contains(section)) continue;
    for (json& view : report[section]["views"]) {
      Eigen::Matrix4d pose;
      for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) pose(r, c) = view["world_from_view"][r][c];
      pose = motion.matrix() * pose;
      for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) view["world_from_view"][r][c] = pose(r, c);
    }
  }
  write_json(file, report);
}

TEST_F(Compare, BringsBothModelsIntoOneFrame) {
  const fs::path moved = copy_of_a();
  const RigidMotion motion =
      motion_from_tangent((RigidTangent() << 0.2, -0.4, 0.1, 30, -50, 80).finished());
  move_model(moved / "model.ply", motion);
  move_poses(moved / "report.json", motion);

  const json aligned = compare(a(), moved);
  EXPECT_NEAR(aligned["frame"]["rotation_deg"], 180.0 / M_PI * rotation_angle(motion), 1e-6);
  EXPECT_EQ(aligned["frame"]["fitted"], true);
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      EXPECT_NEAR(aligned["frame"]["a_from_b"][r][c], motion.inverse()(r, c), 1e-6);
  EXPECT_LT(aligned["models"]["b_to_a"]["max"].get<double>(), 1e-4);
  EXPECT_LT(aligned["poses"]["max_displacement"].get<double>(), 1e-6);

  const json as_they_are = compare(a(), moved, {"--no-align"});
  EXPECT_EQ(as_they_are["frame"]["fitted"], false);
  EXPECT_GT(as_they_are["models"]["b_to_a"]["max"].get<double>(), 10.0);
  EXPECT_GT(as_they_are["poses"]["mean_displacement"].get<double>(), 50.0);
}

// The one view that another run places elsewhere is found, and leaves the others alone.
TEST_F(Compare, FindsTheViewThatMoved) {
  const fs::path moved = copy_of_a();
  json report = read_json(moved / "report.json");
  for (const char* section : {"align", "align_again"})
    if (report.contains(section))
      report[section]["views"][3]["world_from_view"][0][3] =
          5.0 + report[section]["views"][3]["world_from_view"][0][3].get<double>();
  write_json(moved / "report.json", report);
  const json views = compare(a(), moved)["views"];
  for (std::size_t i = 0; i < views.size(); ++i)
    EXPECT_NEAR(views[i]["pose"]["mean_displacement"], i == 3 ? 5.0 : 0.0, 0.01) << i;
}

TEST_F(Compare, NamesInputsThatDiffer) {
  const fs::path other = copy_of_a();
  json report = read_json(other / "report.json");
  report["run"]["inputs"][1]["samples_sha256"] = "0";
  report["run"]["inputs"][2]["pose_sha256"] = "0";
  report["run"]["inputs"][3]["name"] = "another";
  write_json(other / "report.json", report);
  std::map<std::string, std::string> inputs;
  const json original = read_json(a() / "report.json")["run"]["inputs"];
  const json views = compare(a(), other)["views"];
  for (const json& view : views) inputs[view["name"]] = view["input"];
  EXPECT_EQ(inputs[original[0]["name"]], "same");
  EXPECT_EQ(inputs[original[1]["name"]], "other samples");
  EXPECT_EQ(inputs[original[2]["name"]], "other starting pose");
  EXPECT_EQ(inputs[original[3]["name"]], "only in A");
  EXPECT_EQ(inputs["another"], "only in B");
}

// Every number of the page that names its place in the report is the number at that place.
TEST_F(Compare, WritesAPageWithTheNumbersOfTheReport) {
  const json report = read_json(*folder_ / "page/compare.json");
  EXPECT_EQ(report["comparison"], compare(a(), b()));
  const std::string page = read_text(Compare::page());
  const std::regex figure(R"re(<data value="([^"]*)" data-key="([^"]*)">([^<]*)</data>)re");
  std::set<std::string> places;
  for (std::sregex_iterator found(page.begin(), page.end(), figure), end; found != end; ++found) {
    places.insert((*found)[2]);
    EXPECT_EQ(json::parse((*found)[1].str()), report.at(json::json_pointer((*found)[2])))
        << (*found)[2];
    EXPECT_FALSE((*found)[3].str().empty());
  }
  for (const char* place :
       {"/comparison/figures/model/vertices/difference", "/comparison/figures/cost/seconds/ratio",
        "/comparison/models/a_to_b/measured/p95", "/comparison/models/b_to_a/filled/max",
        "/comparison/poses/mean_displacement", "/comparison/models/colour_scale",
        "/comparison/views/5/pose/rotation_deg", "/comparison/frame/shift",
        "/comparison/views/0/median_deviation/b"})
    EXPECT_TRUE(places.contains(place)) << place;
  for (const char* title : {"A", "B", "A, distance to B", "B, distance to A, from behind"})
    EXPECT_THAT(page, HasSubstr("<figcaption>" + std::string(title) + "</figcaption>"));
  EXPECT_THAT(page, HasSubstr("<td>default</td><td>true</td>"));
}

// Without the sources of images that lie in the page themselves.
std::string without_pictures(std::string page) {
  const std::string start = "src=\"data:image/png;base64,";
  for (std::size_t at = page.find(start); at != std::string::npos; at = page.find(start, at))
    page.erase(at, page.find('"', at + start.size()) + 1 - at);
  return page;
}

TEST_F(Compare, WritesAPageThatNeedsNothingElse) {
  const std::string page = without_pictures(read_text(Compare::page()));
  EXPECT_THAT(page, AllOf(HasSubstr("</html>"), HasSubstr("default-src 'none'")));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("src=\"")), Not(HasSubstr("href=\""))));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("http://")), Not(HasSubstr("https://")),
                          Not(HasSubstr("@import")), Not(HasSubstr("url("))));
}

TEST_F(Compare, WritesModelsWithTheirDistances) {
  const json comparison = compare(a(), b(), {"--models", out_ / "models"});
  const auto mesh = read_mesh(out_ / "models/a.ply"), original = read_mesh(a() / "model.ply");
  ASSERT_TRUE(mesh && original);
  ASSERT_EQ(mesh->vertices.size(), original->vertices.size());
  EXPECT_EQ(mesh->colours.size(), mesh->vertices.size());
  double largest = 0.0;
  for (const float distance : mesh->quality)
    largest = std::max(largest, std::abs(static_cast<double>(distance)));
  EXPECT_GT(largest, comparison["models"]["a_to_b"]["p95"].get<double>());
  EXPECT_THAT(read_text(out_ / "models/b.ply"),
              HasSubstr("comment quality: distance to the other model, negative inside"));
}

TEST_F(Compare, IsTheSameOnAnyNumberOfThreads) {
  const auto files = [&](const std::string& threads) {
    const fs::path folder = out_ / threads;
    const json report = compare(a(), b(),
                                {"--threads", threads, "-o", folder / "compare.html", "--models",
                                 folder, "--report", folder / "c.json"});
    return read_text(folder / "compare.html") + read_text(folder / "a.ply") +
           read_text(folder / "b.ply") + read_text(folder / "c.json");
  };
  EXPECT_EQ(files("1"), files("3"));
}

TEST_F(Compare, PrintsTables) {
  const ProgramRun run = run_relief({"compare", a(), b(), "--samples", "2000"});
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  for (const char* text : {"--no-polish", "Views placed", "Genus (handles)", "Largest memory",
                           "A to B", "  measured part", "turned [deg]", "6 common views"})
    EXPECT_THAT(run.standard_output, HasSubstr(text));
}

TEST_F(Compare, TakesARunThatIsNotFinished) {
  const fs::path unfinished = copy_of_a();
  fs::remove(unfinished / "model.ply");
  fs::remove(unfinished / "scan.json");
  json report = read_json(unfinished / "report.json");
  for (const char* section : {"merge", "align_again", "refine"}) report.erase(section);
  report["run"].erase("cache");
  write_json(unfinished / "report.json", report);

  const json comparison = compare(a(), unfinished, {"-o", out_ / "compare.html"}, 1);
  EXPECT_FALSE(comparison["complete"]);
  EXPECT_TRUE(comparison["models"].is_null());
  EXPECT_FALSE(comparison["b"]["finished"]);
  EXPECT_EQ(comparison["poses"]["views"], 6);  // With the samples of A.
  EXPECT_EQ(comparison["figures"]["alignment"]["views_placed"]["b"], 6);
  EXPECT_TRUE(comparison["figures"]["model"]["vertices"]["b"].is_null());
  const std::string notes = comparison["notes"].dump();
  for (const char* note :
       {"B did not finish", "B lacks model.ply", "B lacks the figures of the model",
        "The models are not compared: B has none"})
    EXPECT_THAT(notes, HasSubstr(note));
  EXPECT_THAT(read_text(out_ / "compare.html"), HasSubstr("B lacks model.ply"));

  const json other_way = compare(unfinished, a(), {}, 1);
  EXPECT_EQ(other_way["poses"]["views"], 6);
}

TEST_F(Compare, SaysWhyAFolderIsNoRun) {
  const fs::path folder = out_ / "empty";
  fs::create_directories(folder);
  const ProgramRun none = run_relief({"compare", a(), folder});
  EXPECT_EQ(none.exit_status, 2);
  EXPECT_THAT(none.standard_error, HasSubstr("no folder of `relief run`"));
  write_text(folder / "report.json", "{}");
  EXPECT_THAT(run_relief({"compare", folder, a()}).standard_error,
              HasSubstr("no report of relief"));
  write_text(folder / "report.json", R"({"relief": "0", "evaluate": {}})");
  EXPECT_THAT(run_relief({"compare", folder, a()}).standard_error,
              HasSubstr("this report is not of a run"));
  EXPECT_EQ(run_relief({"compare", a()}).exit_status, 2);
  EXPECT_EQ(run_relief({"compare", a(), folder / "nowhere"}).exit_status, 2);
}

// Reports of other versions have other keys, and lengths of other units are not subtracted.
TEST_F(Compare, TakesReportsOfOtherVersionsAndUnits) {
  const fs::path other = copy_of_a();
  json project = read_json(other / "scan.json");
  project["unit"] = "m";
  write_json(other / "scan.json", project);
  json report = read_json(other / "report.json");
  report["relief"] = "</script><b>";
  report["run"] = {{"options", 3}};
  report["refine"]["views"] = {1, {{"name", 3}}};
  report["merge"]["vertices"] = "x";
  write_json(other / "report.json", report);
  const json comparison = compare(a(), other, {"-o", out_ / "compare.html"}, 1);
  EXPECT_TRUE(comparison["figures"]["alignment"]["rms"]["difference"].is_null());
  EXPECT_TRUE(comparison["figures"]["model"]["vertices"]["b"].is_null());
  EXPECT_TRUE(comparison["models"].is_null());
  EXPECT_EQ(comparison["views"][0]["input"], "not recorded");
  EXPECT_THAT(comparison["notes"].dump(),
              AllOf(HasSubstr("A is in mm, B in m"), HasSubstr("different versions")));
  EXPECT_THAT(read_text(out_ / "compare.html"), Not(HasSubstr("</script><b>")));
}

}  // namespace
}  // namespace relief
