#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// What is done with the matrix of a PTX scan.
enum class PtxMatrix {
  kPose,   ///< It is the pose and must be rigid; points stay in the scanner's frame.
  kApply,  ///< It is applied to the points, which are then in the world; any finite matrix will do.
};

/// Where a scan is in a PTX file.
struct PtxScan {
  std::size_t begin = 0, end = 0;  ///< Its bytes.
  std::size_t lines_before = 0;
  bool has_pose = false;  ///< Its matrix is not the identity.
};

/// The scans of a PTX file, at least one. Errors as below.
Result<std::vector<PtxScan>> list_ptx_scans(std::string_view content,
                                            const std::filesystem::path& path);
Result<std::vector<PtxScan>> list_ptx_scans(const std::filesystem::path& path);

/// Scan `scan`, counted from 0, of a PTX file: the text of Leica's programs. Columns of the file
/// are columns of the grid; its rows are counted upwards, so the last row of a column has v = 0.
/// Points are in the scanner's frame and the file's unit, commonly metres; `0 0 0` is no return.
///
/// `world_from_view` is the matrix of the scan, whose last line is the translation; it stays unset
/// for the identity, which stands for unknown. Red, green and blue become colours, else
/// intensities become grey (see GreyOfIntensity).
///
/// Errors (kBadInput) name the line: a file that ends early with the number of lines that are
/// missing, and a matrix that is not rigid. Nothing is allocated that the content could not fill.
Result<GridFile> parse_ptx_scan(std::string_view content, const std::filesystem::path& path,
                                int scan, PtxMatrix matrix = PtxMatrix::kPose);
Result<GridFile> read_ptx_scan(const std::filesystem::path& path, int scan,
                               PtxMatrix matrix = PtxMatrix::kPose);
/// The same at once, where its place is known.
Result<GridFile> read_ptx_scan(const std::filesystem::path& path, const PtxScan& scan,
                               PtxMatrix matrix = PtxMatrix::kPose);

/// The text of a PTX file with one scan for each view, as read_ptx_scan reads it: the numbers are
/// the shortest that read back as the same bits. The position and axes of the scanner are those of
/// the pose. Intensity is the brightness of the colour from 0 to 1, and 0.5 without colours.
/// A sample at the origin of its frame itself reads back as no return. One unit of the views is
/// `metres_per_unit` metres; coordinates are exact when that is 1.
std::string encode_ptx(const std::vector<RangeView>& views, double metres_per_unit = 1.0);

/// Writes it; the file appears whole or not at all. Errors are kCannotWrite; no view is one.
Result<void> write_ptx(const std::vector<RangeView>& views, const std::filesystem::path& path,
                       double metres_per_unit = 1.0);

}  // namespace relief
