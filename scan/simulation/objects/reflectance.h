#pragma once

#include <Eigen/Core>

#include "relief/scan/result.h"
#include "relief/simulation/simulation_object.h"
#include "scan/simulation/base/plane_waves.h"
#include "scan/simulation/base/random_stream.h"

namespace relief::simulation {

/// kBadInput names a field out of its range.
Result<void> validate(const Reflectance& reflectance);

/// The optical properties of one point.
struct SurfacePaint {
  double albedo = 1.0;  ///< Of the diffuse reflection.
  double gloss = 0.0;   ///< In [0, 1]: how much of the highlight there is.
};

/// The surface's reflectance as a function of place.
class PaintedSurface {
 public:
  /// `diameter` [unit] is that of the object.
  PaintedSurface(const Reflectance& reflectance, double diameter, const RandomStream& dark_random,
                 const RandomStream& gloss_random);

  SurfacePaint at(const Eigen::Vector3d& point_in_world) const;

  /// The light that a surface sends to the viewer for light of strength 1: equation (S10). The
  /// directions are unit vectors away from the surface.
  double reflected(const SurfacePaint& paint, const Eigen::Vector3d& normal,
                   const Eigen::Vector3d& to_light, const Eigen::Vector3d& to_viewer) const;

 private:
  Reflectance reflectance_;
  double highlight_width_ = 0.0;  // [rad]
  double dark_level_ = 0.0, gloss_level_ = 0.0;
  PlaneWaves dark_field_, gloss_field_;
};

}  // namespace relief::simulation
