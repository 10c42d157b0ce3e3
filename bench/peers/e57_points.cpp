// The points that libE57Format reads from a file, as relief_read_points writes those of relief:
//   e57_points FILE OUTPUT
// The library is in no package of Debian 12, so the build of relief leaves this program out:
//   g++ -std=c++17 -O2 bench/peers/e57_points.cpp -I LIBRARY/include -lE57Format -lxerces-c
// As relief does, it leaves out invalid points, points that are not finite, and those at the
// origin.
#include <cmath>
#include <cstdio>
#include <vector>

#include <E57SimpleReader.h>

namespace {

// Coordinates in metres, or range and angles in radians, with what the file calls invalid.
struct Records {
  std::vector<double> first, second, third;
  std::vector<std::int8_t> invalid;
  bool spherical = false;

  explicit Records(std::size_t count)
      : first(count), second(count), third(count), invalid(count, 0) {}
};

Records read_records(const e57::Reader& reader, int scan) {
  e57::Data3D header;
  reader.ReadData3D(scan, header);
  Records records(static_cast<std::size_t>(header.pointCount));
  e57::Data3DPointsDouble buffers;
  records.spherical = header.pointFields.sphericalRangeField;
  if (records.spherical) {
    buffers.sphericalRange = records.first.data();
    buffers.sphericalAzimuth = records.second.data();
    buffers.sphericalElevation = records.third.data();
    if (header.pointFields.sphericalInvalidStateField)
      buffers.sphericalInvalidState = records.invalid.data();
  } else {
    buffers.cartesianX = records.first.data();
    buffers.cartesianY = records.second.data();
    buffers.cartesianZ = records.third.data();
    if (header.pointFields.cartesianInvalidStateField)
      buffers.cartesianInvalidState = records.invalid.data();
  }
  if (records.first.empty()) return records;
  auto vector = reader.SetUpData3DPointsData(scan, records.first.size(), buffers);
  vector.read();
  vector.close();
  return records;
}

void write_points(std::FILE* output, int scan, const Records& records) {
  for (std::size_t i = 0; i < records.first.size(); ++i) {
    double x = records.first[i], y = records.second[i], z = records.third[i];
    if (records.spherical) {
      const double range = x, azimuth = y, elevation = z;
      x = range * std::cos(elevation) * std::cos(azimuth);
      y = range * std::cos(elevation) * std::sin(azimuth);
      z = range * std::sin(elevation);
    }
    const bool finite = std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
    const bool origin = x == 0 && y == 0 && z == 0;
    if (records.invalid[i] == 0 && finite && !origin)
      std::fprintf(output, "%d %.17g %.17g %.17g\n", scan, x, y, z);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: e57_points FILE OUTPUT\n", stderr);
    return 2;
  }
  std::FILE* output = std::fopen(argv[2], "w");
  if (!output) return 1;
  try {
    const e57::Reader reader(argv[1], e57::ReaderOptions{});
    const auto scans = static_cast<int>(reader.GetData3DCount());
    for (int scan = 0; scan < scans; ++scan) write_points(output, scan, read_records(reader, scan));
  } catch (const e57::E57Exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[1], error.errorStr().c_str());
    return 1;
  }
  return std::fclose(output) == 0 ? 0 : 1;
}
