#pragma once

#include <cstddef>
#include <vector>

#include "relief/scan/range_view.h"

namespace relief {

/// What the costs of the steps, and the progress of `run`, depend on.
struct ProjectSize {
  std::size_t views = 0;
  std::size_t pairs = 0;        ///< Of views that may overlap.
  std::size_t first_pairs = 0;  ///< Of them, those that are searched first where `search`.
  double pixels = 0.0;          ///< Of all views.
  double refined_pixels = 0.0;  ///< Of the parts of views around their samples.
  double samples = 0.0;         ///< Of all views.
  bool search = false;          ///< Whether poses are looked for by shape.
  bool with_normals = false;    ///< Whether any view has normals.
};

/// `ignore_poses`: whether given poses are not used.
ProjectSize size_of(const std::vector<RangeView>& views, bool ignore_poses);

}  // namespace relief
