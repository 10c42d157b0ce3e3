#include "scan/io/workspaces/workspace_writers.h"

#include <charconv>
#include <cstddef>
#include <set>

#include <Eigen/Geometry>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// 17 digits: every double is read back as it was.
void put_number(double number, std::string& text) {
  char digits[32];
  const auto end =
      std::to_chars(digits, digits + sizeof digits, number, std::chars_format::general, 17);
  text.append(digits, end.ptr);
}

// `row_end` follows the last number of each row.
void put_matrix_rows(const RigidMotion& motion, const char* row_end, std::string& text) {
  for (Eigen::Index r = 0; r < 4; ++r)
    for (Eigen::Index c = 0; c < 4; ++c) {
      put_number(motion.matrix()(r, c), text);
      text += c < 3 ? " " : row_end;
    }
}

// A text as the value of an XML attribute. Control characters have no place in XML.
std::string xml_attribute(const std::string& text) {
  std::string escaped = "\"";
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c >= 0 && c < ' ' ? ' ' : c;
  }
  return escaped + '"';
}

Result<void> make_folder(const fs::path& folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (!fs::is_directory(folder, code))
    return cannot_write(folder, "cannot make the folder; give another name");
  return {};
}

Result<void> check_file_names(const std::vector<RangeView>& views, const fs::path& folder) {
  std::set<std::string> names;
  for (const RangeView& view : views) {
    if (view.name.empty() || view.name == "." || view.name == ".." ||
        view.name.find_first_of("/\\\n\r") != std::string::npos)
      return bad_input(folder, "the view name '" + view.name +
                                   "' is no file name; rename the view in its scan.json");
    if (!names.insert(view.name).second)
      return bad_input(folder, "two views are named " + view.name + "; rename one of them");
  }
  return {};
}

Result<std::string> colmap_cameras(const std::vector<RangeView>& views, const fs::path& folder) {
  constexpr double kColmapPixelCentre = 0.5;  // [pixels]; relief's is 0.
  std::string text = "# CAMERA_ID MODEL WIDTH HEIGHT fx fy cx cy\n";
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera& camera = views[i].camera;
    if (camera.model() != Camera::Model::kPinhole)
      return bad_input(folder, "view " + views[i].name + " has the camera '" +
                                   std::string(to_string(camera.model())) +
                                   "', and models of COLMAP hold pinhole cameras; write .tum, "
                                   ".log or .aln instead");
    const PinholeIntrinsics& k = camera.intrinsics();
    text += std::to_string(i + 1) + " PINHOLE " + std::to_string(camera.width()) + ' ' +
            std::to_string(camera.height());
    for (const double number : {k.fx, k.fy, k.cx + kColmapPixelCentre, k.cy + kColmapPixelCentre}) {
      text += ' ';
      put_number(number, text);
    }
    text += '\n';
  }
  return text;
}

std::string colmap_images(const std::vector<RangeView>& views) {
  std::string text =
      "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# (features of the image: none)\n";
  for (std::size_t i = 0; i < views.size(); ++i) {
    const RigidMotion view_from_world = views[i].world_from_view.inverse();
    const Eigen::Quaterniond q(view_from_world.linear());
    const Eigen::Vector3d t = view_from_world.translation();
    const std::string id = std::to_string(i + 1);
    text += id;
    for (const double number : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
      text += ' ';
      put_number(number, text);
    }
    text += ' ' + id + ' ' + views[i].name + ".png\n\n";
  }
  return text;
}

}  // namespace

std::string meshlab_mlp_text(const std::vector<RangeView>& views,
                             const std::vector<std::string>& files) {
  std::string text = "<!DOCTYPE MeshLabDocument>\n<MeshLabProject>\n <MeshGroup>\n";
  for (std::size_t i = 0; i < views.size(); ++i) {
    text += "  <MLMesh label=" + xml_attribute(views[i].name) +
            " filename=" + xml_attribute(files[i]) + " visible=\"1\">\n   <MLMatrix44>\n";
    // MeshLab 2020.09 reads past the end of a row without a blank behind it.
    put_matrix_rows(views[i].world_from_view, " \n", text);
    text += "</MLMatrix44>\n  </MLMesh>\n";
  }
  return text + " </MeshGroup>\n <RasterGroup/>\n</MeshLabProject>\n";
}

Result<void> write_xf_folder(const std::vector<RangeView>& views, const fs::path& folder) {
  if (auto named = check_file_names(views, folder); !named) return named;
  if (auto made = make_folder(folder); !made) return made;
  for (const RangeView& view : views) {
    std::string text;
    put_matrix_rows(view.world_from_view, "\n", text);
    if (auto written = write_file(folder / (view.name + ".xf"), text); !written) return written;
  }
  return {};
}

Result<void> write_colmap_text(const std::vector<RangeView>& views, const fs::path& folder) {
  if (auto named = check_file_names(views, folder); !named) return named;
  const auto cameras = colmap_cameras(views, folder);
  if (!cameras) return cameras.error();
  if (auto made = make_folder(folder); !made) return made;
  if (auto written = write_file(folder / "cameras.txt", *cameras); !written) return written;
  if (auto written = write_file(folder / "images.txt", colmap_images(views)); !written)
    return written;
  return write_file(folder / "points3D.txt", "# no points\n");
}

}  // namespace relief
