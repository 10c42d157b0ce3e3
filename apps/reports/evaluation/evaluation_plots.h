#pragma once

#include <filesystem>
#include <string>

#include "relief/evaluation/mesh_errors.h"
#include "relief/evaluation/view_errors.h"
#include "relief/scan/result.h"
#include "scan/evaluation/views/view_error_maps.h"

namespace relief {

// Each of these writes into `folder` the data as tab-separated text (.tsv, columns named in the
// first line; .f32 for images), the gnuplot script (.gp), and what gnuplot makes of it. `unit` is
// that of the lengths.

/// spectra.svg: error power of positions and normals against spatial frequency.
Result<void> plot_spectra(const evaluation::ViewSpectra& spectra, const std::string& unit,
                          const std::filesystem::path& folder);

/// distances.svg: the fraction of each surface within a distance of the other; histogram.svg: the
/// signed errors of the result.
Result<void> plot_distances(const evaluation::MeshComparison& comparison, const std::string& unit,
                            const std::filesystem::path& folder);

/// NAME-depth.png, NAME-geometry-normals.png and NAME-map-normals.png: the errors of each pixel of
/// a view, with their scale.
Result<void> plot_error_maps(const evaluation::ViewErrorMaps& maps, const std::string& unit,
                             const std::filesystem::path& folder);

}  // namespace relief
