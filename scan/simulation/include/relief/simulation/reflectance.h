#pragma once

#include <Eigen/Core>

#include "relief/scan/result.h"
#include "relief/simulation/plane_waves.h"
#include "relief/simulation/random_stream.h"

namespace relief::simulation {

/// How the object's surface reflects light. Dark and glossy patches are fixed to the object, so all
/// views and sensors agree on where they are. The default is a white diffuse surface.
struct Reflectance {
  double dark_fraction = 0.0;    ///< Part of the surface that is dark, in [0, 1).
  double dark_albedo = 0.1;      ///< Diffuse albedo inside dark patches, in (0, 1]; 1 outside.
  double glossy_fraction = 0.0;  ///< Part of the surface that has a highlight, in [0, 1).
  /// Size of the patches: shortest wavelength of the field that makes them [diameters], > 0.
  double patch_size = 0.15;
  /// Angle between the normal and the half vector at which a highlight has fallen to 1/e [degrees],
  /// in (0, 90).
  double highlight_width_deg = 5.0;
  double highlight_strength = 2.0;  ///< Its light, that of a white diffuse surface being 1, >= 0.
};

/// A surface of which a tenth is dark and a tenth glossy.
Reflectance patchy_surface();

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
