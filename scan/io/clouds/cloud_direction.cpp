#include "scan/io/clouds/cloud_direction.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

#include <Eigen/Core>

#include "scan/base/linear_algebra.h"
#include "scan/base/median.h"
#include "scan/io/clouds/direction_judge.h"
#include "scan/io/clouds/lidar_rings.h"
#include "scan/io/clouds/nearest_points.h"

namespace relief {

namespace {

// All over the sphere, sqrt(4 pi / 240) = 13 degrees apart: refine_direction() turns by 8 at first.
constexpr int kDirections = 240;
// Side of a cell [spacings] where points lie all around, near ones close together and far ones
// apart, and a lidar without rows of rays puts them at random. In smaller cells far points lie
// alone, and none hides another one. In larger ones edges hide points from their own sensor.
constexpr double kCellAround = 4.0;
// Of the picture's area against hidden points: half of the area is worth 2.5 % of the points. 0
// leaves open which way an open surface is seen; 1 takes wide pictures that hide points.
constexpr double kAreaWeight = 0.05;
// Fraction of hidden points that makes no difference: 2.5 standard errors of 0.2 among the points
// that are judged.
constexpr double kAsGood = 0.005;

// Of the points, at either end of the box that the origin must lie outside of. Depth cameras that
// were tried have strays among a few thousandths.
constexpr double kOutermost = 0.01;

// Fraction of the points that parallel rays hide of what was seen from one side, at most: of scans
// that were tried up to 0.03. Stations in their surroundings have 0.07 and more.
constexpr double kOneSide = 0.05;
// What parallel rays hide of a height map, whose points may stand in rows, at most. Of streets,
// seen from above, it is 0.03.
constexpr double kHeightMap = 0.002;
// Of the points that parallel rays hide, so many may be hidden from the sensor itself: 0 to 0.34 in
// surroundings that were tried, where edges hide some in large cells. At 1 noise decides. Of all
// points on the rings of a lidar: up to 0.07, and more than half where normals look away.
constexpr double kHiddenFromSensor = 0.5;

// Standard errors by which fractions of points must differ.
constexpr double kStandardErrors = 2.5;

// Evenly over the sphere, on a spiral of golden angles.
std::vector<Eigen::Vector3d> sphere_directions() {
  std::vector<Eigen::Vector3d> directions;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, radius = std::sqrt(1.0 - z * z);
    directions.emplace_back(radius * std::cos(golden * i), radius * std::sin(golden * i), z);
  }
  return directions;
}

std::vector<Eigen::Vector3d> principal_axes(const std::vector<Eigen::Vector3d>& points,
                                            const Eigen::Vector3d& centre) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& point : points) covariance += (point - centre) * (point - centre).transpose();
  const auto eigen = eigen_decomposition(covariance);
  std::vector<Eigen::Vector3d> axes;
  for (Eigen::Index k = 0; k < 3; ++k) {
    axes.push_back(eigen.eigenvectors().col(k));
    axes.push_back(-eigen.eigenvectors().col(k));
  }
  return axes;
}

// The mean normal, if there are any, is a good start.
std::vector<Eigen::Vector3d> start_directions(const DirectionJudge& judge) {
  std::vector<Eigen::Vector3d> starts = principal_axes(judge.points(), judge.centre());
  const auto sphere = sphere_directions();
  starts.insert(starts.end(), sphere.begin(), sphere.end());
  // Both ways along parallel rays are alike without normals.
  if (!judge.has_normals())
    std::erase_if(starts, [](const Eigen::Vector3d& d) { return d.z() > 0.0; });
  return starts;
}

// Fewest hidden points first; the area of the picture decides among equals.
struct JudgedDirection {
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitZ();
  DirectionScore score;

  double cost(double largest_area) const {
    return score.hidden +
           kAreaWeight * (1.0 - static_cast<double>(score.cells) / std::max(1.0, largest_area));
  }
};

JudgedDirection refine_direction(JudgedDirection best, double largest_area, DirectionJudge& judge) {
  for (double angle_deg = 8.0; angle_deg >= 1.0; angle_deg *= 0.5) {
    const Eigen::Vector3d side = best.direction.unitOrthogonal();
    const Eigen::Vector3d centre = best.direction;
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d axis = Eigen::AngleAxisd(k * std::numbers::pi / 4.0, centre) * side;
      const Eigen::Vector3d turned =
          Eigen::AngleAxisd(angle_deg * std::numbers::pi / 180.0, axis) * centre;
      const JudgedDirection candidate{turned, judge.score(turned)};
      if (candidate.cost(largest_area) < best.cost(largest_area)) best = candidate;
    }
  }
  return best;
}

JudgedDirection best_direction(DirectionJudge& judge) {
  std::vector<JudgedDirection> judged;
  double largest_area = 0.0;
  for (const auto& direction : start_directions(judge)) {
    judged.push_back({direction, judge.score(direction)});
    largest_area = std::max(largest_area, static_cast<double>(judged.back().score.cells));
  }
  const auto cheaper = [&](const JudgedDirection& a, const JudgedDirection& b) {
    return a.cost(largest_area) < b.cost(largest_area);
  };
  return refine_direction(*std::min_element(judged.begin(), judged.end(), cheaper), largest_area,
                          judge);
}

// The box of all but the outermost points in each direction, `part` of them at either end: what a
// depth camera says of far places scatters over many times the size of the scene.
Eigen::AlignedBox3d inner_box(const std::vector<Eigen::Vector3d>& points, double part) {
  Eigen::AlignedBox3d box;
  const auto outer =
      static_cast<std::ptrdiff_t>(std::floor(part * static_cast<double>(points.size())));
  std::vector<double> places(points.size());
  for (Eigen::Index axis = 0; axis < 3 && !points.empty(); ++axis) {
    std::ranges::transform(points, places.begin(), [&](const auto& point) { return point[axis]; });
    std::ranges::nth_element(places, places.begin() + outer);
    box.min()[axis] = places[static_cast<std::size_t>(outer)];
    std::ranges::nth_element(places, places.end() - 1 - outer);
    box.max()[axis] = *(places.end() - 1 - outer);
  }
  return box;
}

bool lie_before_origin(const std::vector<Eigen::Vector3d>& points) {
  const Eigen::AlignedBox3d box = inner_box(points, kOutermost);
  return box.exteriorDistance(Eigen::Vector3d::Zero().eval()) > 0.05 * box.diagonal().norm();
}

// Whether fewer points lie behind gaps on rays from the origin than on parallel ones.
// Surfaces with holes, as thinned walls and trees, let points be seen behind them in wide cells.
bool has_fewer_gaps(const CloudRays& from_origin, const JudgedDirection& best,
                    const DirectionJudge& judge) {
  const GapScore here = judge.score_gaps(from_origin);
  const GapScore far_off = judge.score_gaps(parallel_rays(best.direction, judge.centre()));
  return here.behind + kStandardErrors * here.standard_error <
         kHiddenFromSensor * (far_off.behind - kStandardErrors * far_off.standard_error);
}

// The origin as the sensor where the points lie all around it, if they look as seen from there.
std::optional<CloudDirection> from_among_points(const PointCloudFile& cloud,
                                                const CloudRays& from_origin,
                                                const JudgedDirection& best,
                                                DirectionJudge& judge) {
  judge.set_cell(kCellAround);
  const double hidden = judge.score(from_origin).hidden;
  const double from_far = best_direction(judge).score.hidden;
  if (from_far > kOneSide && hidden < kHiddenFromSensor * from_far)
    return CloudDirection{from_origin, hidden,
                          "the origin of the frame, all around which the points lie"};
  const char* why = nullptr;
  if (best.score.hidden > kOneSide && has_fewer_gaps(from_origin, best, judge))
    why = "the origin of the frame, from where few points lie far behind others";
  else if (best.score.hidden > kHeightMap && on_lidar_rings(cloud.points))
    why = "the origin of the frame, around which the points lie on the rings of a lidar";
  if (!why) return std::nullopt;
  judge.set_cell(DirectionJudge::kCell);
  const double hidden_in_small_cells = judge.score(from_origin).hidden;
  if (hidden_in_small_cells < kHiddenFromSensor)
    return CloudDirection{from_origin, hidden_in_small_cells, why};
  return std::nullopt;
}

}  // namespace

std::vector<std::size_t> some_points(std::size_t count, std::size_t most) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    // A hash, not every n-th: points in files stand in rows.
    const std::uint64_t hash = (i + 1) * 0x9E3779B97F4A7C15ull;
    const double place = static_cast<double>((hash ^ hash >> 29) * 0xBF58476D1CE4E5B9ull >> 11) *
                         0x1p-53 * static_cast<double>(count);
    if (count <= most || place < static_cast<double>(most)) chosen.push_back(i);
  }
  return chosen;
}

double nearest_spacing(const std::vector<Eigen::Vector3d>& points) {
  constexpr std::size_t kQueries = 4000;  // Bounds the time.
  const NearestPoints<3> tree(points);
  std::vector<double> distances;
  for (const std::size_t i : some_points(points.size(), kQueries))
    if (const auto found = tree.find(points[i], 1); !found.empty())
      distances.push_back(std::sqrt(found.front().squared_distance));
  return median(distances);
}

double hidden_fraction(const PointCloudFile& cloud, const CloudRays& rays) {
  return DirectionJudge(cloud).score(rays).hidden;
}

CloudDirection find_direction(const PointCloudFile& cloud) {
  DirectionJudge judge(cloud);
  const JudgedDirection best = best_direction(judge);
  const CloudRays from_origin = rays_from(Eigen::Vector3d::Zero(), cloud.points);
  const bool around_origin = surround(cloud.points, from_origin);
  if (!around_origin && lie_before_origin(cloud.points)) {
    const double hidden = judge.score(from_origin).hidden;
    // In a view so wide that it is no picture, points may share rays: it must be clearly better.
    const bool is_picture = from_origin.kind == CloudRays::Kind::kPinhole;
    if (is_picture || cloud.missing_at_origin
            ? hidden <= best.score.hidden + kAsGood
            : best.score.hidden > kHeightMap && hidden <= kHiddenFromSensor * best.score.hidden)
      return {from_origin, hidden, "the origin of the frame, in front of which all points lie"};
  }
  if (around_origin)
    if (auto found = from_among_points(cloud, from_origin, best, judge)) return *found;
  const CloudRays rays = parallel_rays(best.direction, judge.centre());
  if (judge.has_normals())
    return {rays, best.score.hidden, "the side that the normals face", true, around_origin};
  return {rays, best.score.hidden, "", false, around_origin};
}

}  // namespace relief
