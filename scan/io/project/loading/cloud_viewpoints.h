#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scan/io/project/loading/view_loader.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// Of views whose sides were found from their points alone, those that are better seen from the
/// origin of their frame: where more clouds were taken as seen from there, all come from sensors
/// that leave their clouds so.
std::vector<std::size_t> views_to_see_from_origin(const std::vector<FoundSide>& sides);

/// The side of a view as it counts for its set. Points in a frame that is not the sensor's own, as
/// that of a file or one shared by all, tell nothing: kGiven.
FoundSide side_in_set(const ViewSpec& spec, const LoadedView& loaded);

/// Reads a view once more with the origin as its viewpoint, and notes it in the spec. False, with
/// nothing changed, where that view holds a fifth fewer of the points, or where its normals look
/// away from the origin.
bool see_from_origin(ViewSpec& spec, LoadedView& loaded);

/// The same for all of them, where only specs are kept. Reads one view at a time, and only files of
/// points whose specs have no viewpoint. Those that cannot be read are passed over. Returns notes.
std::vector<std::string> settle_viewpoints(std::vector<ViewSpec>& specs);

}  // namespace relief
