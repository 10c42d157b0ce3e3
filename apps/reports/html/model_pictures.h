#pragma once

#include <string>
#include <vector>

#include "apps/reports/html/report_content.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// Pictures of a model for its page, all from where `viewpoint` says: lit from the front and from
/// the side, what was filled, and the expected error, each where the mesh has what it shows. `unit`
/// names lengths; it may be empty. Errors: those of rendering::MeshScene::of.
Result<std::vector<ReportPicture>> pictures_of_model(const TriangleMesh& mesh,
                                                     const InitialViewpoint& viewpoint,
                                                     const std::string& unit);

}  // namespace relief
