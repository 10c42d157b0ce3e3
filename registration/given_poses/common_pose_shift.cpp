#include "registration/given_poses/common_pose_shift.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "registration/pairwise/robust.h"

namespace relief::registration {

namespace {

// A common shift has nine unknowns with the motion of the world, and each view three equations.
constexpr std::size_t kFewestForShift = 6;
// Directions in which equations say less than this part of what they say of others: noise there
// grows ten times.
constexpr double kUndetermined = 0.1;

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

// x of `columns` x = right by least squares; 0 along directions that the columns, which have a
// length of 1 by place but for a part, say less than kUndetermined of.
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

// Of the columns, by place: 1 for shifts; 1 also where there is nothing.
double root_mean_square(const Eigen::MatrixXd& columns) {
  const double size = std::sqrt(3.0 * columns.squaredNorm() / static_cast<double>(columns.size()));
  return size > 0.0 ? size : 1.0;
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
    const double size = root_mean_square(of_error);
    of_error /= size;
    of_error -= of_world * world.solve(of_error);  // What no motion of the world explains.
    fit.amount = solve_determined(of_error, left);
    left -= of_error * fit.amount;
    fit.amount /= size;
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
  if (std::min(as_given, along) > kTellingRatio * across.scatter())
    return FittedShift{{across.amount[0], across.amount[1], 0.0}, across.scatter()};
  const ErrorFit any = robust_fit(places, CommonError::kShift);
  if (as_given > kTellingRatio * any.scatter()) return FittedShift{any.amount, any.scatter()};
  return std::nullopt;
}

}  // namespace

std::optional<Eigen::Vector3d> common_shift(const std::vector<GivenAndFound>& all) {
  const auto fitted = fitted_shift(places_of(all));
  return fitted ? std::optional(fitted->shift) : std::nullopt;
}

bool shift_explains_more_than_scale(const std::vector<GivenAndFound>& all) {
  const std::vector<Places> places = places_of(all);
  const auto shift = fitted_shift(places);
  return shift && shift->scatter < robust_fit(places, CommonError::kScale).scatter();
}

}  // namespace relief::registration
