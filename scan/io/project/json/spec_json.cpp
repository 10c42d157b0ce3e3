#include "scan/io/files/real_path.h"
#include "scan/io/project/json/camera_json_private.h"
#include "scan/io/project/json/spec_json_private.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using SpecJson = nlohmann::ordered_json;

SpecJson image_json(const ImageFile& image, const fs::path& folder) {
  SpecJson json = {{"file", path_from(image.file, folder).string()}};
  if (image.size) json["size"] = {image.size->width, image.size->height};
  return json;
}

SpecJson depth_json(const DepthSpec& depth, const fs::path& folder) {
  SpecJson json = image_json({depth.file, depth.size}, folder);
  json["scale"] = depth.scale;
  json["kind"] = depth.along_ray ? "ray" : "z";
  return json;
}

SpecJson grid_json(const ViewSpec& spec, const fs::path& folder) {
  SpecJson grid = {{"file", path_from(*spec.grid, folder).string()}};
  if (spec.grid_options.scan > 0) grid["scan"] = spec.grid_options.scan;
  if (spec.grid_options.viewpoint) grid["viewpoint"] = json_of(*spec.grid_options.viewpoint);
  if (spec.grid_options.ignore_pose) grid["pose"] = "ignore";
  return grid;
}

SpecJson normals_json(const NormalSpec& normals, const fs::path& folder) {
  SpecJson json = image_json({normals.file, normals.size}, folder);
  if (normals.encoding)
    json["encoding"] = *normals.encoding == NormalEncoding::kRgb ? "rgb" : "unit";
  if (normals.axes) json["axes"] = *normals.axes == NormalAxes::kOpencv ? "opencv" : "opengl";
  if (normals.space) json["space"] = *normals.space == NormalSpace::kCamera ? "camera" : "world";
  return json;
}

}  // namespace

SpecJson empty_project_json(const std::string& unit) {
  return {{"format", "relief-scan"}, {"version", 1}, {"unit", unit}, {"views", SpecJson::array()}};
}

void set_pose_json(SpecJson& entry, const RigidMotion& world_from_view, PoseKind kind) {
  entry.erase("world_from_view");
  entry.erase("pose_is");
  if (kind == PoseKind::kAbsent) return;
  entry["world_from_view"] = json_of(world_from_view);
  entry["pose_is"] = kind == PoseKind::kKnown ? "known" : "guess";
}

void set_samples_json(SpecJson& entry, SampleOrigin kind) {
  if (kind == SampleOrigin::kRefined) entry["samples"] = "refined";
}

fs::path path_from(const fs::path& file, const fs::path& folder) {
  const fs::path target = real_path(file);
  const fs::path relative = target.lexically_relative(real_path(folder));
  return relative.empty() ? target : relative;
}

SpecJson view_json(const ViewSpec& spec, const fs::path& folder) {
  SpecJson entry = {{"name", spec.name}};
  if (spec.depth) entry["depth"] = depth_json(*spec.depth, folder);
  if (spec.grid) entry["grid"] = grid_json(spec, folder);
  if (spec.camera) entry["camera"] = camera_json(*spec.camera);
  if (spec.normals) entry["normals"] = normals_json(*spec.normals, folder);
  const auto set_image = [&](const char* key, const std::optional<ImageFile>& image) {
    if (image) entry[key] = image_json(*image, folder);
  };
  set_image("mask", spec.mask);
  set_image("confidence", spec.confidence);
  set_image("color", spec.colour);
  if (spec.deviation) {
    entry["deviation"] = image_json({spec.deviation->file, spec.deviation->size}, folder);
    entry["deviation"]["scale"] = spec.deviation->scale;
  }
  set_samples_json(entry, spec.samples);
  set_pose_json(entry, spec.world_from_view, spec.pose);
  return entry;
}

}  // namespace relief
