#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "fusion/tsdf/sparse_field.h"
#include "relief/scan/range_view.h"
#include "relief/scan/triangle_mesh.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::testing {

/// A signed distance (or a lower bound of it), negative inside.
using SignedDistance = std::function<double(const Eigen::Vector3d&)>;

SignedDistance sphere_distance(double radius);
/// Round the z axis.
SignedDistance torus_distance(double major_radius, double minor_radius);
SignedDistance box_distance(const Eigen::Vector3d& half_sizes);

/// The surface found by marching along the ray in steps of the distance.
Surface traced(SignedDistance distance);

/// `count` directions spread evenly over the sphere (a Fibonacci lattice).
std::vector<Eigen::Vector3d> even_directions(int count);

/// Pinhole views from `count` even directions, `size` pixels square, of a sphere of `radius` round
/// the origin that fills the image.
std::vector<RangeView> views_around(const Surface& surface, int count, int size, double radius);

/// What merging makes of views of a torus round the z axis, radii 35 and 12: closed, genus 1.
const TriangleMesh& torus_mesh();

/// Twelve views of a sphere from four radii away and eight from eight, of the same footprint of a
/// pixel there. The noise of ranges, standard deviation `noise` from the nearer places [unit],
/// grows with the distance to the power of `exponent`.
std::vector<RangeView> near_and_far_views(double radius, double noise, double exponent);

/// Random small scenes: views of simple shapes, some of them dropped, some twice, with noise of
/// range and normals, wrong poses, masked rectangles and rectangles measured too near.
class RandomScenes {
 public:
  RandomScenes();
  std::vector<RangeView> scene(std::uint32_t seed) const;

 private:
  std::vector<std::vector<RangeView>> pool_;  // Exact views of each shape.
};

/// The keys of `side`^3 blocks from (0, 0, 0) on, sorted.
std::vector<fusion::NodeKey> cube_of_blocks(int side);

/// `function` at the nodes inside the cube of blocks, 1 on its border and outside. Nodes are 0.5
/// apart.
fusion::SparseField field_of(int side, const std::function<double(const fusion::Node&)>& function);

}  // namespace relief::testing
