#include "apps/reports/html/html_report.h"

#include <utility>

#include "apps/console/console.h"
#include "apps/reports/html/html_text.h"
#include "apps/reports/html/model_pictures.h"
#include "apps/reports/html/page_assets.h"
#include "apps/reports/html/page_frame.h"
#include "apps/reports/html/views/view_pictures.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

namespace {

bool in_the_model(const ReportFigures& report, const std::string& name) {
  const std::string entry = report.entry_of(report.alignment() + "/views", name);
  return entry.empty() || report.truth(entry + "/aligned").value_or(true);
}

std::vector<ViewCamera> cameras_of(const Json* views, const ReportFigures& report) {
  std::vector<ViewCamera> cameras;
  if (!views || !views->is_array()) return cameras;
  for (const Json& view : *views)
    if (auto camera = view_camera(view); camera && in_the_model(report, camera->name))
      cameras.push_back(std::move(*camera));
  return cameras;
}

void put_model(const TriangleMesh* mesh, std::size_t faces, ReportContent& content) {
  if (!mesh) {
    content.no_viewer = "the folder has no model";
    return;
  }
  if (!mesh->vertices.empty() && !mesh->faces.empty()) content.model = measure_model(*mesh);
  if (faces == 0) {
    content.no_viewer = "the page was made without a model";
    return;
  }
  auto viewer = make_viewer_model(*mesh, faces);
  if (viewer)
    content.viewer = std::move(*viewer);
  else
    content.no_viewer = viewer.error().message;
}

std::string script_data(const char* id, const std::string& base64) {
  return std::string(R"(<script type="application/octet-stream" id=")") + id + "\">" + base64 +
         "</script>\n";
}

std::string viewer_data(const ReportContent& content) {
  if (!content.viewer) return "";
  const ViewerModel& model = *content.viewer;
  Json json = to_json(model);
  json["unit"] = content.unit;
  if (!model.sources.empty()) json["sources"] = content.source_names;
  Json& cameras = json["cameras"] = Json::array();
  for (const ViewCamera& camera : content.cameras) cameras.push_back(to_json(camera));
  for (const auto& [key, vector] : {std::pair("towards_viewer", content.viewpoint.towards_viewer),
                                    std::pair("up", content.viewpoint.up)})
    json[key] = {vector.x(), vector.y(), vector.z()};
  return R"(<script type="application/json" id="viewer-data">)" +
         escape_script_json(json.dump(-1, ' ', true, Json::error_handler_t::replace)) +
         "</script>\n" + script_data("viewer-positions", base64_of(model.positions)) +
         script_data("viewer-faces", base64_of(model.faces)) +
         script_data("viewer-errors", base64_of(model.errors)) +
         script_data("viewer-views", base64_of(model.views)) +
         script_data("viewer-sources", base64_of(model.sources)) +
         script_data("viewer-filled", base64_of(model.filled)) +
         script_data("viewer-colours", base64_of(model.colours));
}

std::string script(std::string_view source) {
  return "<script>" + std::string(source) + "</script>\n";
}

std::string viewer_section(const ReportContent& content) {
  if (!content.viewer)
    return "<section id=\"viewer\"><h2>Model in 3-D</h2>\n<p class=\"no-viewer\">There is no model "
           "to look at: " +
           escape_html(content.no_viewer) + ".</p></section>\n";
  return std::string(page_assets::viewer_html());
}

std::string viewer_scripts(const ReportContent& content) {
  if (!content.viewer) return "";
  return viewer_data(content) + script(page_assets::three_js()) +
         script(page_assets::orbit_controls_js()) + script(page_assets::model_js()) +
         script(page_assets::scene_js()) + script(page_assets::viewer_js());
}

std::string name_of(const std::filesystem::path& folder) {
  // The dot stands for no name: a folder may be given as `.` or with a slash at its end.
  return (std::filesystem::absolute(folder) / ".").lexically_normal().parent_path().filename();
}

// three.js says in its source which release it is.
std::string three_release() {
  constexpr std::string_view kName = "REVISION=\"";
  const std::string_view source = page_assets::three_js();
  const std::size_t start = source.find(kName);
  if (start == std::string_view::npos) return "";
  const std::string_view rest = source.substr(start + kName.size());
  return " r" + std::string(rest.substr(0, rest.find('"')));
}

std::string credit(const ReportContent& content) {
  if (!content.viewer) return "";
  const std::size_t bytes =
      page_assets::three_js().size() + page_assets::orbit_controls_js().size();
  return " The viewer is drawn with three.js" + three_release() + " (MIT licence, " +
         std::to_string((bytes + 500) / 1000) + " kB of this page; its source has the licence).";
}

void put_view_pictures(const std::filesystem::path& folder, ReportContent& content) {
  const ReportFigures& report = content.report;
  for (const std::string& view : report.entries("/refine/views")) {
    for (const auto& [key, title] :
         {std::pair("measured", "As measured"), std::pair("refined", "Refined")}) {
      std::string png = named_picture(folder, report.text(view + "/pictures/" + key));
      if (!png.empty())
        content.view_pictures[report.text(view + "/name")].push_back({title, std::move(png)});
    }
  }
}

void put_source_names(const Json& views, ReportContent& content) {
  if (!views.is_array()) return;
  for (const Json& view : views)
    content.source_names.push_back(view.is_object() && view.contains("name") &&
                                           view["name"].is_string()
                                       ? view["name"].get<std::string>()
                                       : "");
}

void put_pictures(const TriangleMesh& mesh, ReportContent& content) {
  auto pictures = pictures_of_model(mesh, content.viewpoint, content.unit);
  if (pictures)
    content.pictures = std::move(*pictures);
  else
    Console::warning("report.html has no pictures: " + pictures.error().message);
}

}  // namespace

ReportContent report_content(Json report, const Json& project, const TriangleMesh* mesh,
                             const HtmlReportOptions& options) {
  ReportContent content{ReportFigures(std::move(report))};
  const bool has_project = project.is_object();
  if (has_project && project.contains("unit") && project["unit"].is_string())
    content.unit = project["unit"];
  content.views = grade_views(content.report);
  if (has_project && project.contains("views")) {
    content.cameras = cameras_of(&project["views"], content.report);
    put_source_names(project["views"], content);
  }
  if (content.cameras.empty())
    content.cameras =
        cameras_of(content.report.find(content.report.alignment() + "/views"), content.report);
  if (mesh) content.viewpoint = initial_viewpoint(*mesh, content.cameras);
  put_model(mesh, options.viewer_faces, content);
  return content;
}

std::string html_page(const ReportContent& content) {
  return fill_page(
      {.title = content.name,
       .kind = "report",
       .sections = {summary_section(content), viewer_section(content), pictures_section(content),
                    views_section(content), alignment_section(content), model_section(content),
                    provenance_section(content)},
       .figures = content.report.json(),
       .exact = "those of report.json, which is part of this page",
       .credit = credit(content),
       .scripts = viewer_scripts(content)});
}

Result<void> write_html_report(const HtmlReportFiles& files, const TriangleMesh* mesh,
                               const HtmlReportOptions& options) {
  const auto text = read_file(files.report);
  if (!text) return text.error();
  Json report = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!report.is_object() || !report.contains("relief"))
    return Error{ErrorKind::kBadInput,
                 files.report.string() + ": this is no report of relief: `relief run` writes one"};
  Json project;
  if (const auto scan = read_file(files.folder / "scan.json"))
    project = Json::parse(*scan, nullptr, /*allow_exceptions=*/false);
  ReportContent content = report_content(std::move(report), project, mesh, options);
  content.name = name_of(files.folder);
  if (mesh) put_pictures(*mesh, content);
  put_view_pictures(files.folder, content);
  if (mesh && options.viewer_faces > 0 && !content.viewer)
    Console::warning("report.html has no model to look at: " + content.no_viewer);
  if (auto written = write_file(files.page, html_page(content)); !written) return written;
  Console::info("wrote " + files.page.string());
  return {};
}

void add_html_report_options(CLI::App& command, HtmlReportOptions& options) {
  command
      .add_option("--viewer-faces", options.viewer_faces,
                  "Faces of the model in report.html, at most; 0: no model in it")
      ->check(CLI::Range(std::size_t{0}, std::size_t{5000000}))
      ->capture_default_str();
}

}  // namespace relief
