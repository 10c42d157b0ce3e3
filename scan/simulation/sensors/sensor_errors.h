#pragma once

#include "relief/scan/range_view.h"
#include "scan/simulation/base/random_stream.h"

namespace relief::simulation {

/// A measured normal as a unit vector that faces the sensor: one that an error turned away from it
/// is put back to just facing it. `ray_direction` is that of the pixel, `normal` not zero.
Eigen::Vector3f facing_sensor(Eigen::Vector3d normal, const Eigen::Vector3d& ray_direction);

/// Adds white Gaussian noise to the range: `sigma` [unit] is its standard deviation along the ray
/// in the left half of the image, `right_half` times that in the right half.
void add_range_noise(RangeView& view, double sigma, const RandomStream& random,
                     double right_half = 1.0);

/// Turns each normal by independent Gaussian angles of standard deviation `sigma_rad` about two
/// perpendicular axes of its tangent plane, so the angle between the old and the new normal has the
/// mean 1.25 sigma and the RMS 1.41 sigma.
void add_normal_noise(RangeView& view, double sigma_rad, const RandomStream& random);

/// Turns the normals by a smooth random field of rotations: the low-frequency error of photometric
/// stereo. Neighbouring normals turn together, so fine relief is tilted as a whole but keeps its
/// shape. `rms_rad` is the RMS, over the view's normals, of the angle they turn by. The field is a
/// sum of 16 plane waves in space with lengths between `wavelength` [unit] and twice that.
void add_normal_bias(RangeView& view, double rms_rad, double wavelength,
                     const RandomStream& random);

/// A motion of exactly the given size: a rotation by `angle_rad` about a random axis through
/// `centre`, then a translation by `distance` [unit] in a random direction.
RigidMotion random_motion(double angle_rad, double distance, const Eigen::Vector3d& centre,
                          const RandomStream& random);

}  // namespace relief::simulation
