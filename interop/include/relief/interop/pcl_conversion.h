#pragma once

#include <optional>

#include <pcl/PolygonMesh.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "relief/scan/camera.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

/// Range views and meshes in the types of the Point Cloud Library (PCL), both ways. Lengths keep
/// their unit; PCL stores coordinates in 32-bit floats.
namespace relief::interop {

/// The samples of a view as an organized cloud, `width` and `height` those of the view. Points and
/// unit normals are in the view frame; NaN where there is no sample or no normal. The viewpoint,
/// `sensor_origin_` and `sensor_orientation_`, is `world_from_view`. PointXYZRGBNormal carries the
/// colours, black where the view has none. Name, confidence and deviation have no place in a cloud.
///
/// `Point` is pcl::PointNormal or pcl::PointXYZRGBNormal.
template <typename Point>
pcl::PointCloud<Point> to_pcl(const RangeView& view);

/// The view of an organized cloud whose points are in the frame of the sensor. Its samples are the
/// finite points. Its rays are those of `camera`, else of the model that fits the points best, as
/// when a PCD file is read (view_from_grid). Normals become unit vectors; those of no direction and
/// those that face away from the sensor are not taken. A viewpoint other than the identity becomes
/// the pose, a guess. Colours are taken unless all are black.
///
/// Errors: kBadInput for an empty cloud, one that is not organized (height 1), a camera of another
/// size, a viewpoint that is no rigid motion; kUnsolvable when no point is finite.
Result<RangeView> from_pcl(const pcl::PointCloud<pcl::PointNormal>& cloud,
                           const std::optional<Camera>& camera = {});
Result<RangeView> from_pcl(const pcl::PointCloud<pcl::PointXYZRGBNormal>& cloud,
                           const std::optional<Camera>& camera = {});

/// A mesh with the attributes that it has, as fields of the cloud: `x y z`, `normal_x normal_y
/// normal_z`, `quality` (32-bit floats), `views` (16 bits), `filled` (8 bits) and `rgb` (packed as
/// PCL does).
pcl::PolygonMesh to_pcl(const TriangleMesh& mesh);

/// The same back; polygons of more corners become fans, fields of other names or types are not
/// taken. kBadInput when the cloud has no real fields `x y z` or less data than points, for points
/// that are not finite, and for polygons with fewer than three corners or with corners that do not
/// exist.
Result<TriangleMesh> from_pcl(const pcl::PolygonMesh& mesh);

}  // namespace relief::interop
