#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// Parses a text of four rows of four numbers as a rigid motion, world from view: `.xf` of
/// Scanalyze, matrix files of CloudCompare. Lines that begin with `#` are comments. kBadInput names
/// the line.
Result<RigidMotion> parse_matrix_text(std::string_view text, const std::filesystem::path& path);

/// The pose in a file beside a scan `bun000.ply`. The first of these is taken: `bun000.xf`,
/// `bun000.mat.txt`, `bun000.matrix.txt`, `bun000_matrix.txt`,
/// `bun000_REGISTRATION_MATRIX*.txt` (of CloudCompare; two of them are an error), and `bun000.txt`
/// if it holds sixteen numbers and nothing else. Nothing where there is none of them.
Result<std::optional<RigidMotion>> pose_beside(const std::filesystem::path& scan_path);

}  // namespace relief
