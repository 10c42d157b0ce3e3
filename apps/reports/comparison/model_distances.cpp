#include <array>
#include <utility>

#include <fmt/format.h>

#include "apps/console/console.h"
#include "apps/console/picture_file.h"
#include "apps/reports/comparison/comparison_page.h"
#include "relief/rendering/picture.h"
#include "relief/rendering/picture_camera.h"
#include "relief/rendering/render_mesh.h"
#include "scan/evaluation/base/error_colours.h"
#include "scan/io/meshes/coloured_mesh.h"

namespace relief {

namespace {

using rendering::MeshScene;
using rendering::PictureCamera;
using rendering::RenderStyle;

// One that sees all of both models, so that their pictures can be laid over each other.
PictureCamera camera_for(const ComparedModels& models, double azimuth_deg) {
  TriangleMesh both;
  both.vertices = models.a.vertices;
  both.vertices.insert(both.vertices.end(), models.b.vertices.begin(), models.b.vertices.end());
  rendering::FramingOptions framing;
  framing.width = 640;
  framing.height = 480;
  rendering::ViewingDirection direction;
  direction.azimuth_deg = azimuth_deg;
  return rendering::frame_mesh(both, direction, framing);
}

Result<ReportPicture> picture(const MeshScene& scene, const PictureCamera& camera,
                              RenderStyle style, const rendering::RenderOptions& options,
                              const std::string& title) {
  auto rendering = scene.render(camera, style, options);
  if (!rendering) return rendering.error();
  const auto shown = rendering->legend ? with_legend(rendering->picture, *rendering->legend,
                                                     rendering::Background::kWhite)
                                       : std::move(rendering->picture);
  auto png = png_of(shown, rendering::Background::kWhite, title);
  if (!png) return png.error();
  return ReportPicture{title, std::move(*png)};
}

Result<void> write_model(TriangleMesh mesh, const std::vector<double>& distances, double scale,
                         const std::filesystem::path& file) {
  mesh.quality.assign(distances.begin(), distances.end());
  const std::string comment = fmt::format(
      "quality: distance to the other model, negative inside; colours: blue {:.6g}, grey 0, red "
      "{:.6g}",
      -scale, scale);
  auto written =
      write_coloured_mesh(mesh, evaluation::colours_of_errors(distances, scale), comment, file);
  if (written) Console::info("wrote " + file.string() + ": " + comment);
  return written;
}

}  // namespace

VertexDistances vertex_distances(const ComparedModels& models) {
  return {evaluation::signed_distances(models.a, models.b),
          evaluation::signed_distances(models.b, models.a)};
}

Result<std::vector<ReportPicture>> pictures_of_models(const ComparedModels& models,
                                                      const VertexDistances& distances,
                                                      const std::string& unit) {
  const auto a = MeshScene::of(models.a), b = MeshScene::of(models.b);
  if (!a) return a.error();
  if (!b) return b.error();
  rendering::RenderOptions of_a;
  of_a.unit = unit;
  of_a.range = {-models.colour_scale, models.colour_scale};
  rendering::RenderOptions of_b = of_a;
  of_a.distances = distances.a_to_b;
  of_b.distances = distances.b_to_a;
  std::vector<ReportPicture> pictures;
  const double front = rendering::ViewingDirection().azimuth_deg;
  for (const auto& [azimuth_deg, where] :
       {std::pair(front, ""), std::pair(front + 180.0, ", from behind")}) {
    const PictureCamera camera = camera_for(models, azimuth_deg);
    for (const auto& [style, what_a, what_b] :
         {std::tuple(RenderStyle::kShaded, "A", "B"),
          std::tuple(RenderStyle::kDistance, "A, distance to B", "B, distance to A")}) {
      for (auto shown : {picture(*a, camera, style, of_a, std::string(what_a) + where),
                         picture(*b, camera, style, of_b, std::string(what_b) + where)}) {
        if (!shown) return shown.error();
        pictures.push_back(std::move(*shown));
      }
    }
  }
  return pictures;
}

Result<void> write_distance_models(const ComparedModels& models, const VertexDistances& distances,
                                   const std::filesystem::path& folder) {
  const double scale = models.colour_scale;
  if (auto done = write_model(models.a, distances.a_to_b, scale, folder / "a.ply"); !done)
    return done;
  return write_model(models.b, distances.b_to_a, scale, folder / "b.ply");
}

}  // namespace relief
