#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace relief::testing {

/// Numbers as an E57 file holds them.
std::string doubles(const std::vector<double>& values);
std::string floats(const std::vector<float>& values);
/// The low `bits` bits of each value, least significant bit first, filled up to a whole byte.
std::string bits(const std::vector<std::uint64_t>& values, int bits);

/// Packets of a section of points.
std::string data_packet(const std::vector<std::string>& streams);
std::string index_packet();
std::string empty_packet();

/// An E57 file made by hand, independent of the library's writer.
class E57Builder {
 public:
  /// Returns the physical offset of a section of points that has these packets.
  std::uint64_t add_section(const std::vector<std::string>& packets);
  /// Adds a scan of `count` points with one data packet; `extra` is XML beside its points.
  void add_scan(const std::string& prototype, std::uint64_t count,
                const std::vector<std::string>& streams, const std::string& extra = "");
  void add_scan_of_packets(const std::string& prototype, std::uint64_t count,
                           const std::vector<std::string>& packets, const std::string& extra = "");
  /// Adds the XML of a scan as it is.
  void add_scan_xml(const std::string& xml) { scans_ += xml; }
  /// The whole file. `attributes` are further ones of the root element.
  std::string finish(const std::string& attributes = "") const;
  /// The whole file with this XML section.
  std::string finish_with(const std::string& xml) const;

 private:
  std::string payload_ = std::string(48, '\0');
  std::string scans_;
};

/// The same file after a change of its payload, with the right checksums. Whole pages only.
std::string with_checksums(const std::string& content);

/// Prototypes.
inline const std::string kXyz =
    "<cartesianX type=\"Float\"/><cartesianY type=\"Float\"/><cartesianZ type=\"Float\"/>";
inline const std::string kRowColumn =
    "<rowIndex type=\"Integer\" minimum=\"0\" maximum=\"255\"/>"
    "<columnIndex type=\"Integer\" minimum=\"0\" maximum=\"255\"/>";

}  // namespace relief::testing
