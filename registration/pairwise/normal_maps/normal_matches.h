#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/degenerate_directions.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"
#include "scan/base/memory/paged_lists.h"

namespace relief::registration {

/// The two measured normals of a correspondence, in the target's frame. Where the views are aligned
/// they agree; under a motion (w, v) of the source their difference along the columns e of `basis`
/// changes, as the source's normal turns and meets another place of the target's map, (R7):
///   r_k = e_k . N_s - g_k . d,   dr_k = (N_s x e_k - p x g_k) . w - g_k . v.
struct NormalMatch {
  Eigen::Vector3d point;              ///< p: of the target's surface.
  Eigen::Vector3d normal;             ///< N_s: the source's, turned into the target's frame.
  Eigen::Matrix<double, 3, 2> basis;  ///< e_1, e_2: tangent to the target's normal.
  /// g_1, g_2: derivatives of the normal's components along `basis` by the position, as either view
  /// has them [rad/unit]. Their noise is independent.
  Eigen::Matrix<double, 3, 2> source_gradient, target_gradient;
  Eigen::Vector2d residual;        ///< r at the pose of the search [rad].
  double weight = 1.0;             ///< Of the correspondence.
  std::size_t correspondence = 0;  ///< Its index in what was matched.

  /// The mean of both views' gradients: less noise than either.
  Eigen::Matrix<double, 3, 2> gradient() const { return 0.5 * (source_gradient + target_gradient); }
  /// The derivative of residual k by a tangent (w, v) about `centre`, with either gradient.
  Vector6d derivative(int k, const Eigen::Matrix<double, 3, 2>& gradient,
                      const Eigen::Vector3d& centre) const;
  /// The same in a frame reached by `motion`.
  NormalMatch moved(const RigidMotion& motion) const;
  /// The same for motions of the target instead of the source.
  NormalMatch reversed() const;
};

struct NormalMatches {
  std::vector<NormalMatch> items;
  double sigma = 0.0;  ///< Robust standard deviation of the residuals [rad], at least 1e-3.
  /// The deviation that independent residuals would have to have to determine a pose no better than
  /// these, whose errors neighbours share [rad]; >= sigma.
  double effective_sigma = 0.0;
  /// How many matches say the same, because they lie in the same few cells of the maps; >= 1.
  double redundancy = 1.0;
};

/// The matches of a directed pair, without their redundancy.
struct NormalMatchesSpan {
  std::span<const NormalMatch> items;
  double sigma = 0.0, effective_sigma = 0.0;  ///< As in NormalMatches.
};

/// The matches of many directed pairs. They lie in files under a memory limit.
class NormalMatchesOfPairs {
 public:
  bool empty() const { return items_.size() == 0; }
  void add(const NormalMatches& of_pair) {
    items_.add(of_pair.items);
    sigmas_.push_back({of_pair.sigma, of_pair.effective_sigma});
  }
  NormalMatchesSpan operator[](std::size_t pair) const {
    return {items_[pair], sigmas_[pair].of_residuals, sigmas_[pair].effective};
  }

 private:
  struct Sigmas {
    double of_residuals, effective;
  };
  PagedLists<NormalMatch> items_;
  std::vector<Sigmas> sigmas_;
};

/// What the normal maps of both views say at correspondences, at resolution `level`; none where
/// either has no map or a gap.
NormalMatches match_normals(const ViewSurface& source, const ViewSurface& target,
                            const RigidMotion& target_from_source,
                            const Correspondences& correspondences, int level);

/// `geometric` with the eigenvalue that the normal maps add to directions below `threshold`: what
/// both views' gradients say alike, since noise agrees on nothing. One unit of an eigenvalue is
/// `length_per_angle` [unit/rad] of residual, the ratio of both deviations, in radii of the
/// surface. Directions in which the agreement is not significant stay as they are.
ConstraintSpectrum with_normal_maps(const ConstraintSpectrum& geometric,
                                    const NormalMatches& matches, double length_per_angle,
                                    double threshold);

/// Whether a surface is so nearly degenerate that its normal maps should be aligned too: some
/// motion is held no better than by slopes of four times those that `threshold` stands for.
bool is_nearly_degenerate(const ConstraintSpectrum& geometric, double threshold);

/// Makes the matches indifferent to a motion (w, v) about `centre` that they do not determine: the
/// gradients along it become those of a surface without relief.
void ignore_motion(const RigidTangent& motion, const Eigen::Vector3d& centre,
                   NormalMatches& matches);

}  // namespace relief::registration
