#include "apps/commands/render/render_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/console/console.h"
#include "relief/evaluation/mesh_errors.h"
#include "relief/io/mesh_io.h"

namespace relief {

namespace {

using rendering::MeshScene;
using rendering::PictureCamera;
using rendering::RenderStyle;

const Error kStopped{ErrorKind::kInterrupted, "rendering stopped"};

Error in_file(const std::filesystem::path& file, const Error& error) {
  return {error.kind, file.string() + ": " + error.message};
}

// Words of a caption with commas between them, without those that are empty.
std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words)
    if (!word.empty()) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// Directions or views are rows, styles of all inputs columns. Of one direction the inputs are rows.
// What would be a single row or column becomes a square.
int columns_for(std::size_t directions, std::size_t inputs, std::size_t styles) {
  const std::size_t columns = inputs * styles;
  if (directions > 1 && columns > 1) return static_cast<int>(columns);
  if (directions == 1 && inputs > 1 && styles > 1) return static_cast<int>(styles);
  const std::size_t cells = directions * columns;
  if (columns > 1 && cells <= 4) return static_cast<int>(cells);
  return static_cast<int>(std::ceil(std::sqrt(static_cast<double>(cells))));
}

Result<TriangleMesh> read_truth(const RenderFlags& flags) {
  if (!flags.shows(RenderStyle::kDistance)) return TriangleMesh();
  if (flags.truth.empty())
    return Error{ErrorKind::kBadInput,
                 "the style distance measures against a mesh: name it with --truth"};
  auto truth = read_mesh(flags.truth);
  if (truth && truth->faces.empty())
    return Error{ErrorKind::kBadInput,
                 flags.truth.string() + ": has no faces: give a surface, not points"};
  return truth;
}

Result<RenderModel> read_model(const std::filesystem::path& file, const TriangleMesh& truth) {
  auto mesh = read_mesh(file);
  if (!mesh) return mesh.error();
  auto scene = MeshScene::of(*std::move(mesh));
  if (!scene) return in_file(file, scene.error());
  std::vector<double> distances;
  if (!truth.faces.empty()) distances = evaluation::signed_distances(scene->mesh(), truth);
  return RenderModel{file, *std::move(scene), std::move(distances)};
}

std::string style_name(RenderStyle style, const RenderFlags& flags) {
  return flags.styles.size() > 1 ? std::string(to_string(style)) : "";
}

// The views to show, by their names in the first project.
Result<std::vector<const RangeView*>> chosen_views(const RenderProject& first,
                                                   const RenderFlags& flags) {
  std::vector<const RangeView*> views;
  for (const std::string& name : flags.only) {
    views.push_back(find_view(first.project, name));
    if (!views.back())
      return Error{ErrorKind::kBadInput, first.file.string() + ": has no view " + name +
                                             "; 'relief info' lists the views"};
  }
  if (flags.only.empty())
    for (const RangeView& view : first.project.views) views.push_back(&view);
  return views;
}

rendering::ShadingNormals normals_of_view(RenderStyle style, const RenderFlags& flags) {
  if (flags.normals) return *flags.normals;
  return style == RenderStyle::kNormals ? rendering::ShadingNormals::kOwn
                                        : rendering::ShadingNormals::kGeometry;
}

// The camera of `view`, cut like that of the view it is compared with where the grids are alike.
PictureCamera camera_of(const RangeView& view, const RangeView& first, const RenderFlags& flags) {
  const bool alike = view.width() == first.width() && view.height() == first.height();
  PictureCamera camera =
      rendering::frame_view(alike ? first : view, flags.framing.width, flags.framing.height);
  camera.camera = view.camera;
  camera.world_from_camera = view.world_from_view;
  return camera;
}

RenderCell empty_cell(const PictureCamera& camera, const std::string& caption,
                      const RenderFlags& flags) {
  return {
      rendering::Picture(camera.width, camera.height, background_colour(flags.options.background)),
      caption + ": no connected samples", std::nullopt};
}

// One view of one project in all styles.
Result<std::vector<RenderCell>> view_cells(const RenderProject& project, const RangeView& view,
                                           const PictureCamera& camera, const std::string& caption,
                                           const RenderFlags& flags) {
  std::vector<RenderCell> cells;
  TriangleMesh surface = rendering::surface_of_view(view);
  const bool empty = surface.faces.empty();
  if (empty)
    Console::warning(project.file.string() + ": view " + view.name +
                     " has no connected samples, its picture is empty");
  const auto scene = empty ? Result<MeshScene>(kStopped) : MeshScene::of(std::move(surface));
  if (!empty && !scene) return in_file(project.file, scene.error());
  for (const RenderStyle style : flags.styles) {
    const std::string text = joined({caption, style_name(style, flags)});
    if (empty) {
      cells.push_back(empty_cell(camera, text, flags));
      continue;
    }
    rendering::RenderOptions options = flags.options;
    options.unit = project.project.unit;
    options.normals = normals_of_view(style, flags);
    auto rendering = scene->render(camera, style, options);
    if (!rendering)
      return Error{rendering.error().kind, project.file.string() + ": view " + view.name + ": " +
                                               rendering.error().message};
    cells.push_back({std::move(rendering->picture), text, std::move(rendering->legend)});
  }
  return cells;
}

}  // namespace

Result<std::vector<RenderModel>> read_models(const std::vector<std::filesystem::path>& files,
                                             const RenderFlags& flags) {
  const auto truth = read_truth(flags);
  if (!truth) return truth.error();
  std::vector<RenderModel> models;
  for (const auto& file : files) {
    auto model = read_model(file, *truth);
    if (!model) return model.error();
    models.push_back(*std::move(model));
  }
  return models;
}

Result<RenderSheet> model_sheet(const std::vector<RenderModel>& models,
                                const std::vector<PictureCamera>& cameras,
                                const std::vector<std::string>& camera_names,
                                const RenderFlags& flags, const Progress& progress) {
  const std::size_t columns = models.size() * flags.styles.size();
  RenderSheet sheet{{}, columns_for(cameras.size(), models.size(), flags.styles.size())};
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    for (const RenderModel& model : models) {
      for (const RenderStyle style : flags.styles) {
        const double done =
            static_cast<double>(sheet.cells.size()) / static_cast<double>(cameras.size() * columns);
        if (!report_progress(progress, done, "render")) return kStopped;
        rendering::RenderOptions options = flags.options;
        options.normals = flags.normals.value_or(options.normals);
        options.distances = model.distances;
        auto rendering = model.scene.render(cameras[i], style, options);
        if (!rendering) return in_file(model.file, rendering.error());
        sheet.cells.push_back({std::move(rendering->picture),
                               joined({models.size() > 1 ? model.file.filename().string() : "",
                                       camera_names[i], style_name(style, flags)}),
                               std::move(rendering->legend)});
      }
    }
  }
  return sheet;
}

Result<RenderSheet> view_sheet(const std::vector<RenderProject>& projects, const RenderFlags& flags,
                               const Progress& progress) {
  const auto views = chosen_views(projects.front(), flags);
  if (!views) return views.error();
  RenderSheet sheet{{}, columns_for(views->size(), projects.size(), flags.styles.size())};
  for (std::size_t i = 0; i < views->size(); ++i) {
    const RangeView& first = *(*views)[i];
    const double done = static_cast<double>(i) / static_cast<double>(views->size());
    if (!report_progress(progress, done, "render")) return kStopped;
    for (const RenderProject& project : projects) {
      const RangeView* view = find_view(project.project, first.name);
      if (!view)
        return Error{ErrorKind::kBadInput, project.file.string() + ": has no view " + first.name +
                                               " as " + projects.front().file.string() +
                                               " has; choose views of both with --only"};
      const std::string source =
          projects.size() > 1 ? project.file.parent_path().filename().string() : "";
      auto cells = view_cells(project, *view, camera_of(*view, first, flags),
                              joined({view->name, source}), flags);
      if (!cells) return cells.error();
      std::move(cells->begin(), cells->end(), std::back_inserter(sheet.cells));
    }
  }
  return sheet;
}

rendering::Picture compose(const RenderSheet& sheet, const RenderFlags& flags) {
  const rendering::Background background = flags.options.background;
  std::vector<rendering::Picture> pictures;
  for (const RenderCell& cell : sheet.cells) {
    rendering::Picture picture = cell.picture;
    if (!flags.no_legend && sheet.cells.size() > 1)
      picture = with_caption(picture, cell.caption, background);
    if (!flags.no_legend && cell.legend) picture = with_legend(picture, *cell.legend, background);
    pictures.push_back(std::move(picture));
  }
  return contact_sheet(pictures, sheet.columns, background);
}

std::string describe(const RenderSheet& sheet) {
  std::string text;
  for (const RenderCell& cell : sheet.cells) {
    const std::string legend = cell.legend ? describe(*cell.legend) : "";
    const std::string line = joined({cell.caption, legend});
    if (!line.empty()) text += (text.empty() ? "" : "\n") + line;
  }
  return text;
}

}  // namespace relief
