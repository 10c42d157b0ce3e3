#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/options/render_flags.h"
#include "relief/rendering/picture.h"
#include "relief/rendering/render_mesh.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/scan_project.h"

namespace relief {

/// One picture of a sheet.
struct RenderCell {
  rendering::Picture picture;
  std::string caption;
  std::optional<rendering::Legend> legend;
};

/// The pictures of one file, row by row.
struct RenderSheet {
  std::vector<RenderCell> cells;
  int columns = 1;
};

/// A mesh that is ready for its pictures, and the file it came from.
struct RenderModel {
  std::filesystem::path file;
  rendering::MeshScene scene;
  std::vector<double> distances;  ///< Of the vertices to --truth; empty without it.
};

struct RenderProject {
  std::filesystem::path file;
  ScanProject project;
};

/// Reads the meshes, and measures them against --truth where a style shows the distance.
Result<std::vector<RenderModel>> read_models(const std::vector<std::filesystem::path>& files,
                                             const RenderFlags& flags);

/// The models as seen by `cameras`, in all styles. Each camera is a row, each model and style a
/// column; for one camera each model is a row. A single row or column is laid out as a square.
/// Errors name the file.
Result<RenderSheet> model_sheet(const std::vector<RenderModel>& models,
                                const std::vector<rendering::PictureCamera>& cameras,
                                const std::vector<std::string>& camera_names,
                                const RenderFlags& flags, const Progress& progress);

/// The views of the first project, those of the same names in the others, each by its own camera
/// and in all styles, laid out as above. Errors name the file and the view.
Result<RenderSheet> view_sheet(const std::vector<RenderProject>& projects, const RenderFlags& flags,
                               const Progress& progress);

/// All cells in one picture, with captions where there are several, and legends.
rendering::Picture compose(const RenderSheet& sheet, const RenderFlags& flags);

/// What the cells show, in words, one line each.
std::string describe(const RenderSheet& sheet);

}  // namespace relief
