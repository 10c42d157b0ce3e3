#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/reports/comparison/run_comparison.h"
#include "apps/reports/html/report_content.h"
#include "relief/scan/result.h"

namespace relief {

/// For each vertex of both models its distance to the other one [unit], negative inside.
struct VertexDistances {
  std::vector<double> a_to_b, b_to_a;
};

VertexDistances vertex_distances(const ComparedModels& models);

/// Pictures of both models from the front and from behind, A's beside B's: lit, then coloured by
/// their distance to each other with a colour bar. `unit` names lengths.
Result<std::vector<ReportPicture>> pictures_of_models(const ComparedModels& models,
                                                      const VertexDistances& distances,
                                                      const std::string& unit);

/// The page, which needs no other file and no network. Every number of it that the report has says
/// its place there, from `/comparison` on. `pictures` stand side by side, two in a row.
std::string comparison_page(const RunComparison& comparison,
                            const std::vector<ReportPicture>& pictures);

/// Writes both models in the frame of A as `a.ply` and `b.ply` into `folder`: `quality` is the
/// vertex's distance to the other model, and so are the colours.
Result<void> write_distance_models(const ComparedModels& models, const VertexDistances& distances,
                                   const std::filesystem::path& folder);

}  // namespace relief
