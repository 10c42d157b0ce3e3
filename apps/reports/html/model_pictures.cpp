#include "apps/reports/html/model_pictures.h"

#include <utility>

#include "apps/console/picture_file.h"
#include "relief/rendering/picture.h"
#include "relief/rendering/picture_camera.h"
#include "relief/rendering/render_mesh.h"

namespace relief {

Result<std::vector<ReportPicture>> pictures_of_model(const TriangleMesh& mesh,
                                                     const InitialViewpoint& viewpoint,
                                                     const std::string& unit) {
  using rendering::RenderStyle;
  const auto scene = rendering::MeshScene::of(mesh);
  if (!scene) return scene.error();
  std::vector<std::pair<RenderStyle, std::string>> shown{
      {RenderStyle::kShaded, "Lit from the front"}, {RenderStyle::kGrazing, "Grazing light"}};
  if (!mesh.filled.empty()) shown.emplace_back(RenderStyle::kFilled, "Measured and filled");
  if (!mesh.quality.empty()) shown.emplace_back(RenderStyle::kExpectedError, "Expected error");
  rendering::FramingOptions framing;
  framing.width = 640;
  framing.height = 480;
  framing.up = viewpoint.up;
  const auto camera = rendering::frame_mesh(
      mesh, rendering::viewing_direction(viewpoint.towards_viewer, viewpoint.up), framing);
  rendering::RenderOptions options;
  options.unit = unit;
  std::vector<ReportPicture> pictures;
  for (const auto& [style, title] : shown) {
    auto rendering = scene->render(camera, style, options);
    if (!rendering) return rendering.error();
    const auto picture = rendering->legend ? with_legend(rendering->picture, *rendering->legend,
                                                         rendering::Background::kWhite)
                                           : std::move(rendering->picture);
    auto png = png_of(picture, rendering::Background::kWhite, title);
    if (!png) return png.error();
    pictures.push_back({title, std::move(*png)});
  }
  return pictures;
}

}  // namespace relief
