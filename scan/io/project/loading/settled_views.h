#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "relief/scan/rigid_motion.h"
#include "scan/io/project/loading/view_loader.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// Of views whose viewpoints were found from their points alone, those that are better seen from
/// the origin of their frame: where more clouds were taken as seen from there, all come from
/// sensors that leave their clouds so.
std::vector<std::size_t> views_to_see_from_origin(const std::vector<AssumedViewpoint>& viewpoints);

/// The viewpoint of a view as it counts for its set. Points in a frame that is not the sensor's
/// own, as that of a file or one shared by all, tell nothing: kNone.
AssumedViewpoint viewpoint_in_set(const ViewSpec& spec, const LoadedView& loaded);

/// Reads a view once more with the origin as its viewpoint, and notes it in the spec. False, with
/// nothing changed, where that view holds a fifth fewer of the points, or where its normals look
/// away from the origin.
bool see_from_origin(ViewSpec& spec, LoadedView& loaded);

/// The VIEWPOINT of a view's PCD where that is its pose; nothing where the project tells the pose,
/// or that points of all files are in one frame. Other files tell frames on purpose.
std::optional<RigidMotion> pose_of_file(const ViewSpec& spec, const LoadedView& loaded);

/// Whether the files of all views, two or more, tell one and the same pose: the turn of axes that
/// drivers write into each file, which says nothing of where views were measured from.
bool is_constant(const std::vector<std::optional<RigidMotion>>& poses_of_files);

/// Settles what views decide together, reading one at a time: viewpoints of clouds, which `specs`
/// then have, and conventions of normals, by comparing them with the depth. One choice for each
/// spec; those of views without normals have no meaning.
Result<ConventionChoice> settle_views(std::vector<ViewSpec>& specs);

}  // namespace relief
