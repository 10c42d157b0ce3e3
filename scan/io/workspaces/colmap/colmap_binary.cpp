#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "scan/io/files/io_error.h"
#include "scan/io/workspaces/colmap/colmap_model.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// The numbers of the camera models, in the order of COLMAP's list.
constexpr std::array<const char*, 11> kColmapModels = {"SIMPLE_PINHOLE",
                                                       "PINHOLE",
                                                       "SIMPLE_RADIAL",
                                                       "RADIAL",
                                                       "OPENCV",
                                                       "OPENCV_FISHEYE",
                                                       "FULL_OPENCV",
                                                       "FOV",
                                                       "SIMPLE_RADIAL_FISHEYE",
                                                       "RADIAL_FISHEYE",
                                                       "THIN_PRISM_FISHEYE"};

// Takes numbers, least significant byte first, off the front of a file.
class ColmapBytes {
 public:
  ColmapBytes(std::string_view content, const fs::path& path)
      : rest_(content), size_(content.size()), path_(path) {}

  template <typename T>
  bool take(T& value) {
    static_assert(std::endian::native == std::endian::little, "swap the bytes here");
    if (rest_.size() < sizeof(T)) return false;
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return true;
  }

  bool skip(std::uint64_t count, std::size_t record_bytes) {
    if (count > rest_.size() / record_bytes) return false;
    rest_.remove_prefix(static_cast<std::size_t>(count) * record_bytes);
    return true;
  }

  // A text that a byte 0 ends.
  bool take_text(std::string_view& text) {
    const std::size_t end = rest_.find('\0');
    if (end == std::string_view::npos) return false;
    text = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return true;
  }

  // The number of records, each of which has at least `record_bytes`.
  Result<std::uint64_t> take_count(const std::string& what, std::size_t record_bytes) {
    std::uint64_t count = 0;
    if (!take(count)) return truncated("the number of " + what);
    if (count > rest_.size() / record_bytes)
      return bad_input(path_, "byte 0: the file says " + std::to_string(count) + " " + what +
                                  ", more than its " + std::to_string(size_) +
                                  " bytes can hold; copy it again");
    return count;
  }

  std::string place() const { return "byte " + std::to_string(size_ - rest_.size()) + ": "; }
  Error truncated(const std::string& what) const {
    return bad_input(path_, place() + "the file ends in " + what + "; copy it again");
  }
  Result<void> finish() const {
    if (rest_.empty()) return {};
    return bad_input(path_, place() + std::to_string(rest_.size()) +
                                " bytes follow the last record; is the file of this kind?");
  }

 private:
  std::string_view rest_;
  std::size_t size_;
  const fs::path& path_;
};

Result<ColmapCamera> take_camera(ColmapBytes& bytes, const fs::path& path) {
  const std::string place = bytes.place();
  std::uint32_t id = 0;
  std::int32_t model = 0;
  std::uint64_t width = 0, height = 0;
  if (!bytes.take(id) || !bytes.take(model) || !bytes.take(width) || !bytes.take(height))
    return bytes.truncated("a camera");
  const bool known = model >= 0 && static_cast<std::size_t>(model) < kColmapModels.size();
  std::vector<double> parameters(model == 0 ? 3 : model == 1 ? 4 : 0);
  for (double& parameter : parameters)
    if (!bytes.take(parameter)) return bytes.truncated("a camera");
  return colmap_camera(
      id,
      known ? kColmapModels[static_cast<std::size_t>(model)] : "number " + std::to_string(model),
      static_cast<double>(width), static_cast<double>(height), parameters, path, place);
}

Result<ColmapImage> take_image(ColmapBytes& bytes, const fs::path& path) {
  const std::string place = bytes.place();
  std::uint32_t id = 0, camera_id = 0;
  double pose[7];
  std::string_view name;
  std::uint64_t observations = 0;
  bool complete = bytes.take(id);
  for (double& number : pose) complete = complete && bytes.take(number);
  // x, y and the number of a point each.
  if (!complete || !bytes.take(camera_id) || !bytes.take_text(name) || !bytes.take(observations) ||
      !bytes.skip(observations, 24))
    return bytes.truncated("an image");
  return colmap_image(id, camera_id, pose, name, path, place);
}

Result<void> take_point(ColmapBytes& bytes, ColmapPoints& points) {
  std::uint64_t id = 0, sightings = 0;
  Eigen::Vector3d position;
  // Three bytes of colour and the error.
  if (!bytes.take(id) || !bytes.take(position.x()) || !bytes.take(position.y()) ||
      !bytes.take(position.z()) || !bytes.skip(1, 3 + 8) || !bytes.take(sightings))
    return bytes.truncated("a point");
  ColmapSighting sighting;
  sighting.point = static_cast<std::uint32_t>(points.points.size());
  for (std::uint64_t i = 0; i < sightings; ++i) {
    std::uint32_t feature = 0;
    if (!bytes.take(sighting.image_id) || !bytes.take(feature))
      return bytes.truncated("the track of a point");
    points.sightings.push_back(sighting);
  }
  points.points.push_back(position);
  return {};
}

}  // namespace

Result<std::vector<ColmapCamera>> parse_colmap_cameras_bin(std::string_view content,
                                                           const fs::path& path) {
  ColmapBytes bytes(content, path);
  const auto count = bytes.take_count("cameras", 24);  // before the parameters
  if (!count) return count.error();
  std::vector<ColmapCamera> cameras;
  for (std::uint64_t i = 0; i < *count; ++i) {
    auto camera = take_camera(bytes, path);
    if (!camera) return camera.error();
    cameras.push_back(*camera);
  }
  if (auto end = bytes.finish(); !end) return end.error();
  return cameras;
}

Result<std::vector<ColmapImage>> parse_colmap_images_bin(std::string_view content,
                                                         const fs::path& path) {
  ColmapBytes bytes(content, path);
  const auto count = bytes.take_count("images", 4 + 7 * 8 + 4 + 1 + 8);
  if (!count) return count.error();
  std::vector<ColmapImage> images;
  for (std::uint64_t i = 0; i < *count; ++i) {
    auto image = take_image(bytes, path);
    if (!image) return image.error();
    images.push_back(std::move(*image));
  }
  if (auto end = bytes.finish(); !end) return end.error();
  return images;
}

Result<ColmapPoints> parse_colmap_points_bin(std::string_view content, const fs::path& path) {
  ColmapBytes bytes(content, path);
  const auto count = bytes.take_count("points", 8 + 3 * 8 + 3 + 8 + 8);
  if (!count) return count.error();
  if (*count > std::numeric_limits<std::uint32_t>::max())
    return bad_input(path, "byte 0: more points than can be counted");
  ColmapPoints points;
  for (std::uint64_t i = 0; i < *count; ++i)
    if (auto taken = take_point(bytes, points); !taken) return taken.error();
  if (auto end = bytes.finish(); !end) return end.error();
  return points;
}

}  // namespace relief
