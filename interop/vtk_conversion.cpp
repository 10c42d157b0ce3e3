#include "relief/interop/vtk_conversion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>

#include "interop/vtk_fields_private.h"
#include "scan/io/grids/grid_view.h"
#include "scan/io/images/image_limits.h"
#include "scan/io/meshes/poly_data_private.h"

namespace relief::interop {

namespace {

using Pixels = std::vector<std::pair<int, int>>;  // (u, v)

Pixels all_pixels(const RangeView& view) {
  Pixels pixels;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) pixels.emplace_back(u, v);
  return pixels;
}

Pixels sample_pixels(const RangeView& view) {
  Pixels pixels;
  for (const auto& [u, v] : all_pixels(view))
    if (view.has_sample(u, v)) pixels.emplace_back(u, v);
  return pixels;
}

// An attribute of `Array` with `components` values `get(u, v, c)` for each pixel.
template <typename Array, typename Get>
void add_pixels(vtkDataSet& data, const char* name, int components, const Pixels& pixels,
                const Get& get) {
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(pixels.size()));
  for (std::size_t i = 0; i < pixels.size(); ++i)
    for (int c = 0; c < components; ++c)
      array->SetTypedComponent(static_cast<vtkIdType>(i), c,
                               get(pixels[i].first, pixels[i].second, c));
  data.GetPointData()->AddArray(array);
}

void add_accuracy(const RangeView& view, const Pixels& pixels, vtkDataSet& data) {
  if (!view.confidence.empty())
    add_pixels<vtkFloatArray>(data, "confidence", 1, pixels,
                              [&](int u, int v, int) { return view.confidence(u, v); });
  if (!view.deviation.empty())
    add_pixels<vtkFloatArray>(data, "deviation", 1, pixels,
                              [&](int u, int v, int) { return view.deviation(u, v); });
}

// The tuple of an array at each pixel of `places`, in a grid of the view's size.
template <typename T, typename Get>
Grid<T> gridded(const RangeView& view, const Pixels& places, const T& none, const Get& get) {
  Grid<T> grid(view.width(), view.height(), none);
  for (std::size_t i = 0; i < places.size(); ++i)
    grid(places[i].first, places[i].second) = get(static_cast<vtkIdType>(i));
  return grid;
}

constexpr float kUnknown = static_cast<float>(kNoSample);
constexpr double kLeastDeviation = std::numeric_limits<float>::min();
const Eigen::Vector3f kNoNormal = Eigen::Vector3f::Constant(kUnknown);

std::uint8_t byte_at(vtkDataArray* array, vtkIdType i, int c) {
  const double value = array->GetComponent(i, c);
  return value > 0.0 ? static_cast<std::uint8_t>(std::min(value, 255.0)) : std::uint8_t{0};
}

// What both forms of a view have for each of their points.
struct PointArrays {
  Grid<Eigen::Vector3f> normals;
  Grid<float> confidence, deviation;
  Grid<Colour> colours;
};

Result<PointArrays> read_point_arrays(vtkDataSet& data, const RangeView& view,
                                      const Pixels& places) {
  vtkFieldData& points = *data.GetPointData();
  PointArrays read;
  const auto normals = find_array(points, "normals", 3, places.size());
  if (!normals) return normals.error();
  const auto confidence = find_array(points, "confidence", 1, places.size());
  if (!confidence) return confidence.error();
  const auto deviation = find_array(points, "deviation", 1, places.size());
  if (!deviation) return deviation.error();
  const auto colours = find_array(points, "RGB", 3, places.size());
  if (!colours) return colours.error();
  // A number that makes no sense is replaced by `none`.
  const auto number = [](vtkDataArray* array, double least, float none) {
    return [=](vtkIdType i) {
      const double value = array->GetComponent(i, 0);
      return value >= least && std::isfinite(value) ? static_cast<float>(value) : none;
    };
  };
  if (*normals)
    read.normals = gridded(view, places, kNoNormal, [&](vtkIdType i) {
      return Eigen::Vector3d(Eigen::Vector3d::Map((*normals)->GetTuple3(i))).cast<float>().eval();
    });
  if (*confidence) read.confidence = gridded(view, places, 0.0f, number(*confidence, 0.0, 0.0f));
  if (*deviation)
    read.deviation = gridded(view, places, kUnknown, number(*deviation, kLeastDeviation, kUnknown));
  if (*colours)
    read.colours = gridded(view, places, Colour{}, [&](vtkIdType i) {
      return Colour{byte_at(*colours, i, 0), byte_at(*colours, i, 1), byte_at(*colours, i, 2)};
    });
  return read;
}

Error bad_data(const std::string& what) { return {ErrorKind::kBadInput, what}; }

Result<Camera> camera_of_image(vtkImageData& data, int width, int height) {
  auto camera = read_camera_fields(data, width, height);
  if (!camera) return camera.error();
  if (!*camera)
    return bad_data("the image has no camera: add the field arrays camera_model and camera");
  return std::move(**camera);
}

Result<void> read_ranges(vtkImageData& data, const Pixels& places, RangeView& view) {
  const auto range = find_array(*data.GetPointData(), "range", 1, places.size());
  if (!range) return range.error();
  if (!*range) return bad_data("the image has no point array 'range'");
  const auto mask = find_array(*data.GetPointData(), "mask", 1, places.size());
  if (!mask) return mask.error();
  view.range = gridded(view, places, kNoSample, [&](vtkIdType i) {
    const double value = (*range)->GetComponent(i, 0);
    const bool sample = std::isfinite(value) && (!*mask || (*mask)->GetComponent(i, 0) != 0.0);
    return sample ? value : kNoSample;
  });
  if (view.sample_count() > 0) return {};
  return Error{ErrorKind::kUnsolvable, "the image has no sample"};
}

Result<RangeView> view_of_image(vtkImageData& data) {
  int size[3];
  data.GetDimensions(size);
  if (size[0] < 1 || size[1] < 1 || size[2] != 1)
    return bad_data("the image is empty or has more than one layer");
  auto camera = camera_of_image(data, size[0], size[1]);
  if (!camera) return camera.error();
  RangeView view;
  view.camera = std::move(*camera);
  const Pixels places = all_pixels(view);
  if (auto read = read_ranges(data, places, view); !read) return read.error();
  if (auto read = read_pose_fields(data, view); !read) return read.error();
  auto arrays = read_point_arrays(data, view, places);
  if (!arrays) return arrays.error();
  set_usable_normals(arrays->normals, view);
  view.confidence = std::move(arrays->confidence);
  view.deviation = std::move(arrays->deviation);
  view.colours = std::move(arrays->colours);
  return view;
}

// The size of a surface's grid.
Result<std::pair<int, int>> grid_size(vtkPolyData& data) {
  const auto size = find_array(*data.GetFieldData(), "grid_size", 2, 1);
  if (!size) return size.error();
  if (!*size) return bad_data("the surface has no field array 'grid_size': it is no range view");
  const double width = (*size)->GetComponent(0, 0), height = (*size)->GetComponent(0, 1);
  if (!(width >= 1.0 && height >= 1.0 && width <= kMaxImageSide && height <= kMaxImageSide))
    return bad_data("the array 'grid_size' holds no size of a grid");
  return std::pair{static_cast<int>(width), static_cast<int>(height)};
}

Result<Pixels> pixels_of(vtkPolyData& data, int width, int height) {
  const auto count = static_cast<std::size_t>(data.GetNumberOfPoints());
  const auto array = find_array(*data.GetPointData(), "pixel", 2, count);
  if (!array) return array.error();
  if (!*array) return bad_data("the surface has no point array 'pixel': it is no range view");
  Pixels pixels;
  for (std::size_t i = 0; i < count; ++i) {
    const double u = (*array)->GetComponent(static_cast<vtkIdType>(i), 0);
    const double v = (*array)->GetComponent(static_cast<vtkIdType>(i), 1);
    if (!(u >= 0.0 && v >= 0.0 && u < width && v < height))
      return bad_data("the pixel of point " + std::to_string(i) + " is outside the grid");
    pixels.emplace_back(static_cast<int>(u), static_cast<int>(v));
  }
  return pixels;
}

Grid<Eigen::Vector3d> points_in_view(vtkPolyData& data, const RangeView& frame,
                                     const Pixels& places) {
  const RigidMotion view_from_world = frame.world_from_view.inverse();
  return gridded(frame, places, Eigen::Vector3d::Constant(kNoSample).eval(), [&](vtkIdType i) {
    const Eigen::Vector3d in_world = Eigen::Vector3d::Map(data.GetPoint(i));
    return (view_from_world * in_world).eval();
  });
}

void turn(Grid<Eigen::Vector3f>& normals, const Eigen::Matrix3d& rotation) {
  for (Eigen::Vector3f& normal : normals) normal = (rotation * normal.cast<double>()).cast<float>();
}

Result<RangeView> view_of_surface(vtkPolyData& data) {
  const auto size = grid_size(data);
  if (!size) return size.error();
  const auto [width, height] = *size;
  const auto places = pixels_of(data, width, height);
  if (!places) return places.error();
  RangeView frame;  // Pose and size alone.
  frame.camera = Camera::pinhole(width, height, {1.0, 1.0, 0.0, 0.0});
  if (auto read = read_pose_fields(data, frame); !read) return read.error();
  const auto camera = read_camera_fields(data, width, height);
  if (!camera) return camera.error();
  auto arrays = read_point_arrays(data, frame, *places);
  if (!arrays) return arrays.error();
  turn(arrays->normals, frame.world_from_view.linear().transpose());
  auto view = view_from_grid({.points = points_in_view(data, frame, *places),
                              .normals = std::move(arrays->normals),
                              .confidence = std::move(arrays->confidence),
                              .colours = std::move(arrays->colours),
                              .world_from_view = frame.world_from_view},
                             *camera);
  if (!view) return view;
  view->name = frame.name;
  view->pose = frame.pose;
  view->samples = frame.samples;
  view->deviation = std::move(arrays->deviation);
  return view;
}

}  // namespace

vtkSmartPointer<vtkPolyData> to_poly_data(const TriangleMesh& mesh) {
  return poly_data_of(mesh, true);
}

Result<TriangleMesh> to_triangle_mesh(vtkPolyData& data) { return mesh_of(data); }

vtkSmartPointer<vtkPolyData> to_poly_data(const RangeView& view) {
  auto data = to_poly_data(mesh_from_view(view));
  const Pixels pixels = sample_pixels(view);
  add_pixels<vtkIntArray>(*data, "pixel", 2, pixels,
                          [](int u, int v, int c) { return c == 0 ? u : v; });
  add_accuracy(view, pixels, *data);
  write_view_fields(view, *data);
  vtkNew<vtkIntArray> size;
  size->SetName("grid_size");
  size->SetNumberOfComponents(2);
  size->InsertNextTuple2(view.width(), view.height());
  data->GetFieldData()->AddArray(size);
  return data;
}

vtkSmartPointer<vtkImageData> to_image_data(const RangeView& view) {
  auto data = vtkSmartPointer<vtkImageData>::New();
  data->SetDimensions(view.width(), view.height(), 1);
  const Pixels pixels = all_pixels(view);
  add_pixels<vtkDoubleArray>(*data, "range", 1, pixels,
                             [&](int u, int v, int) { return view.range(u, v); });
  add_pixels<vtkUnsignedCharArray>(*data, "mask", 1, pixels, [&](int u, int v, int) {
    return static_cast<unsigned char>(view.has_sample(u, v));
  });
  if (view.has_normals())
    add_pixels<vtkFloatArray>(*data, "normals", 3, pixels,
                              [&](int u, int v, int c) { return view.normals(u, v)[c]; });
  add_accuracy(view, pixels, *data);
  if (!view.colours.empty())
    add_pixels<vtkUnsignedCharArray>(*data, "RGB", 3, pixels, [&](int u, int v, int c) {
      return view.colours(u, v)[static_cast<std::size_t>(c)];
    });
  data->GetPointData()->SetActiveScalars("range");
  write_view_fields(view, *data);
  return data;
}

Result<RangeView> to_range_view(vtkDataSet& data) {
  if (auto* image = vtkImageData::SafeDownCast(&data)) return view_of_image(*image);
  if (auto* surface = vtkPolyData::SafeDownCast(&data)) return view_of_surface(*surface);
  return bad_data(std::string("a ") + data.GetClassName() +
                  " is no range view; use vtkImageData or vtkPolyData");
}

vtkSmartPointer<vtkMatrix4x4> to_vtk_matrix(const RigidMotion& motion) {
  auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      matrix->SetElement(row, column, motion.matrix()(row, column));
  return matrix;
}

std::vector<vtkSmartPointer<vtkMatrix4x4>> to_vtk_matrices(
    const std::vector<RigidMotion>& motions) {
  std::vector<vtkSmartPointer<vtkMatrix4x4>> matrices;
  for (const RigidMotion& motion : motions) matrices.push_back(to_vtk_matrix(motion));
  return matrices;
}

Result<RigidMotion> to_rigid_motion(const vtkMatrix4x4& matrix) {
  Eigen::Matrix4d elements;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      elements(row, column) = matrix.GetElement(row, column);
  return rigid_motion_from_matrix(elements, "the vtkMatrix4x4");
}

}  // namespace relief::interop
