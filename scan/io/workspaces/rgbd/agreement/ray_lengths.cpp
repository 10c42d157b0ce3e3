#include "scan/io/workspaces/rgbd/agreement/ray_lengths.h"

#include <cstdio>

#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

namespace relief {

void take_ray_lengths(ProjectSpec& project, const ComparedDepths& compared) {
  const auto found = compared.disagreements(project, {{.along_ray = false}, {.along_ray = true}});
  if (!found[0] || !found[1] || !(found[0]->median > kFarBetter * found[1]->median)) return;
  for (ViewSpec& view : project.views)
    if (view.depth) view.depth->along_ray = true;
  char note[200];
  std::snprintf(note, sizeof note,
                "depths are taken as distances along the rays, with which they agree at their "
                "poses to %.2g %% (as distances along the optical axis %.2g %%)",
                100.0 * found[1]->median, 100.0 * found[0]->median);
  project.notes.emplace_back(note);
}

}  // namespace relief
