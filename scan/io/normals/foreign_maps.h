#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "scan/io/normals/convention_choice.h"
#include "scan/io/normals/normal_evidence.h"

namespace relief {

/// The normals of one view in the convention chosen for them.
struct SettledNormals {
  ChosenConvention chosen;
  bool certain = true;    ///< No other convention fits that would make much of a difference.
  double bias = 0.0;      ///< [rad]
  bool compared = false;  ///< With enough of the depth.
};

/// A normal map that does not belong to the depth of its view.
struct ForeignMap {
  std::size_t view = 0;              ///< Index into the evidence of all views.
  std::optional<std::size_t> other;  ///< The view whose depth it fits instead.
};

/// The maps that no convention brings near the depth of their views, those beyond the bias of a
/// sensor that are twice as near to the depth of another view, and those that lie wrong on their
/// own, in the order of the views.
std::vector<ForeignMap> find_foreign_maps(const std::vector<NormalEvidence>& views,
                                          const std::vector<SettledNormals>& settled);

/// A warning that names them. kBadInput where more maps are far off than fit: then something else
/// is wrong, as the scale of all depths.
Result<std::string> judge_foreign_maps(const std::vector<ForeignMap>& foreign,
                                       const std::vector<NormalEvidence>& views,
                                       const std::vector<SettledNormals>& settled);

}  // namespace relief
