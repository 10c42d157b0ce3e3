#pragma once

#include <vtkSmartPointer.h>

#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

class vtkPolyData;

namespace relief {

/// A mesh as VTK has it, coordinates in doubles or in floats. Attributes of its vertices are the
/// point arrays `normals`, `quality`, `views`, `filled` and `RGB`.
vtkSmartPointer<vtkPolyData> poly_data_of(const TriangleMesh& mesh, bool doubles);

/// The polygons and triangle strips of `data`: polygons become fans. Normals are the active ones of
/// the points, else the array `normals`; the other attributes have the names above. Arrays of
/// another length or number of components are not taken. Errors, all kBadInput: cells that are
/// damaged or name points that do not exist, a coordinate that is not finite.
Result<TriangleMesh> mesh_of(vtkPolyData& data);

}  // namespace relief
