#include "registration/given_poses/given_pose_notes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <iomanip>
#include <iterator>
#include <limits>
#include <sstream>
#include <utility>

#include <Eigen/Geometry>

#include "registration/given_poses/common_pose_shift.h"
#include "registration/pairwise/robust.h"

namespace relief::registration {

namespace {

constexpr std::size_t kFewestViews = 4;  // Three distances agree by chance.
// Least difference of a scale from 1 that is told: calibrations of sensors are no better.
constexpr double kLeastScale = 1e-3;
// Places so much nearer than the farthest pair say nothing of the scale [fraction].
constexpr double kNear = 0.05;

// Pairs of neighbours in the order of the views, and of views a third of them apart. Half would be
// half a turn where they go round, which is the same in a mirror.
std::vector<std::pair<std::size_t, std::size_t>> some_pairs(std::size_t views) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < views; ++i)
    for (const std::size_t step : {std::size_t{1}, std::max<std::size_t>(1, views / 3)})
      pairs.emplace_back(i, (i + step) % views);
  return pairs;
}

double place_distance(const RigidMotion& a, const RigidMotion& b) {
  return (a.translation() - b.translation()).norm();
}

// Medians over pairs of views of how much their relative poses differ.
struct Differences {
  double angle = 0.0;  // [rad]
  double shift = 0.0;  // [unit]
};

// The given poses being those in a mirror along `axis` of each view; none: as they are.
Differences differences(const std::vector<GivenAndFound>& views, std::optional<int> axis) {
  Eigen::Vector3d sides = Eigen::Vector3d::Ones();
  if (axis) sides[*axis] = -1.0;
  std::vector<double> angles, shifts;
  for (const auto& [i, j] : some_pairs(views.size())) {
    const RigidMotion found = views[i].found.inverse() * views[j].found;
    const RigidMotion given = views[i].given.inverse() * views[j].given;
    const Eigen::Matrix3d rotation = sides.asDiagonal() * given.linear() * sides.asDiagonal();
    angles.push_back(Eigen::AngleAxisd(rotation.transpose() * found.linear()).angle());
    shifts.push_back((found.translation() - sides.cwiseProduct(given.translation())).norm());
  }
  return {quantile(std::move(angles), 0.5), quantile(std::move(shifts), 0.5)};
}

// Of the views that refining started from given poses.
std::vector<double> moves_of(const std::vector<GivenAndFound>& views) {
  std::vector<double> moves;
  for (const GivenAndFound& view : views)
    if (view.refined) moves.push_back(move_of(view));
  return moves;
}

std::optional<std::string> note_on_moves(const std::vector<GivenAndFound>& views) {
  const std::vector<double> moves = moves_of(views);
  const GivenAndFound* farthest = nullptr;
  double largest = -1.0;
  for (const GivenAndFound& view : views)
    if (view.refined && move_of(view) >= largest) largest = move_of(view), farthest = &view;
  if (moves.size() < 2 || largest == 0.0) return std::nullopt;
  std::ostringstream note;
  note << std::setprecision(2) << "refining moved the " << moves.size()
       << " views with given poses by " << quantile(moves, 0.5) << " (median), and by " << largest
       << " at most (" << farthest->name << ")";
  return note.str();
}

// What moves the principal points of the views by pixels so that their samples shift so.
std::optional<Eigen::Vector2d> principal_point_shift(const std::vector<GivenAndFound>& views,
                                                     const Eigen::Vector3d& shift) {
  std::vector<double> x, y;
  for (const GivenAndFound& view : views) {
    if (!view.focal_lengths || view.centre.z() == 0.0) continue;
    const Eigen::Vector2d pixels =
        -shift.head<2>().cwiseProduct(*view.focal_lengths) / std::abs(view.centre.z());
    x.push_back(pixels.x());
    y.push_back(pixels.y());
  }
  if (x.empty()) return std::nullopt;
  return Eigen::Vector2d(quantile(std::move(x), 0.5), quantile(std::move(y), 0.5));
}

// A shift of less than a pixel is no mistake of a file, and one along the rays none of the
// principal point.
std::optional<std::string> note_on_shift(const std::vector<GivenAndFound>& views) {
  const auto shift = common_shift(views);
  if (!shift || !(shift->head<2>().norm() > kTellingRatio * std::abs(shift->z())))
    return std::nullopt;
  const auto pixels = principal_point_shift(views, *shift);
  if (!pixels || pixels->norm() < 1.0) return std::nullopt;
  char note[400];
  std::snprintf(
      note, sizeof note,
      "all views were found off their given poses by (%.2g, %.2g, %.2g) in their own "
      "frames: either the principal points (cx, cy) are off, as where images were cropped "
      "and the camera is that of the whole ones, and right when moved by (%.1f, %.1f) "
      "pixels; or the poses are those of another camera beside the sensor",
      shift->x(), shift->y(), shift->z(), pixels->x(), pixels->y());
  return note;
}

// No focal length nor scale of depths is so far off.
constexpr double kOnePlace = 0.02;

std::string note_on_scale(double scale) {
  std::ostringstream note;
  note << std::setprecision(4) << "views were found " << scale
       << " times as far apart as their given poses are: ";
  if (scale < kOnePlace) {
    note << "the unit of the poses is another, or views were laid on what stands still before the "
            "camera, as a wall or a table; leave that out by masks";
    return note.str();
  }
  note << "ranges are " << std::setprecision(2) << 100.0 * std::abs(scale - 1.0) << " % too "
       << (scale > 1.0 ? "long" : "short")
       << ", as with a wrong focal length or depth scale, or the unit of the poses is another";
  return note.str();
}

std::string note_on_mirror(int axis) {
  return std::string("the poses found are the given ones in a mirror: the images are mirrored, ") +
         (axis == 0 ? "left to right" : "top to bottom") +
         ", and so is the model, or the given poses turn the wrong way round";
}

// How far apart two poses of a view put its sensor, or the middle of its samples, at most.
double distance_between(const RigidMotion& a, const RigidMotion& b, const Eigen::Vector3d& centre) {
  return std::max(place_distance(a, b), (a * centre - b * centre).norm());
}

// The world of the poses found from that of the given ones, by the view for which the others are
// nearest to their given poses in the median, and that median. Of many views a few are tried: more
// than half of them are at their own poses, or nothing is told.
std::pair<RigidMotion, double> found_from_given(const std::vector<GivenAndFound>& views) {
  constexpr std::size_t kTried = 50;
  std::pair<RigidMotion, double> best(RigidMotion::Identity(),
                                      std::numeric_limits<double>::infinity());
  const std::size_t step = std::max<std::size_t>(1, views.size() / kTried);
  for (std::size_t k = 0; k < views.size(); k += step) {
    const RigidMotion world = views[k].found * views[k].given.inverse();
    std::vector<double> off;
    for (const GivenAndFound& view : views)
      if (&view != &views[k])
        off.push_back(distance_between(view.found, world * view.given, view.centre));
    if (const double median = quantile(std::move(off), 0.5); median < best.second)
      best = {world, median};
  }
  return best;
}

std::string note_on_exchanged(const std::vector<GivenAndFound>& views,
                              const std::vector<std::pair<std::size_t, std::size_t>>& exchanged) {
  const auto& [a, b] = exchanged.front();
  std::string note = "views " + views[a].name + " and " + views[b].name;
  if (exchanged.size() > 1)
    note += ", and " + std::to_string(exchanged.size() - 1) + " more pairs,";
  return note +
         " seem to have changed places: each was found at the given pose of the other; check the "
         "names of their files, or their poses";
}

// Whether all rays do.
bool starts_at_origin(const Camera& camera) {
  return camera.ray(0, 0).origin.isZero() &&
         camera.ray(camera.width() - 1, camera.height() - 1).origin.isZero();
}

std::optional<Eigen::Vector2d> focal_lengths(const Camera& camera) {
  if (camera.model() != Camera::Model::kPinhole && camera.model() != Camera::Model::kPinholeGl)
    return std::nullopt;
  return Eigen::Vector2d(camera.intrinsics().fx, camera.intrinsics().fy);
}

}  // namespace

std::vector<GivenAndFound> given_and_found(const std::vector<RangeView>& views,
                                           const std::vector<ViewSurface>& surfaces,
                                           const PoseConvention& convention, const Alignment& found,
                                           const std::vector<bool>& refined) {
  std::vector<GivenAndFound> given;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const RangeView& view = views[i];
    if (view.pose == PoseKind::kGuess && found.views[i].aligned && !surfaces[i].samples().empty())
      given.push_back({view.name, convention.world_from_view(view.world_from_view),
                       found.views[i].world_from_view, surfaces[i].centre(), refined[i],
                       starts_at_origin(view.camera), focal_lengths(view.camera),
                       surfaces[i].spacing()});
  }
  return given;
}

std::optional<double> common_scale(const std::vector<GivenAndFound>& all) {
  std::vector<GivenAndFound> views;
  std::ranges::copy_if(all, std::back_inserter(views), &GivenAndFound::from_origin);
  if (views.size() < kFewestViews) return std::nullopt;
  const auto pairs = some_pairs(views.size());
  double farthest = 0.0;
  for (const auto& [i, j] : pairs)
    farthest = std::max(farthest, place_distance(views[i].given, views[j].given));
  std::vector<double> ratios;
  for (const auto& [i, j] : pairs) {
    const double given = place_distance(views[i].given, views[j].given);
    if (given > kNear * farthest)
      ratios.push_back(place_distance(views[i].found, views[j].found) / given);
  }
  if (ratios.size() < kFewestViews) return std::nullopt;
  const double scale = quantile(ratios, 0.5);
  for (double& ratio : ratios) ratio = std::abs(ratio - scale);
  const double scatter = quantile(std::move(ratios), 0.5);
  const double off = std::abs(scale - 1.0);
  return off > std::max(kLeastScale, kTellingRatio * scatter) ? std::optional(scale) : std::nullopt;
}

std::optional<int> mirrored_axis(const std::vector<GivenAndFound>& views) {
  if (views.size() < kFewestViews) return std::nullopt;
  const Differences as_given = differences(views, std::nullopt);
  for (const int axis : {0, 1}) {
    const Differences mirrored = differences(views, axis);
    if (as_given.angle > kTellingRatio * mirrored.angle &&
        as_given.shift > kTellingRatio * mirrored.shift)
      return axis;
  }
  return std::nullopt;
}

std::vector<std::pair<std::size_t, std::size_t>> exchanged_views(
    const std::vector<GivenAndFound>& views) {
  if (views.size() < kFewestViews) return {};
  const auto [world, typical] = found_from_given(views);
  const auto distance = [&, &world = world](std::size_t found, std::size_t given) {
    return distance_between(views[found].found, world * views[given].given, views[found].centre);
  };
  const auto is_near = [&, typical = typical](std::size_t i, double off) {
    return off <= std::max(kTellingRatio * typical, views[i].spacing);
  };
  std::vector<std::size_t> elsewhere;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!is_near(i, distance(i, i))) elsewhere.push_back(i);
  if (2 * elsewhere.size() >= views.size()) return {};
  const auto is_at = [&](std::size_t i, std::size_t j) {
    const double off = distance(i, j);
    return is_near(i, off) && kTellingRatio * off < distance(i, i);
  };
  std::vector<std::pair<std::size_t, std::size_t>> exchanged;
  for (const std::size_t i : elsewhere)
    for (const std::size_t j : elsewhere)
      if (i < j && is_at(i, j) && is_at(j, i)) exchanged.emplace_back(i, j);
  return exchanged;
}

double move_of(const GivenAndFound& view) {
  return (view.found * view.centre - view.given * view.centre).norm();
}

double median_move(const std::vector<GivenAndFound>& views) {
  std::vector<double> moves = moves_of(views);
  return moves.size() < 2 ? 0.0 : quantile(std::move(moves), 0.5);
}

std::vector<std::string> notes_on_given_poses(const std::vector<GivenAndFound>& views) {
  std::vector<std::string> notes;
  if (auto moves = note_on_moves(views)) notes.push_back(std::move(*moves));
  if (const auto exchanged = exchanged_views(views); !exchanged.empty())
    notes.push_back(note_on_exchanged(views, exchanged));
  const auto scale = common_scale(views);
  auto shift = note_on_shift(views);
  // Each makes a part of the other appear: what explains the poses better is told.
  const bool shifted = shift && (!scale || shift_explains_more_than_scale(views));
  if (scale && !shifted) notes.push_back(note_on_scale(*scale));
  if (const auto axis = mirrored_axis(views)) notes.push_back(note_on_mirror(*axis));
  if (shifted) notes.push_back(std::move(*shift));
  return notes;
}

}  // namespace relief::registration
