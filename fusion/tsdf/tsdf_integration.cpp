#include "fusion/tsdf/tsdf_integration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace relief::fusion {

namespace {

// Observations of empty space must outweigh those of matter by this factor to overrule them. At 1
// one view against one would end by chance; at 4 a stray sample would take five views to remove.
constexpr double kOverrule = 2.0;

// Cosine between the normals of two surfaces that are the sides of one plate, 120 degrees: the
// faces of an edge as sharp as 60 degrees still both count. At 0 noise decides about those of
// boxes.
constexpr double kOpposite = -0.5;

// Truncation distances along the ray up to which a distance is believed: all of them up to 60
// degrees (1 / cos). A ray that grazes stays close to the tangent plane beyond the object.
constexpr double kGrazingReach = 2.0;

// Farther along the ray than that no distance is believed, however depths are rounded [reaches].
// Floats round by 6e-8: enough up to depths of 30,000 truncation distances (0.002 / 6e-8).
constexpr double kFarAway = 1.001;

// Nodes within one spacing of the zero set decide where the surface is; half of one more is room
// for the error of distances. Below 1 such nodes are left out, above 2 none is gained.
constexpr double kFootReach = 1.5;  // [lattice spacings]

// Behind the surface a sample says nothing of where the object ends again, except this near: with
// less, the node behind the surface on an edge would be unknown, and the sign need not change.
constexpr double kLeastDepth = 1.0;  // [lattice spacings]

// Nor there, where another view has seen this much empty space around: at a corner that few views
// see. Thorns of up to this height may stay, of twice with twice; 0 drops matter by mere noise.
constexpr double kSeenThrough = 0.25;  // [lattice spacings]

// From the outermost samples (0) inwards, where rays surely meet the surface. At 0 they would do so
// at its very rim; at 1 all of the outermost pixel would be left unknown.
constexpr double kAmongRays = 0.25;  // [pixels]

bool measures(const Observation& seen, double truncation, double spacing) {
  const double depth = std::min(truncation, std::max(seen.matter_depth, kLeastDepth * spacing));
  return !seen.noisy && seen.distance < truncation && seen.distance > -depth &&
         seen.range_gap < kGrazingReach * truncation;
}

// How far a filled vertex may be in space seen empty, as presumed matter (kSeenThrough), and in
// front of a surface where the outermost rays meet it, as measured vertices (vertex_attributes).
constexpr double kIntrusion = 0.25, kInFront = 0.5;  // [voxels]

}  // namespace

bool TsdfIntegrator::in_empty_space(const Eigen::Vector3d& point) {
  const TsdfSample evidence = collect(point);
  return evidence.clearance > kIntrusion * spacing_ || evidence.in_front > kInFront * spacing_;
}

double tukey_biweight(double relative_distance) {
  const double inside = 1.0 - relative_distance * relative_distance;
  return inside > 0.0 ? inside * inside : 0.0;
}

// By everything that enters a sum.
bool TsdfIntegrator::TsdfObservation::operator<(const TsdfObservation& other) const {
  return std::tie(distance, weight, information, relative_stddev, normal.x(), normal.y(),
                  normal.z()) < std::tie(other.distance, other.weight, other.information,
                                         other.relative_stddev, other.normal.x(), other.normal.y(),
                                         other.normal.z());
}

// Of the two sides of a thin plate only the nearer one tells the distance to the plate.
void TsdfIntegrator::drop_far_side() {
  const auto nearest = std::min_element(near_.begin(), near_.end(),
                                        [](const TsdfObservation& a, const TsdfObservation& b) {
                                          return std::abs(a.distance) < std::abs(b.distance);
                                        });
  if (nearest == near_.end()) return;
  const Eigen::Vector3d facing = nearest->normal;
  std::erase_if(near_, [&](const TsdfObservation& observation) {
    return observation.normal.dot(facing) < kOpposite;
  });
}

bool TsdfIntegrator::has_to_say(const ViewSampler& view, const Eigen::AlignedBox3d& box) const {
  return view.concerns(box, largest_range_gap(view));
}

void TsdfIntegrator::narrow(const Eigen::AlignedBox3d& box) {
  candidates_.clear();
  for (const ViewSampler& view : views_)
    if (has_to_say(view, box)) candidates_.push_back(&view);
}

void TsdfIntegrator::focus(const Eigen::AlignedBox3d& box) {
  concerned_.clear();
  for (const ViewSampler* view : candidates_)
    if (has_to_say(*view, box)) concerned_.push_back(view);
}

// What of it is due to the errors of views grows with them.
double TsdfIntegrator::truncation_at(const ViewSampler& view, double relative_stddev) const {
  const double due = std::min(truncation_, kTruncatedDeviations * view.range_errors().stddev);
  return truncation_ + due * std::max(0.0, relative_stddev - 1.0);
}

// With a larger one no point is measured.
double TsdfIntegrator::largest_range_gap(const ViewSampler& view) const {
  return kGrazingReach * truncation_at(view, view.largest_relative_stddev());
}

TsdfSample TsdfIntegrator::collect(const Eigen::Vector3d& point) {
  find_quads(point);
  return combine(nullptr);
}

TsdfSample TsdfIntegrator::collect(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  find_quads(point);
  return combine(&normal);
}

TsdfSample TsdfIntegrator::collect_as_far_as(double enough, const Eigen::Vector3d& point) {
  find_quads(point);
  if (std::any_of(sightings_.begin(), sightings_.end(), [](const Sighting& sighting) {
        return sighting.side == ViewSampler::Side::kNear;
      }))
    return combine(nullptr);
  TsdfSample sample;
  for (const Sighting& sighting : sightings_) {
    if (const auto seen = sighting.view->observe(sighting.quad, 0.0))
      sample.clearance = std::max(sample.clearance, seen->clearance);
    if (sample.clearance >= enough) break;
  }
  return sample;
}

// Far behind its surface a view knows nothing.
void TsdfIntegrator::find_quads(const Eigen::Vector3d& point) {
  sightings_.clear();
  for (const ViewSampler* view : concerned_) {
    const auto quad = view->quad_on_ray_of(point);
    if (!quad) continue;
    const ViewSampler::Side side = view->side(*quad, kFarAway * largest_range_gap(*view));
    if (side != ViewSampler::Side::kBehind) sightings_.push_back({view, *quad, side});
  }
}

std::optional<Eigen::Vector3d> TsdfIntegrator::colour(const Eigen::Vector3d& point) const {
  // Weight and colour. In an order of their own: views that agree in all else may differ here.
  std::vector<std::array<double, 4>> seen;
  for (const TsdfObservation& observation : near_)
    if (const auto colour = observation.view->colour(point); colour && observation.weight > 0.0)
      seen.push_back({observation.weight, colour->x(), colour->y(), colour->z()});
  if (seen.empty()) return std::nullopt;
  std::sort(seen.begin(), seen.end());
  double weights = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [weight, red, green, blue] : seen) {
    weights += weight;
    sum += weight * Eigen::Vector3d(red, green, blue);
  }
  return sum / weights;
}

std::optional<std::size_t> TsdfIntegrator::strongest_view() const {
  const TsdfObservation* strongest = nullptr;
  for (const TsdfObservation& observation : near_)
    if (!strongest || observation.weight > strongest->weight ||
        (observation.weight == strongest->weight && observation.view < strongest->view))
      strongest = &observation;
  if (!strongest || !(strongest->weight > 0.0)) return std::nullopt;
  return static_cast<std::size_t>(strongest->view - views_.data());
}

TsdfSample TsdfIntegrator::combine(const Eigen::Vector3d* normal) {
  near_.clear();
  empty_.clear();
  TsdfSample sample;
  for (const auto& [view, quad, side] : sightings_) {
    const auto seen = view->observe(quad, kFootReach * spacing_);
    if (!seen || (normal && seen->normal.dot(*normal) <= 0.0)) continue;
    const double truncation = truncation_at(*view, seen->relative_stddev);
    const double near = tukey_biweight(seen->distance / truncation);
    if (measures(*seen, truncation, spacing_))
      near_.push_back({seen->distance, seen->weight * near, seen->information * near,
                       seen->relative_stddev, seen->normal, seen->distance < -seen->matter_depth,
                       view});
    else if (seen->clearance > 0.5 * truncation)
      empty_.push_back({seen->distance, seen->weight, seen->information, seen->relative_stddev,
                        seen->normal, false, view});
    sample.clearance = std::max(sample.clearance, seen->clearance);
    if (seen->border >= kAmongRays) sample.in_front = std::max(sample.in_front, seen->in_front);
  }
  if (sample.clearance > kSeenThrough * spacing_)
    std::erase_if(near_, [](const TsdfObservation& observation) { return observation.presumed; });
  // Sums in the order of the values: the order of the views does not matter, not even by rounding.
  std::sort(near_.begin(), near_.end());
  std::sort(empty_.begin(), empty_.end());
  drop_far_side();

  double squares = 0.0, inside = 0.0, empty = 0.0;
  for (const TsdfObservation& observation : near_) {
    sample.weight += observation.weight;
    sample.information += observation.information;
    squares += observation.weight * observation.weight;
    sample.relative_variance += std::pow(observation.weight * observation.relative_stddev, 2);
    sample.distance += observation.weight * observation.distance;
    if (observation.distance < 0.0) inside += observation.weight;
  }
  for (const TsdfObservation& observation : empty_) empty += observation.weight;
  if (!(sample.weight > 0.0)) return sample;
  sample.distance /= sample.weight;
  sample.measured = sample.distance >= 0.0 || empty <= kOverrule * inside;
  for (const TsdfObservation& observation : near_) {
    const double deviation = observation.distance - sample.distance;
    sample.variance += observation.weight * deviation * deviation / sample.weight;
  }
  sample.effective_views = sample.weight * sample.weight / squares;
  sample.relative_variance /= sample.weight * sample.weight;
  sample.views = static_cast<int>(near_.size());
  return sample;
}

}  // namespace relief::fusion
