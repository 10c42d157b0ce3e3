#pragma once

#include <vector>

#include <vtkDataSet.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "relief/scan/triangle_mesh.h"

/// Range views, meshes and poses in the types of the Visualization Toolkit (VTK), both ways.
/// Lengths keep their unit; coordinates and ranges are doubles.
///
/// Both forms of a view carry as field data what its grid needs: `name`, `pose` (`absent`, `guess`
/// or `known`), `world_from_view` (16 numbers, row major), `camera_model` (`pinhole`, `pinhole_gl`,
/// `orthographic` or `ray table`) and `camera`: fx fy cx cy; or origin, step_u, step_v and
/// direction; or the 16 numbers of a ray table's projection, if it has one, whose rays are
/// `ray_origin` and `ray_direction` of every pixel.
namespace relief::interop {

/// A mesh with the attributes that it has as point arrays: `normals` (the active normals),
/// `quality`, `views`, `filled`, `RGB`.
vtkSmartPointer<vtkPolyData> to_poly_data(const TriangleMesh& mesh);

/// The polygons (as fans) and triangle strips of `data`, with the attributes above. kBadInput when
/// a cell is damaged or names a point that does not exist, and when a coordinate is not finite.
Result<TriangleMesh> to_triangle_mesh(vtkPolyData& data);

/// The samples of a view as a surface in the world frame, triangles between connected samples
/// (mesh_from_view). Point arrays: `pixel` (column, row), and where the view has them `normals`
/// (world frame), `confidence`, `deviation`, `RGB`. Field data as above, and `grid_size`.
vtkSmartPointer<vtkPolyData> to_poly_data(const RangeView& view);

/// A view as an image of `width` x `height` x 1 points: row v of the view is row y = v, so that
/// pictures with y upwards show it upside down. Point arrays: `range` (NaN where there is no
/// sample), `mask` (1: sample), and where the view has them `normals` (view frame), `confidence`,
/// `deviation`, `RGB`. Field data as above.
vtkSmartPointer<vtkImageData> to_image_data(const RangeView& view);

/// The view of a vtkImageData or vtkPolyData as above; of these arrays only `range` or `pixel` are
/// needed, of the field data only the camera of an image and `grid_size` of a surface. `mask` takes
/// samples away. A surface without a camera gets the one that fits its points best
/// (view_from_grid); one whose points are not on their rays keeps its points and gets a table of
/// rays. A pose without `pose` is a guess. Normals that face away from the sensor are not taken.
///
/// kBadInput names the array that is missing or of the wrong size, a camera that is none, a pose
/// that is no rigid motion, a pixel outside the grid, and other types of data; kUnsolvable when
/// there is no sample.
Result<RangeView> to_range_view(vtkDataSet& data);

/// Poses, as those of an alignment (Alignment::world_from_view).
vtkSmartPointer<vtkMatrix4x4> to_vtk_matrix(const RigidMotion& motion);
std::vector<vtkSmartPointer<vtkMatrix4x4>> to_vtk_matrices(const std::vector<RigidMotion>& motions);

/// kBadInput when the matrix is no rotation and translation (rigid_motion_from_matrix).
Result<RigidMotion> to_rigid_motion(const vtkMatrix4x4& matrix);

}  // namespace relief::interop
