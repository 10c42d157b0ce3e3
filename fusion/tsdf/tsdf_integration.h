#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "fusion/views/view_sampler.h"

namespace relief::fusion {

/// What all views together say about a point.
struct TsdfSample {
  bool measured = false;   ///< Some view measured the surface within the truncation distance.
  double distance = 0.0;   ///< If measured: signed distance [unit], positive outside.
  double clearance = 0.0;  ///< The signed distance is at least this wherever it is positive.
  double in_front = 0.0;   ///< The most that a view surely sees it in front of its surface [unit],
                           ///< by rays among others that meet the same surface.
  double weight = 0.0;     ///< Sum of the weights of the measuring views.
  double information = 0.0;      ///< Sum of these weights without the ramp from the silhouette.
  double effective_views = 0.0;  ///< (sum w)^2 / sum w^2.
  /// Of the mean, in units of that of one view at the typical distance from its sensor:
  /// sum (w rho)^2 / (sum w)^2 with the relative standard deviations rho of the views.
  double relative_variance = 0.0;
  double variance = 0.0;  ///< Weighted variance of the views' distances [unit^2].
  int views = 0;          ///< Number of measuring views.
};

/// t of (F4), for a distance relative to the truncation: Tukey's biweight. Of surfaces close
/// together the nearer one counts most, and the average stays unbiased where the surface is.
double tukey_biweight(double relative_distance);

/// Combines the views' signed distances (Curless and Levoy 1996) as docs/fusion.md has it.
/// Keeps scratch memory: one object per thread.
class TsdfIntegrator {
 public:
  /// Views measure up to `truncation` from their surface, on a lattice of `spacing`. Where a view
  /// errs more than at the typical range, by its range errors, it measures farther by as many more
  /// of its standard deviations as a truncation holds.
  TsdfIntegrator(const std::vector<ViewSampler>& views, double truncation, double spacing)
      : views_(views), truncation_(truncation), spacing_(spacing) {
    for (const ViewSampler& view : views_) candidates_.push_back(&view);
    concerned_ = candidates_;
  }

  /// Says that boxes for focus() lie in `box` from now on: focus() then looks at few of many views.
  void narrow(const Eigen::AlignedBox3d& box);
  /// Asks from now on only the views that have something to say of points in `box`.
  void focus(const Eigen::AlignedBox3d& box);

  TsdfSample collect(const Eigen::Vector3d& point);

  /// Whether a view saw space empty at a point, where a filled surface may not lie. It may reach a
  /// little into it, as presumed matter and measured vertices do.
  bool in_empty_space(const Eigen::Vector3d& point);

  /// As collect(), in less time where no view has its surface near the point: then not `measured`,
  /// with a `clearance` that is right as far as `enough` [unit], and nothing else.
  TsdfSample collect_as_far_as(double enough, const Eigen::Vector3d& point);

  /// The same from the views only that see the surface from the side `normal` points to.
  TsdfSample collect(const Eigen::Vector3d& point, const Eigen::Vector3d& normal);

  /// The mean colour, 0 to 255, of the views that measured the point collected last, by the weights
  /// of their distances; nothing when none of them has colours.
  std::optional<Eigen::Vector3d> colour(const Eigen::Vector3d& point) const;

  /// The view whose distance has the largest weight at the point collected last, by its index; of
  /// equal ones the first. Nothing when no view measured the point.
  std::optional<std::size_t> strongest_view() const;

 private:
  bool has_to_say(const ViewSampler& view, const Eigen::AlignedBox3d& box) const;
  void find_quads(const Eigen::Vector3d& point);
  TsdfSample combine(const Eigen::Vector3d* normal);

  struct Sighting {
    const ViewSampler* view;
    ViewSampler::Quad quad;
    ViewSampler::Side side;
  };

  struct TsdfObservation {
    double distance, weight, information, relative_stddev;
    Eigen::Vector3d normal;
    bool presumed;  // Behind the surface, deeper than the view knows of matter.
    const ViewSampler* view;
    bool operator<(const TsdfObservation& other) const;
  };

  void drop_far_side();
  double truncation_at(const ViewSampler& view, double relative_stddev) const;
  double largest_range_gap(const ViewSampler& view) const;

  const std::vector<ViewSampler>& views_;
  double truncation_, spacing_;
  std::vector<const ViewSampler*> candidates_;  // By narrow(), of all views.
  std::vector<const ViewSampler*> concerned_;   // By focus(), of these.
  std::vector<Sighting> sightings_;  // Of the point, by views that it is not behind the surface of.
  std::vector<TsdfObservation> near_, empty_;
};

}  // namespace relief::fusion
