#include "scan/io/project/project_files.h"

#include <cctype>

namespace relief {

namespace {

namespace fs = std::filesystem;

// Behind the stem of a view, in the files of write_project().
constexpr const char* kViewFileEnds[] = {
    "_depth.tiff", "_normal.tiff", "_confidence.tiff", "_deviation.tiff", "_color.png",
    ".ply",        ".pcd"};

}  // namespace

std::string view_file_stem(const std::string& view, std::set<std::string>& taken) {
  std::string stem;
  for (const unsigned char c : view)
    stem += std::isalnum(c) || c == '-' || c == '_' || (c == '.' && !stem.empty())
                ? static_cast<char>(c)
                : '_';
  std::string unique = stem;
  for (int n = 2; !taken.insert(unique).second; ++n) unique = stem + "_" + std::to_string(n);
  return unique;
}

std::vector<fs::path> files_read_for(const ProjectSpec& project) {
  std::vector<fs::path> files;
  if (!project.file.empty()) files.push_back(project.file);
  for (const ViewSpec& view : project.views) {
    if (view.depth) files.push_back(view.depth->file);
    if (view.grid) files.push_back(*view.grid);
    if (view.normals) files.push_back(view.normals->file);
    if (view.deviation) files.push_back(view.deviation->file);
    for (const auto& image : {view.mask, view.confidence, view.colour})
      if (image) files.push_back(image->file);
  }
  return files;
}

bool needs_grid_file(const RangeView& view) {
  return view.camera.model() == Camera::Model::kRayTable ||
         view.camera.model() == Camera::Model::kSpherical ||
         (view.camera.model() == Camera::Model::kOrthographic && view.has_normals());
}

std::vector<fs::path> files_written_for(const ProjectSpec& project, const fs::path& folder) {
  std::vector<fs::path> files{folder / "scan.json"};
  std::set<std::string> stems;
  for (const ViewSpec& view : project.views) {
    const std::string stem = view_file_stem(view.name, stems);
    for (const char* end : kViewFileEnds) files.push_back(folder / (stem + end));
  }
  return files;
}

}  // namespace relief
