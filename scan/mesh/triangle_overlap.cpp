#include "scan/mesh/triangle_overlap.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include <Eigen/Geometry>

#include "scan/mesh/exact_predicates.h"

namespace relief {

namespace {

// Drops one coordinate: within a plane not parallel to that axis this keeps what lies where.
Eigen::Vector2d flattened(const Eigen::Vector3d& point, int dropped) {
  return {point[(dropped + 1) % 3], point[(dropped + 2) % 3]};
}

using FlatTriangle = std::array<Eigen::Vector2d, 3>;

FlatTriangle flattened(const Triangle& triangle, int dropped) {
  return {flattened(triangle[0], dropped), flattened(triangle[1], dropped),
          flattened(triangle[2], dropped)};
}

int winding(const FlatTriangle& t) { return side_of_line(t[0], t[1], t[2]); }

// A coordinate that can be dropped without making the triangle collinear; -1 when it is already.
int droppable_axis(const Triangle& triangle) {
  const Eigen::Vector3d normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
  int first = 0;
  normal.cwiseAbs().maxCoeff(&first);
  for (const int axis : {first, (first + 1) % 3, (first + 2) % 3})
    if (winding(flattened(triangle, axis)) != 0) return axis;
  return -1;
}

bool contains(const FlatTriangle& t, const Eigen::Vector2d& p) {
  const int turn = winding(t);
  for (int k = 0; k < 3; ++k)
    if (side_of_line(t[k], t[(k + 1) % 3], p) == -turn) return false;
  return true;
}

// Whether p, known to be on the line through a and b, is between them.
bool between(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  return (p.array() >= a.array().min(b.array())).all() &&
         (p.array() <= a.array().max(b.array())).all();
}

bool segments_meet(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p,
                   const Eigen::Vector2d& q) {
  const int p_side = side_of_line(a, b, p), q_side = side_of_line(a, b, q);
  const int a_side = side_of_line(p, q, a), b_side = side_of_line(p, q, b);
  if (p_side * q_side < 0 && a_side * b_side < 0) return true;
  return (p_side == 0 && between(a, b, p)) || (q_side == 0 && between(a, b, q)) ||
         (a_side == 0 && between(p, q, a)) || (b_side == 0 && between(p, q, b));
}

// For a segment in the plane of the triangle.
bool meets_in_plane(const Triangle& triangle, const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  const int axis = droppable_axis(triangle);
  assert(axis >= 0);
  const FlatTriangle flat = flattened(triangle, axis);
  const Eigen::Vector2d flat_p = flattened(p, axis), flat_q = flattened(q, axis);
  if (contains(flat, flat_p)) return true;
  for (int k = 0; k < 3; ++k)
    if (segments_meet(flat[k], flat[(k + 1) % 3], flat_p, flat_q)) return true;
  return false;
}

// Whether the closed segment from p to q meets the closed triangle, given the sides of its plane on
// which p and q are.
bool segment_meets(const Triangle& t, const Eigen::Vector3d& p, int p_side,
                   const Eigen::Vector3d& q, int q_side) {
  if (p_side * q_side > 0) return false;
  if (p_side == 0 && q_side == 0) return meets_in_plane(t, p, q);
  // The line crosses the plane in one point: inside when it passes all edges on one side.
  bool left = false, right = false;
  for (int k = 0; k < 3; ++k) {
    const int side = side_of_plane(p, q, t[k], t[(k + 1) % 3]);
    left |= side > 0;
    right |= side < 0;
  }
  return !(left && right);
}

std::array<int, 3> sides(const Triangle& plane, const Triangle& points) {
  std::array<int, 3> result;
  for (int k = 0; k < 3; ++k) result[k] = side_of_plane(plane[0], plane[1], plane[2], points[k]);
  return result;
}

bool any_edge_meets(const Triangle& triangle, const Triangle& other,
                    const std::array<int, 3>& side) {
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    if (segment_meets(triangle, other[k], side[k], other[next], side[next])) return true;
  }
  return false;
}

bool all_beyond(const std::array<int, 3>& side) {
  return side[0] != 0 && side[0] == side[1] && side[1] == side[2];
}

bool disjoint_corners_overlap(const Triangle& first, const Triangle& second) {
  const auto second_sides = sides(first, second);
  if (all_beyond(second_sides)) return false;
  const auto first_sides = sides(second, first);
  if (all_beyond(first_sides)) return false;
  return any_edge_meets(first, second, second_sides) || any_edge_meets(second, first, first_sides);
}

// With corner 0 in common. What else is common is convex and holds that corner: it reaches the
// opposite edge of one of the two.
bool overlap_beyond_corner(const Triangle& first, const Triangle& second) {
  const auto second_sides = sides(first, second);
  if (second_sides[1] * second_sides[2] > 0) return false;
  const auto first_sides = sides(second, first);
  if (first_sides[1] * first_sides[2] > 0) return false;
  return segment_meets(first, second[1], second_sides[1], second[2], second_sides[2]) ||
         segment_meets(second, first[1], first_sides[1], first[2], first_sides[2]);
}

// With corners 0 and 1 in common, in some order: folded onto each other, or not at all.
bool overlap_beyond_edge(const Triangle& first, const Triangle& second) {
  if (side_of_plane(first[0], first[1], first[2], second[2]) != 0) return false;
  const int axis = droppable_axis(first);
  const FlatTriangle flat = flattened(first, axis);
  return side_of_line(flat[0], flat[1], flattened(second[2], axis)) == winding(flat);
}

// Moves the corners that both triangles have to the front; returns how many these are.
int bring_common_corners_forward(Triangle& first, Triangle& second) {
  int common = 0;
  for (int i = 0; i < 3; ++i) {
    const auto match = std::find(second.begin() + common, second.end(), first[i]);
    if (match == second.end()) continue;
    std::swap(*match, second[common]);
    std::swap(first[i], first[common]);
    ++common;
  }
  return common;
}

}  // namespace

bool collinear(const Triangle& triangle) { return droppable_axis(triangle) < 0; }

bool overlap(const Triangle& first, const Triangle& second) {
  Triangle a = first, b = second;
  switch (bring_common_corners_forward(a, b)) {
    case 0:
      return disjoint_corners_overlap(a, b);
    case 1:
      return overlap_beyond_corner(a, b);
    case 2:
      return overlap_beyond_edge(a, b);
    default:
      return true;
  }
}

}  // namespace relief
