#include "apps/commands/convert/export_views.h"

#include <algorithm>
#include <map>

#include "apps/console/console.h"
#include "relief/io/mesh_io.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/grids/pcd_grid_writer.h"
#include "scan/io/project/poses/pose_files.h"
#include "scan/io/project/project_files.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

TriangleMesh concatenate(const ScanProject& project) {
  TriangleMesh all;
  const bool all_have_normals =
      std::all_of(project.views.begin(), project.views.end(),
                  [](const RangeView& view) { return view.has_normals(); });
  const bool all_have_colours =
      std::all_of(project.views.begin(), project.views.end(),
                  [](const RangeView& view) { return !view.colours.empty(); });
  for (const RangeView& view : project.views) {
    const TriangleMesh mesh = mesh_from_view(view);
    const auto offset = static_cast<std::uint32_t>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    if (all_have_normals)
      all.normals.insert(all.normals.end(), mesh.normals.begin(), mesh.normals.end());
    if (all_have_colours)
      all.colours.insert(all.colours.end(), mesh.colours.begin(), mesh.colours.end());
    for (const auto& face : mesh.faces)
      all.faces.push_back({face[0] + offset, face[1] + offset, face[2] + offset});
  }
  return all;
}

Result<void> check_pcd(std::size_t views, const fs::path& path) {
  if (views == 1 || lower_ending(path) != ".pcd") return {};
  return Error{ErrorKind::kBadInput, path.string() + ": a PCD file holds one view, the project " +
                                         std::to_string(views) +
                                         "; 'relief convert --pcd -o FOLDER' writes one for each"};
}

Result<void> write_pcd(const ScanProject& project, const fs::path& path) {
  if (const auto one = check_pcd(project.views.size(), path); !one) return one.error();
  return write_file(path, encode_pcd_grid(project.views[0]));
}

}  // namespace

double metres_in(const std::string& unit) {
  static const std::map<std::string, double> kMetres = {
      {"um", 1e-6}, {"mm", 1e-3},   {"cm", 1e-2},   {"dm", 1e-1},
      {"km", 1e3},  {"in", 0.0254}, {"ft", 0.3048}, {"inch", 0.0254}};
  const auto found = kMetres.find(unit);
  return found == kMetres.end() ? 1.0 : found->second;
}

bool is_export_path(const fs::path& path) {
  const std::string ending = lower_ending(path);
  return ending == ".e57" || ending == ".ptx" || ending == ".pcd" || is_pose_path(path) ||
         is_mesh_path(path);
}

Result<void> export_views(const ScanProject& project, const fs::path& source,
                          const ReadProjectOptions& source_options, const fs::path& path) {
  const std::string ending = lower_ending(path);
  if (ending == ".e57") return write_e57(project.views, path, metres_in(project.unit));
  if (ending == ".ptx") return write_ptx(project.views, path, metres_in(project.unit));
  if (ending == ".pcd") return write_pcd(project, path);
  if (is_pose_path(path)) return write_pose_file(project, source, source_options, path);
  return write_mesh(concatenate(project), path);
}

void add_export_option(CLI::App& command, std::vector<fs::path>& files) {
  command
      .add_option("--export", files,
                  "Also write the views or their poses for other programs: .e57 .ptx .pcd .aln "
                  ".conf .mlp .log .tum, or a mesh; may be given several times")
      ->check([](const std::string& file) {
        return is_export_path(file) ? std::string() : file + ": no format has this ending";
      });
}

Result<void> check_exports(const ScanProject& project, const fs::path& source,
                           const ReadProjectOptions& source_options,
                           const std::vector<fs::path>& files) {
  for (const fs::path& file : files) {
    if (auto one = check_pcd(project.views.size(), file); !one) return one;
    if (auto grids = check_pose_file(project, source, source_options, file); !grids) return grids;
  }
  return {};
}

Result<void> check_exports_of_results(const std::vector<RangeView>& views,
                                      const std::vector<fs::path>& files) {
  const bool images = !std::ranges::all_of(views, needs_grid_file);
  for (const fs::path& file : files) {
    if (auto one = check_pcd(views.size(), file); !one) return one;
    if (images && names_grid_files(file))
      return Error{ErrorKind::kBadInput,
                   file.string() +
                       ": such a file names range grids, and the refined views are images: first "
                       "'relief convert --grids DIR/scan.json -o FOLDER' of the result, then "
                       "convert FOLDER/scan.json"};
  }
  return {};
}

Result<void> export_all(const ScanProject& project, const fs::path& source,
                        const ReadProjectOptions& source_options,
                        const std::vector<fs::path>& files) {
  for (const fs::path& file : files) {
    if (auto done = export_views(project, source, source_options, file); !done) return done;
    Console::info("wrote " + file.string());
  }
  return {};
}

}  // namespace relief
