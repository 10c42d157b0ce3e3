#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "scan/io/e57/e57_colours.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/e57/e57_layout.h"
#include "scan/io/e57/e57_records.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

using FieldNames = std::array<const char*, 3>;
constexpr FieldNames kCartesian{"cartesianX", "cartesianY", "cartesianZ"};
constexpr FieldNames kSpherical{"sphericalRange", "sphericalAzimuth", "sphericalElevation"};
constexpr FieldNames kNormal{"normalX", "normalY", "normalZ"};
constexpr FieldNames kColour{"colorRed", "colorGreen", "colorBlue"};

bool has_all(const E57Scan& scan, const FieldNames& names) {
  return std::all_of(names.begin(), names.end(),
                     [&](const char* name) { return scan.find(name) != nullptr; });
}

bool has_indices(const E57Scan& scan) { return scan.find("rowIndex") && scan.find("columnIndex"); }

// Azimuth from x towards y, elevation from the xy plane towards z [rad].
Eigen::Vector3d point_from_spherical(const Eigen::Vector3d& range_azimuth_elevation) {
  const double range = range_azimuth_elevation.x(), azimuth = range_azimuth_elevation.y(),
               elevation = range_azimuth_elevation.z();
  const double in_plane = range * std::cos(elevation);
  return {in_plane * std::cos(azimuth), in_plane * std::sin(azimuth), range * std::sin(elevation)};
}

// What the records of a scan hold, before invalid ones are dropped.
class CloudReader {
 public:
  CloudReader(E57Pages& pages, const E57Scan& scan) : pages_(pages), scan_(scan) {
    cloud_.name = scan.name;
    cloud_.guid = scan.guid;
    cloud_.world_from_view = scan.world_from_view;
  }

  Result<E57Cloud> read() {
    if (scan_.record_count == 0 && scan_.section_offset == 0) return without_points();
    if (auto count = check_e57_record_count(pages_, scan_); !count) return count.error();
    if (auto places = take_points(); !places) return places.error();
    take_normals();
    take_colours();
    if (has_indices(scan_)) take_indices();
    if (auto records = read_e57_records(pages_, scan_, targets_); !records) return records.error();
    if (scan_.record_count == 0) return without_points();
    mark_unusable();
    set_colours();
    drop_unusable();
    add_notes();
    place_on_grid();
    return std::move(cloud_);
  }

 private:
  std::size_t count() const { return static_cast<std::size_t>(scan_.record_count); }

  Result<E57Cloud> without_points() {
    cloud_.notes.push_back("the scan has no points");
    return std::move(cloud_);
  }

  void want(const char* field, E57Sink sink) { targets_.push_back({field, std::move(sink)}); }

  // Component k of each record goes into component k of an array of vectors.
  template <typename Vectors>
  void want_vectors(const FieldNames& fields, Vectors& vectors) {
    vectors.resize(count());
    for (std::size_t k = 0; k < fields.size(); ++k)
      want(fields[k], [&vectors, k](std::size_t first, std::span<const double> values) {
        using Scalar = std::remove_reference_t<decltype(vectors[0][0])>;
        for (std::size_t i = 0; i < values.size(); ++i)
          vectors[first + i][k] = static_cast<Scalar>(values[i]);
      });
  }

  // Records whose state in `field` is not 0 get `flag`.
  void want_state(const char* field, std::uint8_t flag) {
    want(field, [this, flag](std::size_t first, std::span<const double> values) {
      for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i] != 0.0) flags_[first + i] |= flag;
    });
  }

  Result<void> take_points() {
    flags_.resize(count());
    if (has_all(scan_, kCartesian)) {
      want_vectors(kCartesian, cloud_.points);
      want_state("cartesianInvalidState", kInvalid);
    } else if (has_all(scan_, kSpherical)) {
      spherical_ = true;
      want_vectors(kSpherical, cloud_.points);
      want_state("sphericalInvalidState", kInvalid);
    } else {
      return bad_input(pages_.path(),
                       "the points of the E57 have neither the fields cartesianX, cartesianY, "
                       "cartesianZ nor sphericalRange, sphericalAzimuth, sphericalElevation");
    }
    return {};
  }

  void take_normals() {
    if (has_all(scan_, kNormal)) want_vectors(kNormal, cloud_.normals);
  }

  void take_colours() {
    if (has_all(scan_, kColour)) {
      want_vectors(kColour, raw_colours_);
      want_state("isColorInvalid", kNoColour);
    } else if (scan_.find("intensity")) {
      raw_intensities_.resize(count());
      want("intensity", [this](std::size_t first, std::span<const double> values) {
        std::transform(values.begin(), values.end(),
                       raw_intensities_.begin() + static_cast<std::ptrdiff_t>(first),
                       [](double value) { return static_cast<float>(value); });
      });
      want_state("isIntensityInvalid", kNoColour);
    }
  }

  void take_indices() {
    for (const bool is_row : {true, false}) {
      std::vector<int>& indices = is_row ? cloud_.rows : cloud_.columns;
      indices.resize(count());
      want(is_row ? "rowIndex" : "columnIndex",
           [this, &indices](std::size_t first, std::span<const double> values) {
             for (std::size_t i = 0; i < values.size(); ++i)
               indices[first + i] = index_from(values[i]);
           });
    }
  }

  int index_from(double value) {
    if (std::abs(value) <= kMaxIndex && value == std::floor(value)) return static_cast<int>(value);
    indices_usable_ = false;
    return 0;
  }

  void mark_unusable() {
    for (std::size_t i = 0; i < count(); ++i) {
      Eigen::Vector3d& point = cloud_.points[i];
      if (spherical_) point = point_from_spherical(point);
      if (flags_[i] & kInvalid)
        ++invalid_;
      else if (!point.allFinite())
        ++not_finite_;
      else if (point == Eigen::Vector3d::Zero())
        ++at_origin_;
      else
        continue;
      flags_[i] |= kInvalid;
    }
  }

  void set_colours() {
    if (!raw_colours_.empty())
      cloud_.colours = colours_of_e57(scan_, raw_colours_, flags_, cloud_.notes);
    if (!raw_intensities_.empty())
      cloud_.colours = greys_of_e57(scan_, raw_intensities_, flags_, cloud_.notes);
    raw_colours_ = {};
    raw_intensities_ = {};
  }

  template <typename T>
  void keep_usable(std::vector<T>& values) const {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!(flags_[i] & kInvalid)) values[kept++] = values[i];
    values.resize(kept);
  }

  void drop_unusable() {
    for (Eigen::Vector3f& normal : cloud_.normals)
      if (!normal.allFinite() || normal == Eigen::Vector3f::Zero())
        normal.setConstant(std::numeric_limits<float>::quiet_NaN());
    keep_usable(cloud_.points);
    keep_usable(cloud_.normals);
    keep_usable(cloud_.colours);
    keep_usable(cloud_.rows);
    keep_usable(cloud_.columns);
  }

  void add_note(std::size_t number, const std::string& what) {
    if (number > 0) cloud_.notes.push_back(std::to_string(number) + what);
  }

  void add_notes() {
    add_note(invalid_, " records that the scan calls invalid were left out");
    add_note(not_finite_, " points that are not finite were left out");
    add_note(at_origin_, " points exactly at the scan's origin were left out");
  }

  static bool is_side(std::int64_t first, std::int64_t last) {
    return first >= -kMaxIndex && last <= kMaxIndex && last - first < kMaxImageSide;
  }

  // Grid bounds as the file tells, or as the points need.
  E57IndexBounds bounds() {
    const auto [top, bottom] = std::minmax_element(cloud_.rows.begin(), cloud_.rows.end());
    const auto [left, right] = std::minmax_element(cloud_.columns.begin(), cloud_.columns.end());
    const E57IndexBounds found{*top, *bottom, *left, *right};
    const auto& told = scan_.index_bounds;
    if (!told) return found;
    const bool hold = told->row_minimum <= found.row_minimum &&
                      told->row_maximum >= found.row_maximum &&
                      told->column_minimum <= found.column_minimum &&
                      told->column_maximum >= found.column_maximum;
    const bool usable = hold && is_side(told->row_minimum, told->row_maximum) &&
                        is_side(told->column_minimum, told->column_maximum);
    if (!hold)
      cloud_.notes.push_back(
          "the points do not keep to the scan's indexBounds; the grid is as "
          "large as the points need");
    return usable ? *told : found;
  }

  void no_grid(const std::string& note) {
    if (!note.empty()) cloud_.notes.push_back(note);
    cloud_.rows = cloud_.columns = {};
  }

  void place_on_grid() {
    if (cloud_.rows.empty()) return no_grid("");
    if (!indices_usable_)
      return no_grid("some rowIndex or columnIndex is no integer of 31 bits; both were left out");
    const E57IndexBounds grid = bounds();
    const std::int64_t height = grid.row_maximum - grid.row_minimum + 1;
    const std::int64_t width = grid.column_maximum - grid.column_minimum + 1;
    if (height < 2 || width < 2) return no_grid("");
    if (height > kMaxImageSide || width > kMaxImageSide)
      return no_grid("the grid of the scan would be " + std::to_string(width) + "x" +
                     std::to_string(height) + ", which is too large; its indices were left out");
    for (int& row : cloud_.rows) row -= static_cast<int>(grid.row_minimum);
    for (int& column : cloud_.columns) column -= static_cast<int>(grid.column_minimum);
    cloud_.structured = true;
    cloud_.height = static_cast<int>(height);
    cloud_.width = static_cast<int>(width);
  }

  static constexpr std::uint8_t kInvalid = 1, kNoColour = 2;
  static constexpr int kMaxIndex = 1 << 30;  // so that differences stay within 32 bits

  E57Pages& pages_;
  const E57Scan& scan_;
  std::vector<E57Target> targets_;
  E57Cloud cloud_;
  bool spherical_ = false, indices_usable_ = true;
  std::vector<std::uint8_t> flags_;
  std::vector<std::array<float, 3>> raw_colours_;
  std::vector<float> raw_intensities_;
  std::size_t invalid_ = 0, not_finite_ = 0, at_origin_ = 0;
};

Result<std::vector<E57ScanInfo>> infos_of(Result<E57Pages> pages) {
  if (!pages) return pages.error();
  const auto scans = read_e57_layout(*pages);
  if (!scans) return scans.error();
  std::vector<E57ScanInfo> infos;
  for (const E57Scan& scan : *scans)
    infos.push_back({scan.name, scan.guid, static_cast<std::size_t>(scan.record_count),
                     scan.world_from_view, has_indices(scan), has_all(scan, kNormal),
                     has_all(scan, kColour), scan.find("intensity") != nullptr});
  return infos;
}

Result<E57Cloud> cloud_of(Result<E57Pages> pages, int scan) {
  if (!pages) return pages.error();
  const auto scans = read_e57_layout(*pages);
  if (!scans) return scans.error();
  if (scans->empty()) return bad_input(pages->path(), "the E57 holds no scans");
  if (scan < 0 || static_cast<std::size_t>(scan) >= scans->size())
    return bad_input(pages->path(), "the E57 has no scan " + std::to_string(scan) +
                                        "; its scans are 0 to " +
                                        std::to_string(scans->size() - 1));
  return CloudReader(*pages, (*scans)[static_cast<std::size_t>(scan)]).read();
}

}  // namespace

Result<std::vector<E57ScanInfo>> list_e57_scans(const std::filesystem::path& path) {
  return infos_of(E57Pages::open(path));
}

Result<std::vector<E57ScanInfo>> parse_e57_scans(std::string_view content,
                                                 const std::filesystem::path& path) {
  return infos_of(E57Pages::in_memory(content, path));
}

Result<E57Cloud> read_e57_cloud(const std::filesystem::path& path, int scan) {
  return cloud_of(E57Pages::open(path), scan);
}

Result<E57Cloud> parse_e57_cloud(std::string_view content, const std::filesystem::path& path,
                                 int scan) {
  return cloud_of(E57Pages::in_memory(content, path), scan);
}

}  // namespace relief
