#include "registration/verification/given_pose_notes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "registration/pairwise/robust.h"

namespace relief::registration {

namespace {

constexpr std::size_t kFewestViews = 4;  // Three distances agree by chance.
// Errors of poses must be so many times smaller another way for it to be told, as for depth maps.
constexpr double kFarBetter = 4.0;
// Least difference of a scale from 1 that is told: calibrations of sensors are no better.
constexpr double kLeastScale = 1e-3;
// Places so much nearer than the farthest pair say nothing of the scale [fraction].
constexpr double kNear = 0.05;
// A common shift has nine unknowns with the motion of the world, and each view three equations.
constexpr std::size_t kFewestForShift = 6;
// Directions in which equations say less than this part of what they say of others: noise there
// grows ten times.
constexpr double kUndetermined = 0.1;

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

std::optional<std::string> note_on_moves(const std::vector<GivenAndFound>& views) {
  std::vector<double> moves;
  const GivenAndFound* farthest = nullptr;
  double largest = -1.0;
  for (const GivenAndFound& view : views) {
    if (!view.refined) continue;
    moves.push_back((view.found * view.centre - view.given * view.centre).norm());
    if (moves.back() >= largest) largest = moves.back(), farthest = &view;
  }
  if (moves.size() < 2 || largest == 0.0) return std::nullopt;
  std::ostringstream note;
  note << std::setprecision(2) << "refining moved the " << moves.size()
       << " views with given poses by " << quantile(moves, 0.5) << " (median), and by " << largest
       << " at most (" << farthest->name << ")";
  return note.str();
}

// Where the samples of a view are by its given and its found pose.
struct Places {
  Eigen::Vector3d given, found;
  Eigen::Matrix3d world_from_view;  // As given.
  Eigen::Vector3d sensor;           // As given.
};

std::vector<Places> places_of(const std::vector<GivenAndFound>& views) {
  std::vector<Places> places;
  for (const GivenAndFound& view : views)
    if (view.refined)
      places.push_back({view.given * view.centre, view.found * view.centre, view.given.linear(),
                        view.given.translation()});
  return places;
}

// x of `columns` x = right by least squares; 0 along directions that the columns, rotations of
// views but for a part, say less than kUndetermined of.
Eigen::VectorXd solve_determined(const Eigen::MatrixXd& columns, const Eigen::VectorXd& right) {
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  const double whole = static_cast<double>(columns.rows()) / 3.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(normal);
  Eigen::VectorXd solution = Eigen::VectorXd::Zero(columns.cols());
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const double part = parts.eigenvalues()[k];
    const Eigen::VectorXd direction = parts.eigenvectors().col(k);
    if (part > kUndetermined * kUndetermined * whole)
      solution += direction.dot(columns.transpose() * right) / part * direction;
  }
  return solution;
}

// What may have moved all views alike, besides the motion of the world.
enum class CommonError {
  kNone,
  kAcross,  // A shift in x and y of the view frames, as by wrong principal points.
  kAlong,   // A shift along z.
  kShift,   // Any shift.
  kScale,   // The places of the sensors are the given ones times a factor.
};

// What a common error by one unit moves a place by.
Eigen::MatrixXd columns_of(CommonError error, const Places& place) {
  switch (error) {
    case CommonError::kNone:
      return Eigen::MatrixXd(3, 0);
    case CommonError::kAcross:
      return place.world_from_view.leftCols<2>();
    case CommonError::kAlong:
      return place.world_from_view.rightCols<1>();
    case CommonError::kShift:
      return place.world_from_view;
    case CommonError::kScale:
      return place.sensor;
  }
  return {};
}

// A common error, and what remains with the small motion of the world that goes with it.
struct ErrorFit {
  Eigen::VectorXd amount;      // As many as columns_of().
  std::vector<double> errors;  // Of each place [unit].

  double scatter() const { return quantile(errors, 0.5); }
};

Eigen::Vector3d middle_of(const std::vector<Places>& places) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Places& place : places) middle += place.given / static_cast<double>(places.size());
  return middle;
}

// found - given = columns x amount + t + w x (given - middle), by least squares. What the motion of
// the world explains is none of the common error.
ErrorFit fit_error(const std::vector<Places>& places, CommonError error) {
  const Eigen::Vector3d middle = middle_of(places);
  double extent = 0.0;  // So that turns count by what they move.
  for (const Places& place : places) extent = std::max(extent, (place.given - middle).norm());
  if (!(extent > 0.0)) extent = 1.0;
  const auto rows = static_cast<Eigen::Index>(3 * places.size());
  Eigen::MatrixXd of_world(rows, 6), of_error(rows, columns_of(error, places.front()).cols());
  Eigen::VectorXd left(rows);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(3 * i);
    const Eigen::Vector3d arm = (places[i].given - middle) / extent;
    of_world.block<3, 3>(row, 0) << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(),
        0;
    of_world.block<3, 3>(row, 3).setIdentity();
    of_error.middleRows<3>(row) = columns_of(error, places[i]);
    left.segment<3>(row) = places[i].found - places[i].given;
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> world;
  world.setThreshold(kUndetermined);
  world.compute(of_world);
  left -= of_world * world.solve(left);
  ErrorFit fit;
  if (of_error.cols() > 0) {
    of_error -= of_world * world.solve(of_error);  // What no motion of the world explains.
    fit.amount = solve_determined(of_error, left);
    left -= of_error * fit.amount;
  }
  for (Eigen::Index i = 0; i < rows; i += 3) fit.errors.push_back(left.segment<3>(i).norm());
  return fit;
}

// The same without places that fit worse than three times the median.
ErrorFit robust_fit(const std::vector<Places>& places, CommonError error) {
  constexpr double kOutlier = 3.0;  // Medians. Of Gaussian places 0.1 % are farther off.
  const ErrorFit first = fit_error(places, error);
  const double most = kOutlier * first.scatter();
  std::vector<Places> kept;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (first.errors[i] <= most) kept.push_back(places[i]);
  return kept.size() >= kFewestForShift ? fit_error(kept, error) : first;
}

struct FittedShift {
  Eigen::Vector3d shift;
  double scatter;  // Of the places under it [unit].
};

// The shift that explains the moves of all views. Where views turn round an axis that leans
// towards them, a shift along the axis is undetermined and mixes x and y with z: then the one with
// z = 0 is taken, as long as z alone does not explain the moves.
std::optional<FittedShift> fitted_shift(const std::vector<Places>& places) {
  if (places.size() < kFewestForShift) return std::nullopt;
  const double as_given = robust_fit(places, CommonError::kNone).scatter();
  const ErrorFit across = robust_fit(places, CommonError::kAcross);
  const double along = robust_fit(places, CommonError::kAlong).scatter();
  if (std::min(as_given, along) > kFarBetter * across.scatter())
    return FittedShift{{across.amount[0], across.amount[1], 0.0}, across.scatter()};
  const ErrorFit any = robust_fit(places, CommonError::kShift);
  if (as_given > kFarBetter * any.scatter()) return FittedShift{any.amount, any.scatter()};
  return std::nullopt;
}

// Better than a scale of the places of the sensors does.
bool shift_fits_better(const std::vector<Places>& places) {
  const auto shift = fitted_shift(places);
  return shift && shift->scatter < robust_fit(places, CommonError::kScale).scatter();
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
  if (!shift || !(shift->head<2>().norm() > kFarBetter * std::abs(shift->z()))) return std::nullopt;
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

GivenAndFound given_and_found(const RangeView& view, const Eigen::Vector3d& centre,
                              const RigidMotion& given, const RigidMotion& found, bool refined) {
  return {view.name,
          given,
          found,
          centre,
          refined,
          starts_at_origin(view.camera),
          focal_lengths(view.camera)};
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
  return off > std::max(kLeastScale, kFarBetter * scatter) ? std::optional(scale) : std::nullopt;
}

std::optional<int> mirrored_axis(const std::vector<GivenAndFound>& views) {
  if (views.size() < kFewestViews) return std::nullopt;
  const Differences as_given = differences(views, std::nullopt);
  for (const int axis : {0, 1}) {
    const Differences mirrored = differences(views, axis);
    if (as_given.angle > kFarBetter * mirrored.angle &&
        as_given.shift > kFarBetter * mirrored.shift)
      return axis;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> common_shift(const std::vector<GivenAndFound>& all) {
  const auto fitted = fitted_shift(places_of(all));
  return fitted ? std::optional(fitted->shift) : std::nullopt;
}

std::vector<std::string> notes_on_given_poses(const std::vector<GivenAndFound>& views) {
  std::vector<std::string> notes;
  if (auto moves = note_on_moves(views)) notes.push_back(std::move(*moves));
  const auto scale = common_scale(views);
  auto shift = note_on_shift(views);
  // Each makes a part of the other appear: what explains the poses better is told.
  const bool shifted = shift && (!scale || shift_fits_better(places_of(views)));
  if (scale && !shifted) notes.push_back(note_on_scale(*scale));
  if (const auto axis = mirrored_axis(views)) notes.push_back(note_on_mirror(*axis));
  if (shifted) notes.push_back(std::move(*shift));
  return notes;
}

}  // namespace relief::registration
