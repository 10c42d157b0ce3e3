#include "scan/mesh/moved_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "relief/scan/mesh_check.h"
#include "scan/base/cell_key.h"
#include "scan/base/counter_random.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/parallel.h"

namespace relief {

namespace {

// Thinner faces, against their longest side, may turn over in files of single precision: 2^-24 of
// the coordinates is as much for sides of 1/170 of them.
constexpr double kLeastThickness = 1e-5;

// Of more than this part of all faces (its inverse) it takes less time to search the whole mesh.
constexpr std::size_t kMany = 20;

// A box smaller than a cell meets so many at most.
constexpr double kCellsOfBox = 8.0;

// Cells of a coarse lattice that boxes meet. sort() comes between add() and meet().
class Cells {
 public:
  Cells(const Eigen::Vector3d& origin, double size) : origin_(origin), size_(size) {}

  /// How many cells a box meets.
  double count(const Eigen::AlignedBox3d& box) const {
    return (cell(box.max()) - cell(box.min()) + 1).cast<double>().prod();
  }
  void add(const Eigen::AlignedBox3d& box) {
    visit(box, [&](std::uint64_t cell) {
      slots_[slot_of(cell)] = true;
      cells_.push_back(cell);
      return false;
    });
  }
  void sort() {
    std::sort(cells_.begin(), cells_.end());
    cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
  }
  bool meet(const Eigen::AlignedBox3d& box) const {
    return visit(box, [&](std::uint64_t cell) {
      return slots_[slot_of(cell)] && std::binary_search(cells_.begin(), cells_.end(), cell);
    });
  }

 private:
  Eigen::Array<std::int64_t, 3, 1> cell(const Eigen::Vector3d& p) const {
    return ((p - origin_) / size_).array().floor().cast<std::int64_t>();
  }

  // Until `visit` returns true.
  template <typename Visit>
  bool visit(const Eigen::AlignedBox3d& box, const Visit& visit) const {
    const auto low = cell(box.min()), high = cell(box.max());
    for (std::int64_t z = low.z(); z <= high.z(); ++z)
      for (std::int64_t y = low.y(); y <= high.y(); ++y)
        for (std::int64_t x = low.x(); x <= high.x(); ++x)
          if (visit(cell_key(x, y, z))) return true;
    return false;
  }

  static std::size_t slot_of(std::uint64_t cell) { return CounterRandom::scrambled(cell) % kSlots; }

  // Few cells share a slot, so most lookups end here. Changes no result.
  static constexpr std::size_t kSlots = 1 << 22;

  Eigen::Vector3d origin_;
  double size_;
  std::vector<bool> slots_ = std::vector<bool>(kSlots, false);
  PagedVector<std::uint64_t> cells_;  // By sort() sorted, each once.
};

class MovedFaces {
 public:
  MovedFaces(const TriangleMesh& mesh, const PagedVector<Eigen::Vector3d>& places,
             PagedVector<std::uint32_t> moved, double reach)
      : mesh_(mesh),
        places_(places),
        faces_(std::move(moved)),
        moved_(faces_.size()),
        cells_(cells_of_moved(reach)) {
    constexpr std::size_t kGrain = 4096;  // Faces of one piece of work; changes no result.
    enum Kind : std::uint8_t { kFar, kNear, kMoved };
    PagedArray<std::uint8_t> kinds(mesh.faces.size());
    serial_for(moved_, [&](std::size_t k) {
      cells_.add(box_of(faces_[k]));
      kinds[faces_[k]] = kMoved;
    });
    cells_.sort();
    parallel_for(mesh.faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f)
        if (kinds[f] == kFar && cells_.meet(box_of(static_cast<std::uint32_t>(f))))
          kinds[f] = kNear;
    });
    serial_for(mesh.faces.size(), [&](std::size_t f) {
      if (kinds[f] == kNear) faces_.push_back(static_cast<std::uint32_t>(f));
    });
  }

  std::vector<std::uint32_t> intersecting() const {
    SelfIntersectionOptions options;
    std::vector<std::uint32_t> found = find_self_intersections(part(), options).faces();
    for (std::uint32_t& f : found) f = faces_[f];
    return found;
  }

  std::vector<std::uint32_t> thin() const {
    std::vector<std::uint32_t> found;
    for (std::size_t k = 0; k < moved_; ++k)
      if (thickness(faces_[k], places_) <
          std::min(kLeastThickness, thickness(faces_[k], mesh_.vertices)))
        found.push_back(faces_[k]);
    return found;
  }

 private:
  // Of twice the size, and so on, where faces have been stretched so far that they meet more cells
  // than the mesh has faces.
  Cells cells_of_moved(double size) const {
    for (;; size *= 2.0) {
      const Cells cells(places_.front(), size);
      double count = 0.0;
      for (const std::uint32_t f : faces_) count += cells.count(box_of(f));
      const double least = kCellsOfBox * static_cast<double>(faces_.size());
      if (count <= std::max(least, static_cast<double>(mesh_.faces.size()))) return cells;
    }
  }

  Eigen::AlignedBox3d box_of(std::uint32_t face) const {
    Eigen::AlignedBox3d box;
    for (const std::uint32_t v : mesh_.faces[face]) box.extend(places_[v]);
    return box;
  }

  // Against the longest side.
  double thickness(std::uint32_t face, const PagedVector<Eigen::Vector3d>& at) const {
    const auto& [a, b, c] = mesh_.faces[face];
    const Eigen::Vector3d u = at[b] - at[a], v = at[c] - at[a], w = at[c] - at[b];
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), w.squaredNorm()});
    return longest > 0.0 ? u.cross(v).norm() / longest : 0.0;
  }

  // These faces alone, in their order.
  TriangleMesh part() const {
    TriangleMesh part;
    PagedArray<std::uint32_t> numbers(mesh_.vertices.size());  // From 1; 0: not among them yet.
    serial_for(faces_.size(), [&](std::size_t i) {
      TriangleMesh::Face& face = part.faces.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh_.faces[faces_[i]][k];
        if (numbers[v] == 0) {
          part.vertices.push_back(places_[v]);
          numbers[v] = static_cast<std::uint32_t>(part.vertices.size());
        }
        face[k] = numbers[v] - 1;
      }
    });
    return part;
  }

  const TriangleMesh& mesh_;
  const PagedVector<Eigen::Vector3d>& places_;
  PagedVector<std::uint32_t> faces_;  // The moved ones, then those near.
  std::size_t moved_;
  Cells cells_;
};

}  // namespace

PagedVector<std::uint32_t> faces_at(const TriangleMesh& mesh,
                                    std::span<const std::uint8_t> marked) {
  PagedVector<std::uint32_t> faces;
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    if (std::any_of(mesh.faces[f].begin(), mesh.faces[f].end(),
                    [&](std::uint32_t v) { return marked[v]; }))
      faces.push_back(static_cast<std::uint32_t>(f));
  });
  return faces;
}

std::vector<std::uint32_t> invalid_faces(const TriangleMesh& mesh,
                                         const PagedVector<Eigen::Vector3d>& places,
                                         std::span<const std::uint8_t> moved, double reach) {
  const MovedFaces faces(mesh, places, faces_at(mesh, moved), reach);
  std::vector<std::uint32_t> invalid = faces.intersecting();
  const std::vector<std::uint32_t> thin = faces.thin();
  invalid.insert(invalid.end(), thin.begin(), thin.end());
  std::sort(invalid.begin(), invalid.end());
  invalid.erase(std::unique(invalid.begin(), invalid.end()), invalid.end());
  return invalid;
}

std::vector<std::uint32_t> intersecting_faces(const TriangleMesh& mesh,
                                              PagedVector<std::uint32_t> faces, double reach) {
  if (faces.empty()) return {};
  if (faces.size() > mesh.faces.size() / kMany) {
    SelfIntersectionOptions options;
    return find_self_intersections(mesh, options).faces();
  }
  auto found = MovedFaces(mesh, mesh.vertices, std::move(faces), reach).intersecting();
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace relief
