// Wavefront OBJ and binary STL: small formats that are written in full precision and
// in memory, so that one place sees a disk that is full.
#include <charconv>
#include <cstdint>

#include "scan/io/files/binary_writer.h"
#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

// The shortest text that reads back as the same number.
template <typename T>
void append_number(std::string& text, T value) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  text.append(buffer, end);
}

template <typename Vector>
void append_line(std::string& text, const char* keyword, const Vector& vector) {
  text += keyword;
  for (const auto value : vector) {
    text += ' ';
    append_number(text, value);
  }
  text += '\n';
}

// Behind the coordinates of the line before, from 0 to 1: what MeshLab, Blender and Open3D read.
void append_colour(std::string& text, const Colour& colour) {
  text.pop_back();
  append_line(text, "", Eigen::Vector3f(colour[0], colour[1], colour[2]) / 255.0f);
}

void append_vector(std::string& bytes, const Eigen::Vector3f& vector) {
  for (const float value : vector) append_little_endian(bytes, value);
}

// STL holds 32-bit numbers. Far from the origin these cannot tell near vertices apart.
Result<void> check_stl_corners(const TriangleMesh& mesh) {
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d a = mesh.corner(f, k), b = mesh.corner(f, (k + 1) % 3);
      if (a == b || a.cast<float>() != b.cast<float>()) continue;
      return Error{ErrorKind::kCannotWrite,
                   "STL holds 32-bit numbers, which cannot tell the corners of face " +
                       std::to_string(f) +
                       " apart so far from the origin; write .ply, .obj or .vtp"};
    }
  return {};
}

}  // namespace

Result<std::string> encode_obj_mesh(const TriangleMesh& mesh) {
  std::string text;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    append_line(text, "v", mesh.vertices[i]);
    if (!mesh.colours.empty()) append_colour(text, mesh.colours[i]);
  }
  for (const auto& normal : mesh.normals) append_line(text, "vn", normal);
  for (const auto& face : mesh.faces) {
    text += 'f';
    for (const std::uint32_t vertex : face) {
      text += ' ';
      append_number(text, vertex + 1ull);
      if (mesh.normals.empty()) continue;
      text += "//";
      append_number(text, vertex + 1ull);
    }
    text += '\n';
  }
  return text;
}

Result<std::string> encode_stl_mesh(const TriangleMesh& mesh) {
  if (const auto checked = check_stl_corners(mesh); !checked) return checked.error();
  std::string bytes = "binary STL, written by relief";
  bytes.resize(80, ' ');
  bytes.reserve(84 + mesh.faces.size() * 50);
  append_little_endian(bytes, static_cast<std::uint32_t>(mesh.faces.size()));
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    append_vector(bytes, face_cross(mesh, f).stableNormalized().cast<float>());
    for (int k = 0; k < 3; ++k) append_vector(bytes, mesh.corner(f, k).cast<float>());
    append_little_endian(bytes, std::uint16_t{0});
  }
  return bytes;
}

}  // namespace relief
