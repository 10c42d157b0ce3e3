#include "scan/io/project/ptx_views.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/files/file_ending.h"

namespace relief {

namespace {

bool is_ptx(const ViewSpec& view) { return view.grid && lower_ending(*view.grid) == ".ptx"; }

void find_places(ProjectSpec& project) {
  std::map<std::filesystem::path, std::vector<PtxScan>> files;
  for (ViewSpec& view : project.views) {
    if (!is_ptx(view) || view.grid_options.ptx) continue;
    const auto [file, added] = files.try_emplace(*view.grid);
    if (added)
      if (auto listed = list_ptx_scans(*view.grid)) file->second = std::move(*listed);
    const auto scan = static_cast<std::size_t>(view.grid_options.scan);
    if (view.grid_options.scan >= 0 && scan < file->second.size())
      view.grid_options.ptx = file->second[scan];
  }
}

// Two scanners do not stand in one place: several scans with the identity are not registered.
void take_pose_of_reference(ProjectSpec& project) {
  ViewSpec* reference = nullptr;
  std::size_t posed = 0, others = 0;
  for (ViewSpec& view : project.views) {
    const bool tells = view.grid_options.ptx && view.grid_options.ptx->has_pose;
    if (view.pose != PoseKind::kAbsent || view.grid_options.ignore_pose || tells) {
      ++posed;
    } else if (view.grid_options.ptx) {
      reference = &view;
      ++others;
    } else {
      return;
    }
  }
  if (others != 1 || posed == 0 || reference->grid_options.shared_frame) return;
  reference->grid_options.shared_frame = true;
  project.notes.push_back("view " + reference->name +
                          ": its matrix is the identity, which is taken as its pose, since all "
                          "others have one");
}

}  // namespace

void complete_ptx_views(ProjectSpec& project) {
  find_places(project);
  take_pose_of_reference(project);
}

}  // namespace relief
