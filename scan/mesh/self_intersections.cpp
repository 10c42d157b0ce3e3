#include <algorithm>
#include <utility>

#include "relief/scan/mesh_check.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"
#include "scan/mesh/triangle_overlap.h"
#include "scan/mesh/triangle_tree.h"

namespace relief {

namespace {

using FacePair = std::array<std::uint32_t, 2>;

constexpr std::size_t kGrain = 1024;  // Faces of one range.
// After so many ranges the search looks whether it has enough: a fixed number, so that the pairs
// found do not depend on the threads.
constexpr std::size_t kRangesAtOnce = 64;

Triangle triangle(const TriangleMesh& mesh, std::size_t face) {
  return {mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2)};
}

bool takes_part(const TriangleMesh& mesh, std::size_t face) {
  for (const std::uint32_t vertex : mesh.faces[face])
    if (vertex >= mesh.vertices.size() || !mesh.vertices[vertex].allFinite()) return false;
  return !collinear(triangle(mesh, face));
}

// The mesh without the faces that cannot be judged, and which ones its faces were. Refers to the
// mesh itself when all can.
class Judged {
 public:
  explicit Judged(const TriangleMesh& all) {
    const auto count = parallel_sum<std::size_t>(
        all.faces.size(), kGrain, 0, [&](std::size_t begin, std::size_t end) {
          std::size_t part = 0;
          for (std::size_t face = begin; face < end; ++face) part += takes_part(all, face);
          return part;
        });
    if (count == all.faces.size()) {
      mesh_ = &all;
      return;
    }
    part_.vertices = paged_copy(all.vertices);
    part_.faces.reserve(count);
    original_.reserve(count);
    serial_for(all.faces.size(), [&](std::size_t face) {
      if (!takes_part(all, face)) return;
      part_.faces.push_back(all.faces[face]);
      original_.push_back(static_cast<std::uint32_t>(face));
    });
    mesh_ = &part_;
  }
  Judged(const Judged&) = delete;
  Judged& operator=(const Judged&) = delete;

  const TriangleMesh& mesh() const { return *mesh_; }
  FacePair original_pair(std::uint32_t f, std::uint32_t g) const {
    if (!original_.empty()) f = original_[f], g = original_[g];
    return {std::min(f, g), std::max(f, g)};
  }

 private:
  const TriangleMesh* mesh_;
  TriangleMesh part_;
  PagedVector<std::uint32_t> original_;  // Empty: the same.
};

std::vector<FacePair> pairs_in_range(const Judged& judged, const TriangleTree& tree,
                                     std::size_t begin, std::size_t end, std::size_t limit) {
  std::vector<FacePair> pairs;
  tree.visit_box_overlaps(begin, end, [&](std::uint32_t f, std::uint32_t g) {
    if (overlap(triangle(judged.mesh(), f), triangle(judged.mesh(), g)))
      pairs.push_back(judged.original_pair(f, g));
    return pairs.size() <= limit;
  });
  return pairs;
}

}  // namespace

std::vector<std::uint32_t> SelfIntersections::faces() const {
  std::vector<std::uint32_t> all;
  for (const auto& pair : pairs) all.insert(all.end(), pair.begin(), pair.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

SelfIntersections find_self_intersections(const TriangleMesh& mesh,
                                          const SelfIntersectionOptions& options) {
  const Judged judged(mesh);
  const TriangleTree tree(judged.mesh());
  const std::size_t count = judged.mesh().faces.size();
  SelfIntersections found;
  for (std::size_t start = 0; start < count && found.pairs.size() <= options.limit;
       start += kRangesAtOnce * kGrain) {
    const std::size_t length = std::min(count - start, kRangesAtOnce * kGrain);
    std::vector<std::vector<FacePair>> ranges(kRangesAtOnce);
    parallel_for(length, kGrain, [&](std::size_t begin, std::size_t end) {
      ranges[begin / kGrain] =
          pairs_in_range(judged, tree, start + begin, start + end, options.limit);
    });
    for (const auto& pairs : ranges)
      found.pairs.insert(found.pairs.end(), pairs.begin(), pairs.end());
  }
  found.complete = found.pairs.size() <= options.limit;
  if (!found.complete) found.pairs.resize(options.limit);
  std::sort(found.pairs.begin(), found.pairs.end());
  return found;
}

}  // namespace relief
