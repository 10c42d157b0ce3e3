#include "scan/mesh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "scan/base/parallel.h"

namespace relief {

namespace {

constexpr std::uint32_t kLeafSize = 4;  // [faces]; bounds the time.

constexpr std::ptrdiff_t kFacesAtOnce = 4096;  // Of one piece of work.
// Of the faces, which are sorted side by side.
constexpr std::size_t kParts = 16;

// Halving at the median bounds the depth by the bits of the face index.
constexpr std::size_t kStackSize = 64;

// As std::nth_element() does, of different values. Looks at the memory while many are left.
template <typename Less>
void select(std::uint32_t* begin, std::uint32_t* nth, std::uint32_t* end, const Less& less) {
  while (end - begin > kFacesAtOnce) {
    // Splits at a value of the middle of a sample: the smaller ones come first.
    constexpr std::ptrdiff_t kSample = 63;
    std::array<std::uint32_t, kSample> sample;
    for (std::ptrdiff_t i = 0; i < kSample; ++i) sample[i] = begin[i * (end - begin) / kSample];
    std::nth_element(sample.begin(), sample.begin() + kSample / 2, sample.end(), less);
    const std::uint32_t pivot = sample[kSample / 2];
    std::uint32_t* split = begin;
    serial_for(end - begin, [&, first = begin](std::size_t i) {
      if (less(first[i], pivot)) std::swap(first[i], *split++);
    });
    (nth < split ? end : begin) = split;
  }
  std::nth_element(begin, nth, end, less);
}

// The nodes of a tree over so many faces. Halves of one level differ by one face at most.
std::uint32_t node_count(std::uint32_t faces) {
  std::uint32_t size = faces, smaller = 1, larger = 0, nodes = 0;  // Halves of `size`, of one more.
  while (smaller + larger > 0) {
    nodes += smaller + larger;
    const std::uint32_t split_smaller = size > kLeafSize ? smaller : 0;
    const std::uint32_t split_larger = size + 1 > kLeafSize ? larger : 0;
    // n halves into n / 2 and the rest.
    const bool odd = size % 2 == 1;
    smaller = odd ? split_smaller : 2 * split_smaller + split_larger;
    larger = odd ? split_smaller + 2 * split_larger : split_larger;
    size /= 2;
  }
  return nodes;
}

// The edge function of Woop, Benthin and Wald 2013: computed in an order that does not depend on
// the face, so that the two faces of an edge agree on the side of the ray.
double edge_side(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  return p.x() * q.y() - p.y() * q.x();
}

// A ray with the axis of its largest component mapped to z and sheared to (0, 0, 1).
struct ShearedRay {
  Eigen::Vector3d origin, inverse;
  int kx, ky, kz;
  double shear_x, shear_y, scale;

  explicit ShearedRay(const Ray& ray) : origin(ray.origin), inverse(ray.direction.cwiseInverse()) {
    ray.direction.cwiseAbs().maxCoeff(&kz);
    kx = (kz + 1) % 3;
    ky = (kz + 2) % 3;
    scale = 1.0 / ray.direction[kz];
    shear_x = ray.direction[kx] * scale;
    shear_y = ray.direction[ky] * scale;
  }

  Eigen::Vector2d across(const Eigen::Vector3d& p) const {
    return {p[kx] - shear_x * p[kz], p[ky] - shear_y * p[kz]};
  }

  // The range at which the ray enters the box; infinite when it does not before `limit`.
  double entry(const Eigen::AlignedBox3d& box, double limit) const {
    double near = 0.0, far = limit;
    for (int k = 0; k < 3; ++k) {
      const bool forwards = inverse[k] > 0.0;
      const double t0 = ((forwards ? box.min() : box.max())[k] - origin[k]) * inverse[k];
      const double t1 = ((forwards ? box.max() : box.min())[k] - origin[k]) * inverse[k];
      // 0 * infinity, a ray within a face of the box, compares false and restricts nothing.
      if (t0 > near) near = t0;
      if (t1 * (1.0 + 1e-14) < far) far = t1 * (1.0 + 1e-14);
    }
    return near <= far ? near : std::numeric_limits<double>::infinity();
  }
};

std::optional<TriangleTree::Hit> hit_face(const ShearedRay& ray, const TriangleMesh& mesh,
                                          std::uint32_t face) {
  std::array<Eigen::Vector3d, 3> corner;
  std::array<Eigen::Vector2d, 3> flat;
  for (int k = 0; k < 3; ++k) {
    corner[k] = mesh.corner(face, k) - ray.origin;
    flat[k] = ray.across(corner[k]);
  }
  const Eigen::Vector3d sides(edge_side(flat[1], flat[2]), edge_side(flat[2], flat[0]),
                              edge_side(flat[0], flat[1]));
  if (sides.minCoeff() < 0.0 && sides.maxCoeff() > 0.0) return std::nullopt;
  const double sum = sides.sum();
  if (sum == 0.0) return std::nullopt;  // seen edge-on
  TriangleTree::Hit hit;
  hit.face = face;
  hit.weights = sides / sum;
  hit.range = ray.scale * (hit.weights[0] * corner[0][ray.kz] + hit.weights[1] * corner[1][ray.kz] +
                           hit.weights[2] * corner[2][ray.kz]);
  if (!(hit.range > 0.0)) return std::nullopt;
  return hit;
}

}  // namespace

// By Voronoi regions (Ericson, Real-Time Collision Detection, 2005, section 5.1.5). Edges without
// length have no region.
TrianglePoint closest_on_triangle(const Eigen::Vector3d& query, const Eigen::Vector3d& a,
                                  const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const auto at = [&](double wa, double wb, double wc) -> TrianglePoint {
    return {wa * a + wb * b + wc * c, {wa, wb, wc}};
  };
  const Eigen::Vector3d ab = b - a, ac = c - a, aq = query - a;
  const double d1 = ab.dot(aq), d2 = ac.dot(aq);
  if (d1 <= 0.0 && d2 <= 0.0) return at(1, 0, 0);
  const Eigen::Vector3d bq = query - b;
  const double d3 = ab.dot(bq), d4 = ac.dot(bq);
  if (d3 >= 0.0 && d4 <= d3) return at(0, 1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3) {
    const double s = d1 / (d1 - d3);
    return at(1 - s, s, 0);
  }
  const Eigen::Vector3d cq = query - c;
  const double d5 = ab.dot(cq), d6 = ac.dot(cq);
  if (d6 >= 0.0 && d5 <= d6) return at(0, 0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6) {
    const double s = d2 / (d2 - d6);
    return at(1 - s, 0, s);
  }
  const double va = d3 * d6 - d5 * d4, bc = (d4 - d3) + (d5 - d6);
  if (va <= 0.0 && d4 >= d3 && d5 >= d6 && bc > 0.0) {
    const double s = (d4 - d3) / bc;
    return at(0, 1 - s, s);
  }
  const double total = va + vb + vc;
  if (!(total > 0.0)) return at(1, 0, 0);  // no area, to rounding
  return at(va / total, vb / total, vc / total);
}

struct TriangleTree::Part {
  std::uint32_t begin = 0, end = 0;
  std::uint32_t node = 0;

  std::uint32_t size() const { return end - begin; }
};

// The upper levels are built one part after the other, the parts below side by side.
TriangleTree::TriangleTree(const TriangleMesh& mesh) : mesh_(&mesh), faces_(mesh.faces.size()) {
  if (faces_.size() == 0) return;
  Centres centres(faces_.size());
  parallel_for(centres.size(), kFacesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      faces_[f] = static_cast<std::uint32_t>(f);
      centres[f] = (mesh.corner(f, 0) + mesh.corner(f, 1) + mesh.corner(f, 2)) / 3.0;
    }
  });
  nodes_ = PagedArray<Node>(node_count(static_cast<std::uint32_t>(faces_.size())));

  std::vector<Part> upper, parts{{0, static_cast<std::uint32_t>(faces_.size()), 0}};
  while (parts.size() < kParts && parts.front().size() > kFacesAtOnce) {
    std::vector<Part> halves;
    for (const Part& part : parts) {
      upper.push_back(part);
      for (const Part& half : halve(part, centres)) halves.push_back(half);
    }
    parts = std::move(halves);
  }
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) build(parts[k], centres);
  });
  for (auto part = upper.rbegin(); part != upper.rend(); ++part) {
    Node& node = nodes_[part->node];
    node.set_box(nodes_[part->node + 1].box().merged(nodes_[node.right].box()));
  }
}

Eigen::AlignedBox3d TriangleTree::face_box(std::uint32_t face) const {
  Eigen::AlignedBox3d box;
  for (int k = 0; k < 3; ++k) box.extend(mesh_->corner(face, k));
  return box;
}

Eigen::AlignedBox3d TriangleTree::build(const Part& part, const Centres& centres) {
  Eigen::AlignedBox3d box;
  if (part.size() > kLeafSize) {
    for (const Part& half : halve(part, centres)) box.extend(build(half, centres));
  } else {
    std::sort(faces_.begin() + part.begin, faces_.begin() + part.end);
    for (std::uint32_t i = part.begin; i < part.end; ++i) box.extend(face_box(faces_[i]));
    nodes_[part.node].begin = part.begin;
    nodes_[part.node].count = part.size();
    nodes_[part.node].end = part.end;
  }
  nodes_[part.node].set_box(box);
  return box;
}

// Halves at the median along the longest side, and links the node to those of both halves.
std::array<TriangleTree::Part, 2> TriangleTree::halve(const Part& part, const Centres& centres) {
  Eigen::AlignedBox3d box;
  serial_for(part.size(), [&](std::size_t i) { box.extend(centres[faces_[part.begin + i]]); });
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::uint32_t middle = part.begin + part.size() / 2;
  // Ties are broken by index, so that the tree is a function of the mesh alone.
  select(faces_.begin() + part.begin, faces_.begin() + middle, faces_.begin() + part.end,
         [&](std::uint32_t a, std::uint32_t b) {
           return std::pair(centres[a][axis], a) < std::pair(centres[b][axis], b);
         });
  const std::uint32_t left = part.node + 1, right = left + node_count(part.size() / 2);
  nodes_[part.node].end = part.end;
  nodes_[part.node].right = right;
  return {{{part.begin, middle, left}, {middle, part.end, right}}};
}

std::optional<TriangleTree::Closest> TriangleTree::closest(const Eigen::Vector3d& query,
                                                           double max_distance) const {
  if (nodes_.size() == 0) return std::nullopt;
  Closest best;
  double best_squared = max_distance * max_distance;
  bool found = false;
  std::array<std::pair<std::uint32_t, double>, kStackSize> stack;
  std::size_t depth = 0;
  stack[depth++] = {0u, nodes_[0].box().squaredExteriorDistance(query)};
  while (depth > 0) {
    const auto [index, box_squared] = stack[--depth];
    if (box_squared > best_squared) continue;
    const Node& node = nodes_[index];
    for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) {
      const std::uint32_t face = faces_[i];
      const TrianglePoint candidate = closest_on_triangle(
          query, mesh_->corner(face, 0), mesh_->corner(face, 1), mesh_->corner(face, 2));
      const double squared = (candidate.point - query).squaredNorm();
      if (!(squared < best_squared || (!found && squared == best_squared))) continue;
      best_squared = squared;
      best.face = face;
      best.on_face = candidate;
      found = true;
    }
    if (node.count > 0) continue;
    std::pair near{index + 1, nodes_[index + 1].box().squaredExteriorDistance(query)};
    std::pair far{node.right, nodes_[node.right].box().squaredExteriorDistance(query)};
    if (far.second < near.second) std::swap(near, far);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  if (!found) return std::nullopt;
  best.distance = std::sqrt(best_squared);
  return best;
}

std::optional<TriangleTree::Hit> TriangleTree::first_hit(const Ray& ray) const {
  if (nodes_.size() == 0) return std::nullopt;
  const ShearedRay sheared(ray);
  std::optional<Hit> best;
  double limit = std::numeric_limits<double>::infinity();
  std::array<std::pair<std::uint32_t, double>, kStackSize> stack;
  std::size_t depth = 0;
  stack[depth++] = {0u, sheared.entry(nodes_[0].box(), limit)};
  while (depth > 0) {
    const auto [index, entry] = stack[--depth];
    if (!(entry <= limit) || std::isinf(entry)) continue;
    const Node& node = nodes_[index];
    for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) {
      const auto hit = hit_face(sheared, *mesh_, faces_[i]);
      if (!hit || hit->range >= limit) continue;
      best = hit;
      limit = hit->range;
    }
    if (node.count > 0) continue;
    std::pair near{index + 1, sheared.entry(nodes_[index + 1].box(), limit)};
    std::pair far{node.right, sheared.entry(nodes_[node.right].box(), limit)};
    if (far.second < near.second) std::swap(near, far);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  return best;
}

// Faces of one leaf are near each other: the tree is searched for all of them at once.
void TriangleTree::visit_box_overlaps(
    std::size_t begin, std::size_t end,
    const std::function<bool(std::uint32_t f, std::uint32_t g)>& visit) const {
  const auto end_of_leaf_at = [&](std::size_t place) -> std::size_t {
    std::uint32_t index = 0;
    while (nodes_[index].count == 0)
      index = place < nodes_[index + 1].end ? index + 1 : nodes_[index].right;
    return nodes_[index].end;
  };
  std::array<std::uint32_t, kStackSize> stack;
  std::array<Eigen::AlignedBox3d, kLeafSize> boxes;
  for (std::size_t first = begin, last = begin; first < end; first = last) {
    last = std::min(end, end_of_leaf_at(first));
    Eigen::AlignedBox3d all;
    for (std::size_t place = first; place < last; ++place)
      all.extend(boxes[place - first] = face_box(faces_[place]));
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const std::uint32_t index = stack[--depth];
      const Node& node = nodes_[index];
      if (node.end <= first + 1 || !node.box().intersects(all)) continue;
      if (node.count == 0) {
        stack[depth++] = node.right;
        stack[depth++] = index + 1;
      }
      for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) {
        const Eigen::AlignedBox3d box = face_box(faces_[i]);
        for (std::size_t place = first; place < std::min<std::size_t>(last, i); ++place)
          if (boxes[place - first].intersects(box) && !visit(faces_[place], faces_[i])) return;
      }
    }
  }
}

}  // namespace relief
