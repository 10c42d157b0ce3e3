// report.html: its numbers, its model, and that nothing in it can break out of its place.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/reports/html/html_text.h"
#include "apps/reports/html/report_content.h"
#include "apps/reports/html/viewer/cluster_vertices.h"
#include "relief/fusion/decimate_mesh.h"
#include "relief/io/mesh_io.h"
#include "tests/support/program.h"
#include "tests/support/result_matchers.h"

namespace relief {
namespace {

using nlohmann::json;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::TemporaryFolder;

std::string between(const std::string& text, const std::string& start, const std::string& end) {
  const std::size_t from = text.find(start);
  if (from == std::string::npos) return "";
  return text.substr(from + start.size(), text.find(end, from) - from - start.size());
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++found;
  return found;
}

std::string page_of(const TemporaryFolder& folder, std::vector<std::string> options = {}) {
  options.insert(options.begin(), {"report", "-q", folder.path().string()});
  const ProgramRun run = run_relief(options);
  EXPECT_EQ(run.exit_status, 0) << run.standard_error;
  return read_text(folder / "report.html");
}

json report_in(const std::string& page) {
  return json::parse(between(page, R"(<script type="application/json" id="report">)", "</script>"));
}

// The bytes of an array of the viewer, decoded here by other means than those of the program.
std::string bytes_of(const std::string& page, const std::string& name) {
  const std::string text = between(page, "id=\"viewer-" + name + "\">", "</script>");
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int held = 0;
  for (const char c : text) {
    const std::size_t digit = digits.find(c);
    if (digit == std::string::npos) break;
    bits = (bits << 6 | static_cast<unsigned>(digit)) & 0xffffffu;
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held & 255u);
  }
  return bytes;
}

template <typename T>
std::vector<T> array_of(const std::string& page, const std::string& name) {
  const std::string bytes = bytes_of(page, name);
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

// An ellipsoid with attributes; its upper part is filled.
TriangleMesh ellipsoid(int rings) {
  TriangleMesh mesh;
  const int sides = 2 * rings;
  const auto add = [&](double theta, double phi) {
    const Eigen::Vector3d p(30.0 * std::sin(theta) * std::cos(phi),
                            20.0 * std::sin(theta) * std::sin(phi), 10.0 * std::cos(theta));
    mesh.vertices.push_back(p + Eigen::Vector3d(500.0, -3.0, 40.0));
    mesh.filled.push_back(p.z() > 7.0);
    mesh.views.push_back(p.z() > 7.0 ? 0 : 1 + (p.x() > 0.0));
    mesh.source_views.push_back(p.z() > 7.0 ? kNoSourceView : p.y() > 0.0 ? 3 : 0);
    mesh.quality.push_back(static_cast<float>(0.01 + 0.0005 * (p.x() + 30.0)));
  };
  add(0.0, 0.0);
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < sides; ++j)
      add(std::numbers::pi * i / rings, 2.0 * std::numbers::pi * j / sides);
  add(std::numbers::pi, 0.0);
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>(1 + (i - 1) * sides + (j + sides) % sides);
  };
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (int j = 0; j < sides; ++j) {
    mesh.faces.push_back({0, at(1, j), at(1, j + 1)});
    for (int i = 1; i + 1 < rings; ++i) {
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    mesh.faces.push_back({last, at(rings - 1, j + 1), at(rings - 1, j)});
  }
  return mesh;
}

void write_model(const TemporaryFolder& folder, const TriangleMesh& mesh) {
  ASSERT_THAT(write_mesh(mesh, folder / "model.ply"), IsOk());
  folder.write("report.json", json{{"relief", "0"}, {"merge", {{"vertices", 1}}}}.dump());
}

// Every number of the page that names its place in report.json is the number at that place.
TEST(HtmlReport, HasTheNumbersOfTheReport) {
  const TemporaryFolder scans, out;
  ASSERT_EQ(run_relief({"simulate", "-q", "--views", "6", "--width", "96", "--height", "96",
                        "--mesh-divisions", "0", "-o", scans.path().string()})
                .exit_status,
            0);
  const ProgramRun run =
      run_relief({"run", scans / "scan.json", "--contradicted", "keep", "-o", out.path().string()});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  const std::string page = read_text(out / "report.html");
  const json report = json::parse(read_text(out / "report.json"));
  EXPECT_EQ(report_in(page), report);
  EXPECT_EQ(report["run"]["options"]["--contradicted"], "keep");

  const std::regex figure(R"re(<data value="([^"]*)" data-key="([^"]*)">([^<]*)</data>)re");
  std::set<std::string> places;
  for (std::sregex_iterator found(page.begin(), page.end(), figure), end; found != end; ++found) {
    places.insert((*found)[2]);
    const json& value = report.at(json::json_pointer((*found)[2]));
    EXPECT_EQ(json::parse((*found)[1].str()), value) << (*found)[2];
    EXPECT_FALSE((*found)[3].str().empty());
  }
  const std::string align = report["align_again"]["gain"]["kept"] ? "/align_again" : "/align";
  for (const std::string& place :
       {std::string("/merge/vertices"), std::string("/merge/genus"),
        std::string("/merge/filled_area_fraction"), std::string("/refine/views/0/sigma_position"),
        std::string("/refine/views/5/flying_samples"), align + "/pairs/0/rms",
        align + "/views/5/pose_std/5", align + "/loops/0/length", align + "/loops/0/ratio",
        std::string("/refine/views/2/spectrum/0/refined"), std::string("/merge/peak_memory_mb")})
    EXPECT_TRUE(places.contains(place)) << place;
  EXPECT_GT(places.size(), 100u);
  for (const char* step : {"run", "align", "merge"})
    for (const std::string note : report[step]["notes"])
      EXPECT_THAT(run.standard_error, HasSubstr(note));
  for (const char* title : {"Lit from the front", "Grazing light", "Measured and filled"})
    EXPECT_THAT(page, HasSubstr("<figcaption>" + std::string(title)));
  EXPECT_EQ(count(page, "<figcaption>As measured"), 6u);
  EXPECT_EQ(count(page, "<figcaption>Refined"), 6u);
  EXPECT_EQ(page.find("http://"), page.find("http://www.w3.org"));  // Names of formats only.
}

// Places in a report are not believed: a report may come from anywhere.
TEST(HtmlReport, TakesPicturesOfItsFolderAlone) {
  const TemporaryFolder folder, other;
  const std::string png = "\x89PNG\r\n\x1a\nno more";
  other.write("secret.png", png);
  folder.write("fine.png", png);
  folder.write("text.png", "secret");
  json views = json::array();
  for (const std::string& place :
       {std::string("fine.png"), std::string("text.png"), (other / "secret.png").string(),
        "../" + other.path().filename().string() + "/secret.png", std::string("absent.png")})
    views.push_back({{"name", place}, {"status", "refined"}, {"pictures", {{"measured", place}}}});
  folder.write("report.json", json{{"relief", "0"}, {"refine", {{"views", views}}}}.dump());
  EXPECT_EQ(count(page_of(folder), "<figcaption>As measured"), 1u);
}

// A million faces by default would come to 200 000: 15 MB have room for twice that.
TEST(HtmlReport, HoldsTheDecimatedModel) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = ellipsoid(60);
  write_model(folder, mesh);
  const std::string page = page_of(folder, {"--viewer-faces", "10000"});
  const auto stored = value_of(read_mesh(folder / "model.ply"));
  const auto expected = value_of(fusion::decimate_mesh(stored, {.faces = 10000}));
  const TriangleMesh& model = expected.mesh;

  const auto faces = array_of<std::uint32_t>(page, "faces");
  ASSERT_EQ(faces.size(), 3 * model.faces.size());
  EXPECT_LE(model.faces.size(), 10000u);
  EXPECT_EQ(std::memcmp(faces.data(), model.faces.data(), 4 * faces.size()), 0);

  const json data = json::parse(
      between(page, R"(<script type="application/json" id="viewer-data">)", "</script>"));
  EXPECT_EQ(data["faces_before"], mesh.faces.size());
  const auto steps = array_of<std::uint16_t>(page, "positions");
  ASSERT_EQ(steps.size(), 3 * model.vertices.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double low = data["low"][i % 3], high = data["high"][i % 3];
    EXPECT_NEAR(low + steps[i] / 65535.0 * (high - low), model.vertices[i / 3][i % 3],
                0.5001 * (high - low) / 65535.0);
  }
  const auto views = array_of<std::uint8_t>(page, "views");
  EXPECT_EQ(PagedVector<std::uint16_t>(views.begin(), views.end()), model.views);
  EXPECT_THAT(array_of<std::uint8_t>(page, "filled"), ElementsAreArray(model.filled));
  EXPECT_THAT(array_of<std::uint16_t>(page, "sources"), ElementsAreArray(model.source_views));
  const auto errors = array_of<std::uint8_t>(page, "errors");
  const double low = data["error"][0], high = data["error"][1];
  for (std::size_t v = 0; v < errors.size(); ++v)
    EXPECT_NEAR(low + errors[v] / 255.0 * (high - low),
                std::clamp<double>(model.quality[v], low, high), 0.51 * (high - low) / 255.0);
  EXPECT_LT(page.size(), 1'200'000u + 30 * model.faces.size());
}

// A model that is many times too fine is clustered first, then decimated.
TEST(HtmlReport, ThinsALargeModel) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = ellipsoid(100);
  write_model(folder, mesh);
  const std::string page = page_of(folder, {"--viewer-faces", "3000"});
  const json data = json::parse(
      between(page, R"(<script type="application/json" id="viewer-data">)", "</script>"));
  const auto steps = array_of<std::uint16_t>(page, "positions");
  const auto views = array_of<std::uint8_t>(page, "views");
  const auto faces = array_of<std::uint32_t>(page, "faces");
  EXPECT_LE(faces.size(), 3 * 3000u);
  EXPECT_GT(faces.size(), 3 * 1500u);

  TriangleMesh shown;
  for (std::size_t v = 0; v < views.size(); ++v) {
    Eigen::Vector3d place;
    for (int k = 0; k < 3; ++k) {
      const double low = data["low"][k], high = data["high"][k];
      place[k] = low + steps[3 * v + k] / 65535.0 * (high - low);
    }
    double nearest = 1e300, nearest_alike = 1e300;
    for (std::size_t w = 0; w < mesh.vertices.size(); ++w) {
      const double distance = (mesh.vertices[w] - place).norm();
      nearest = std::min(nearest, distance);
      if (mesh.views[w] == views[v]) nearest_alike = std::min(nearest_alike, distance);
    }
    EXPECT_LT(nearest, 0.5);
    EXPECT_LT(nearest_alike, 2.0) << "attributes of a vertex nearby";
    shown.vertices.push_back(place);
  }
  for (std::size_t f = 0; f < faces.size(); f += 3)
    shown.faces.push_back({faces[f], faces[f + 1], faces[f + 2]});
  EXPECT_NEAR(surface_area(shown), surface_area(mesh), 0.01 * surface_area(mesh));
  EXPECT_NEAR(enclosed_volume(shown), enclosed_volume(mesh), 0.01 * enclosed_volume(mesh));
}

// Both sides of the plate are nearer to each other than the cubes are wide.
TEST(ClusterVertices, KeepsTheSidesOfAPlateApart) {
  TriangleMesh mesh = ellipsoid(240);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex.z() *= 0.02;
  const TriangleMesh coarse = cluster_vertices(mesh, 0.7);
  EXPECT_LT(coarse.faces.size(), mesh.faces.size() / 5);
  EXPECT_NEAR(surface_area(coarse), surface_area(mesh), 0.02 * surface_area(mesh));
  EXPECT_NEAR(enclosed_volume(coarse), enclosed_volume(mesh), 0.05 * enclosed_volume(mesh));
}

// Without joining clusters it would be hundreds.
TEST(ClusterVertices, FoldsHardlyAnyFace) {
  const TriangleMesh mesh = ellipsoid(240);
  for (const double cell : {0.4, 0.7, 1.1}) {
    const TriangleMesh coarse = cluster_vertices(mesh, cell);
    std::size_t folded = 0;
    for (std::size_t f = 0; f < coarse.faces.size(); ++f) {
      const Eigen::Vector3d away = (coarse.corner(f, 0) - Eigen::Vector3d(500.0, -3.0, 40.0))
                                       .cwiseQuotient(Eigen::Vector3d(900.0, 400.0, 100.0));
      folded += face_cross(coarse, f).dot(away) < 0.0;
    }
    EXPECT_LE(folded, 1u) << cell;
  }
}

TEST(HtmlReport, HoldsASmallModelAsItIs) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = ellipsoid(10);
  write_model(folder, mesh);
  const std::string page = page_of(folder);
  const auto faces = array_of<std::uint32_t>(page, "faces");
  ASSERT_EQ(faces.size(), 3 * mesh.faces.size());
  EXPECT_EQ(std::memcmp(faces.data(), mesh.faces.data(), 4 * faces.size()), 0);
  const ProgramRun printed = run_relief({"report", "-q", "--json", folder.path().string()});
  EXPECT_EQ(printed.standard_output, read_text(folder / "report.json"));
  EXPECT_THAT(page, HasSubstr("What to scan again</h3>\n<ul><li>No view measured a region"));
}

TEST(HtmlReport, IsTheSameOnAnyNumberOfThreads) {
  const TemporaryFolder folder;
  write_model(folder, ellipsoid(40));
  EXPECT_EQ(page_of(folder, {"--threads", "1", "--viewer-faces", "2000"}),
            page_of(folder, {"--threads", "3", "--viewer-faces", "2000"}));
}

TEST(HtmlReport, NamesCannotBreakOut) {
  const TemporaryFolder folder;
  write_model(folder, ellipsoid(10));
  const std::string plain = page_of(folder);
  const std::string name = "</script><script>alert(1)</script> \"'& {{style}}";
  const json pose = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, -90}, {0, 0, 0, 1}};
  const json view = {{"name", name},
                     {"aligned", false},
                     {"reason", "<b>far"},
                     {"world_from_view", pose},
                     {"pose_std", {0, 0, 0, 0, 0, 0}}};
  const json second = {{"name", "b"}, {"aligned", true}, {"world_from_view", pose}};
  const json pair = {{"a", name},      {"b", "b"},       {"rms", 0.1},
                     {"overlap", 0.5}, {"grade", "<i>"}, {"degenerate_directions", {"<u>"}}};
  folder.write("report.json", json{{"relief", "0"},
                                   {"run", {{"input", name}, {"options", {{"--fc", name}}}}},
                                   {"align", {{"views", {view, second}}, {"pairs", {pair}}}}}
                                  .dump());
  folder.write("scan.json", json{{"unit", name}, {"views", {view, second}}}.dump());
  const std::string page = page_of(folder);
  EXPECT_EQ(count(page, "<script"), count(plain, "<script"));
  EXPECT_EQ(count(page, "</script"), count(plain, "</script"));
  for (const char* part : {"<b>far", "<i>", "<u>", "<script>alert"})
    EXPECT_THAT(page, Not(HasSubstr(part)));
  EXPECT_EQ(report_in(page)["align"]["views"][0]["name"], name);
  EXPECT_THAT(page, HasSubstr(escape_html(name)));
  EXPECT_THAT(page, HasSubstr(R"(<span class="badge rescan">rescan</span>)"));
  EXPECT_THAT(page, HasSubstr("It fits nowhere and is not in the model: &lt;b&gt;far."));
}

TEST(HtmlReport, ShowsWhatTheStepsTold) {
  const TemporaryFolder folder;
  write_model(folder, ellipsoid(10));
  EXPECT_THAT(page_of(folder), Not(HasSubstr("<h3>Notes")));
  folder.write("report.json", json{{"relief", "0"},
                                   {"run", {{"notes", {"a.ply: no units"}}}},
                                   {"align", {{"notes", {"<b>ranges differ"}}}},
                                   {"merge", {{"vertices", 1}, {"notes", {"2 handles", 3}}}}}
                                  .dump());
  const std::string page = page_of(folder);
  for (const char* note :
       {"Reading: a.ply: no units.", "Alignment: &lt;b&gt;ranges differ.", "Merging: 2 handles."})
    EXPECT_THAT(page, HasSubstr("<li>" + std::string(note) + "</li>"));
}

// Aligning alone writes a report without a model, and other versions have other keys.
TEST(HtmlReport, TakesIncompleteReports) {
  const TemporaryFolder folder;
  for (
      const char* report :
      {R"({"relief": "0"})", R"({"relief": 1, "align": {"views": "x", "pairs": 3}})",
       R"({"relief": "0", "align": {"views": [1, {}, {"name": 3}], "pairs": [null]}})",
       R"({"relief": "0", "merge": {"vertices": null, "genus": "x"}, "refine": []})",
       R"({"relief": "0", "run": {"options": 3}, "align": {"views": [{"name": "a", "world_from_view": [[1]]}]}})"}) {
    folder.write("report.json", report);
    const std::string page = page_of(folder);
    EXPECT_THAT(page, HasSubstr("There is no model to look at")) << report;
    EXPECT_THAT(page, HasSubstr("</html>")) << report;
  }
}

TEST(HtmlReport, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const ProgramRun none = run_relief({"report", folder.path().string()});
  EXPECT_EQ(none.exit_status, 2);
  EXPECT_THAT(none.standard_error, HasSubstr("report.json"));
  folder.write("report.json", "{}");
  const ProgramRun foreign = run_relief({"report", folder.path().string()});
  EXPECT_EQ(foreign.exit_status, 2);
  EXPECT_THAT(foreign.standard_error, HasSubstr("no report of relief"));
  EXPECT_FALSE(std::filesystem::exists(folder / "report.html"));
}

TEST(HtmlReport, IsNotWrittenIfNotWanted) {
  const TemporaryFolder scans, out;
  ASSERT_EQ(run_relief({"simulate", "-q", "--views", "4", "--width", "64", "--height", "64",
                        "--mesh-divisions", "0", "--poses", "exact", "-o", scans.path().string()})
                .exit_status,
            0);
  const ProgramRun run = run_relief(
      {"run", scans / "scan.json", "--no-html-report", "--no-polish", "-o", out.path().string()});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_TRUE(std::filesystem::exists(out / "report.json"));
  EXPECT_FALSE(std::filesystem::exists(out / "report.html"));
}

TEST(HtmlReport, EmbedsPictures) {
  ReportContent content{ReportFigures(Json::object())};
  EXPECT_EQ(pictures_section(content), "");
  content.pictures = {{"front <lit>", "\x89PNG"}, {"back", "\x01\x02"}};
  const std::string html = pictures_section(content);
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,iVBORw=="));
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,AQI="));
  EXPECT_THAT(html, HasSubstr("<figcaption>front &lt;lit&gt;</figcaption>"));
}

TEST(HtmlReport, FillsEachPlaceOnce) {
  EXPECT_EQ(fill_template("<{{a}}|{{b}}>", {{"a", "{{b}}"}, {"b", "x"}}), "<{{b}}|x>");
  EXPECT_EQ(grouped(1234567), "1\u202f234\u202f567");
  EXPECT_EQ(three_digits(0.0), "0");
  EXPECT_EQ(three_digits(0.002), "0.00200");
  EXPECT_EQ(three_digits(12345.6), "12346");
}

}  // namespace
}  // namespace relief
