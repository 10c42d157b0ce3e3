// 3D Manufacturing Format, core specification 1.2 with the materials extension: an XML text in a
// ZIP archive. The one file that meets libarchive.
#include <charconv>
#include <cstdint>
#include <map>
#include <memory>

#include <archive.h>
#include <archive_entry.h>

#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

constexpr const char* kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";
constexpr const char* kRelationships =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";

template <typename T>
void append_attribute(std::string& xml, const char* name, T value) {
  char digits[40];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  xml.append(" ").append(name).append("=\"").append(digits, end).append("\"");
}

// Each colour once; `index` tells which one a vertex has.
std::string colour_group(const TriangleMesh& mesh, std::vector<std::size_t>& index) {
  std::map<Colour, std::size_t> known;
  std::string xml = "<m:colorgroup id=\"1\">\n";
  for (const Colour& colour : mesh.colours) {
    const auto [entry, is_new] = known.try_emplace(colour, known.size());
    index.push_back(entry->second);
    if (!is_new) continue;
    constexpr const char* kDigits = "0123456789ABCDEF";
    xml += "<m:color color=\"#";
    for (const std::uint8_t value : colour) {
      xml += kDigits[value >> 4];
      xml += kDigits[value & 15];
    }
    xml += "\"/>\n";
  }
  return xml + "</m:colorgroup>\n";
}

std::string model_xml(const TriangleMesh& mesh, const std::string& unit) {
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"" + unit +
                    "\" xml:lang=\"en-US\" "
                    "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
                    "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">\n"
                    "<metadata name=\"Application\">relief</metadata>\n<resources>\n";
  std::vector<std::size_t> colours;
  if (!mesh.colours.empty()) xml += colour_group(mesh, colours);
  xml += "<object id=\"2\" type=\"model\"";
  if (!colours.empty()) xml += " pid=\"1\" pindex=\"0\"";
  xml += "><mesh>\n<vertices>\n";
  for (const auto& vertex : mesh.vertices) {
    xml += "<vertex";
    append_attribute(xml, "x", vertex.x());
    append_attribute(xml, "y", vertex.y());
    append_attribute(xml, "z", vertex.z());
    xml += "/>\n";
  }
  xml += "</vertices>\n<triangles>\n";
  for (const auto& face : mesh.faces) {
    xml += "<triangle";
    append_attribute(xml, "v1", face[0]);
    append_attribute(xml, "v2", face[1]);
    append_attribute(xml, "v3", face[2]);
    if (!colours.empty()) {
      xml += " pid=\"1\"";
      append_attribute(xml, "p1", colours[face[0]]);
      append_attribute(xml, "p2", colours[face[1]]);
      append_attribute(xml, "p3", colours[face[2]]);
    }
    xml += "/>\n";
  }
  return xml +
         "</triangles>\n</mesh></object>\n</resources>\n<build><item objectid=\"2\"/></build>\n"
         "</model>\n";
}

la_ssize_t append_to_string(struct archive*, void* bytes, const void* data, std::size_t size) {
  static_cast<std::string*>(bytes)->append(static_cast<const char*>(data), size);
  return static_cast<la_ssize_t>(size);
}

// A file of the archive. Its date is that of no day: the same mesh gives the same bytes.
bool add_to_archive(struct archive* zip, const char* name, const std::string& content) {
  const std::unique_ptr<archive_entry, void (*)(archive_entry*)> entry(archive_entry_new(),
                                                                       archive_entry_free);
  archive_entry_set_pathname(entry.get(), name);
  archive_entry_set_size(entry.get(), static_cast<la_int64_t>(content.size()));
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_perm(entry.get(), 0644);
  constexpr time_t kFirstDayOfZip = 315619200;  // 1980-01-02, the format begins with 1980
  archive_entry_set_mtime(entry.get(), kFirstDayOfZip, 0);
  return archive_write_header(zip, entry.get()) == ARCHIVE_OK &&
         archive_write_data(zip, content.data(), content.size()) ==
             static_cast<la_ssize_t>(content.size());
}

}  // namespace

Result<std::string> encode_3mf_mesh(const TriangleMesh& mesh) {
  std::string bytes;
  const std::unique_ptr<struct archive, int (*)(struct archive*)> zip(archive_write_new(),
                                                                      archive_write_free);
  const std::string model = model_xml(mesh, "millimeter");
  const bool written =
      zip && archive_write_set_format_zip(zip.get()) == ARCHIVE_OK &&
      archive_write_set_bytes_in_last_block(zip.get(), 1) == ARCHIVE_OK &&
      archive_write_open(zip.get(), &bytes, nullptr, append_to_string, nullptr) == ARCHIVE_OK &&
      add_to_archive(zip.get(), "[Content_Types].xml", kContentTypes) &&
      add_to_archive(zip.get(), "_rels/.rels", kRelationships) &&
      add_to_archive(zip.get(), "3D/3dmodel.model", model) &&
      archive_write_close(zip.get()) == ARCHIVE_OK;
  if (written) return bytes;
  return Error{ErrorKind::kCannotWrite, std::string("the ZIP archive could not be made: ") +
                                            (zip ? archive_error_string(zip.get()) : "no memory")};
}

}  // namespace relief
