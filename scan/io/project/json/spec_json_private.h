#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "scan/io/project/view_spec.h"

namespace relief {

/// An empty scan.json.
nlohmann::ordered_json empty_project_json(const std::string& unit);

/// Sets or takes away the pose of a view's entry.
void set_pose_json(nlohmann::ordered_json& entry, const RigidMotion& world_from_view,
                   PoseKind kind);

/// Says so if the samples of a view's entry are not raw.
void set_samples_json(nlohmann::ordered_json& entry, SampleOrigin kind);

/// `file` as seen from `folder`; `file` itself where no such path exists.
std::filesystem::path path_from(const std::filesystem::path& file,
                                const std::filesystem::path& folder);

/// The entry of a view in a scan.json that lies in `folder`: parse_scan_json() gives `spec` back.
nlohmann::ordered_json view_json(const ViewSpec& spec, const std::filesystem::path& folder);

}  // namespace relief
