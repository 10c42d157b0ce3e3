#include "fusion/mesh/remove_handles.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "fusion/mesh/cube_patches.h"
#include "fusion/mesh/handle_loops.h"
#include "scan/base/parallel.h"
#include "scan/mesh/moved_faces.h"
#include "scan/mesh/vertex_arrays.h"

namespace relief::fusion {

namespace {

// Times that the mesh is cut into cubes, every other time half a cube farther: each time one loop
// of a patch is cut. Bounds the time.
constexpr int kPasses = 4;
// Times that cuts are made anew without those where the surface intersects itself.
constexpr int kAttempts = 4;
// Of the membranes: so that either side leaves the cut, and does not shrink to a needle.
constexpr int kSmoothings = 5;

constexpr std::size_t kPatchesAtOnce = 8;  // Changes no result.
// Twice the area of a face of a membrane at least [voxels^2]: a thirtieth of a voxel across, which
// files of single precision keep.
constexpr double kLeastArea = 1e-3;

// A loop in a patch.
struct Cut {
  std::vector<std::uint32_t> loop;
  std::size_t patch;
};

std::uint32_t copy_of(std::uint32_t v, TriangleMesh& mesh) {
  visit_vertex_arrays(mesh, [v](auto& array) {
    if (!array.empty()) array.push_back(array[v]);
  });
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

Eigen::Vector3d centre_of(const std::vector<std::uint32_t>& loop, const TriangleMesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::uint32_t v : loop) sum += mesh.vertices[v];
  return sum / static_cast<double>(loop.size());
}

// What closes one side of a loop.
struct Membrane {
  std::vector<std::uint32_t> free;   // The vertices of the loop, and the one in the middle.
  std::vector<std::uint32_t> faces;  // With any of these.
};

// Cuts the mesh along one loop inside of a patch.
class LoopCut {
 public:
  LoopCut(const Cut& cut, const std::vector<std::uint32_t>& patch_faces, TriangleMesh& mesh)
      : loop_(cut.loop), mesh_(mesh) {
    const std::unordered_set<std::uint32_t> on_loop(loop_.begin(), loop_.end());
    for (const std::uint32_t f : patch_faces)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& face = mesh.faces[f];
        if (on_loop.contains(face[k])) face_at_[key(face[k], face[(k + 1) % 3])] = f;
      }
  }

  std::array<Membrane, 2> make() {
    const auto left = left_faces();
    std::vector<std::uint32_t> copies(loop_.size());
    for (std::size_t i = 0; i < loop_.size(); ++i) {
      copies[i] = copy_of(loop_[i], mesh_);
      for (const std::uint32_t f : left[i])
        std::ranges::replace(mesh_.faces[f], loop_[i], copies[i]);
    }
    std::vector<std::uint32_t> beside;
    for (const auto& [edge, f] : face_at_) beside.push_back(f);
    std::ranges::sort(beside);
    beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
    const std::vector<std::uint32_t> backwards(copies.rbegin(), copies.rend());
    return {close(loop_, beside), close(backwards, beside)};
  }

 private:
  static std::uint64_t key(std::uint32_t from, std::uint32_t to) {
    return std::uint64_t{from} << 32 | to;
  }

  // The faces at each vertex of the loop that lie to its left, counter-clockwise.
  std::vector<std::vector<std::uint32_t>> left_faces() const {
    std::vector<std::vector<std::uint32_t>> left(loop_.size());
    for (std::size_t i = 0; i < loop_.size(); ++i) {
      const std::uint32_t v = loop_[i], before = loop_[(i + loop_.size() - 1) % loop_.size()];
      for (std::uint32_t to = loop_[(i + 1) % loop_.size()]; to != before;) {
        const std::uint32_t f = face_at_.at(key(v, to));
        left[i].push_back(f);
        const auto& face = mesh_.faces[f];
        to = face[0] == v ? face[2] : face[1] == v ? face[0] : face[1];
      }
    }
    return left;
  }

  // A fan of faces to the left of `rim`, and what is beside it.
  Membrane close(const std::vector<std::uint32_t>& rim, const std::vector<std::uint32_t>& beside) {
    Membrane membrane{rim, {}};
    for (const std::uint32_t f : beside)
      if (std::ranges::any_of(mesh_.faces[f], [&](std::uint32_t v) {
            return std::ranges::find(rim, v) != rim.end();
          }))
        membrane.faces.push_back(f);
    const std::uint32_t centre = copy_of(rim.front(), mesh_);
    mesh_.vertices[centre] = centre_of(rim, mesh_);
    for (std::size_t i = 0; i < rim.size(); ++i) {
      membrane.faces.push_back(static_cast<std::uint32_t>(mesh_.faces.size()));
      mesh_.faces.push_back({rim[i], rim[(i + 1) % rim.size()], centre});
    }
    membrane.free.push_back(centre);
    return membrane;
  }

  const std::vector<std::uint32_t>& loop_;
  TriangleMesh& mesh_;
  std::unordered_map<std::uint64_t, std::uint32_t> face_at_;  // By half-edges from the loop.
};

// Moves each free vertex to the mean of its neighbours, over and over: what is left of the handle
// shrinks away from the cut, to the faces that do not move.
void smooth(const Membrane& membrane, TriangleMesh& mesh) {
  for (int i = 0; i < kSmoothings; ++i)
    for (const std::uint32_t v : membrane.free) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double count = 0.0;
      for (const std::uint32_t f : membrane.faces) {
        const auto& face = mesh.faces[f];
        if (std::ranges::find(face, v) == face.end()) continue;
        for (const std::uint32_t other : face)
          if (other != v) {
            sum += mesh.vertices[other];
            count += 1.0;
          }
      }
      mesh.vertices[v] = sum / count;
    }
}

using IsEmpty = std::function<bool(const Eigen::Vector3d&)>;

// Whether half of the vertices of a loop or more are filled, and no view saw space empty where a
// membrane across it would lie.
bool may_be_cut(const HandleLoop& loop, const TriangleMesh& mesh, const IsEmpty& is_empty) {
  const auto is_filled = [&](std::uint32_t v) { return mesh.filled[v] != 0; };
  if (2 * std::ranges::count_if(loop.vertices, is_filled) < std::ssize(loop.vertices)) return false;
  const Eigen::Vector3d centre = centre_of(loop.vertices, mesh);
  return !is_empty(centre) && std::ranges::none_of(loop.vertices, [&](std::uint32_t v) {
    return is_empty(0.5 * (centre + mesh.vertices[v]));
  });
}

class HandleRemoval {
 public:
  HandleRemoval(TriangleMesh& mesh, const HandleRemovalOptions& options)
      : mesh_(mesh), options_(options) {}

  // One pass over the mesh; returns how many handles it removed.
  std::size_t pass(double shift) {
    patches_ = CubePatches(mesh_, options_.side, shift).faces_with_handles();
    std::vector<Cut> cuts = find_cuts();
    if (cuts.empty()) return 0;
    const TriangleMesh as_given = mesh_;
    for (int attempt = 0; attempt < kAttempts && !cuts.empty(); ++attempt) {
      const std::vector<bool> bad = make(cuts);
      if (std::ranges::find(bad, true) == bad.end()) return cuts.size();
      mesh_ = as_given;
      std::size_t i = 0;
      std::erase_if(cuts, [&](const Cut&) { return bad[i++]; });
    }
    return 0;
  }

 private:
  // Of each patch the shortest loop that may be cut.
  std::vector<Cut> find_cuts() const {
    std::vector<std::optional<HandleLoop>> loops(patches_.size());
    parallel_for(patches_.size(), kPatchesAtOnce, [&](std::size_t begin, std::size_t end) {
      const IsEmpty is_empty = options_.emptiness();
      for (std::size_t p = begin; p < end; ++p)
        loops[p] = short_handle_loop(mesh_, patches_[p], mesh_.filled, [&](const HandleLoop& loop) {
          return may_be_cut(loop, mesh_, is_empty);
        });
    });
    std::vector<Cut> cuts;
    for (std::size_t p = 0; p < loops.size(); ++p)
      if (loops[p]) cuts.push_back({std::move(loops[p]->vertices), p});
    return cuts;
  }

  // Makes all cuts. Returns at which of them the surface intersects itself.
  std::vector<bool> make(const std::vector<Cut>& cuts) {
    std::unordered_map<std::uint32_t, std::size_t> cut_of;  // By face.
    PagedVector<std::uint32_t> changed;
    serial_for(cuts.size(), [&](std::size_t c) {
      for (const Membrane& side : LoopCut(cuts[c], patches_[cuts[c].patch], mesh_).make()) {
        smooth(side, mesh_);
        for (const std::uint32_t f : side.faces) {
          cut_of[f] = c;
          changed.push_back(f);
        }
      }
    });
    std::ranges::sort(changed);
    std::vector<bool> bad(cuts.size());
    for (const auto& [f, c] : cut_of)
      if (!(face_cross(mesh_, f).norm() > kLeastArea * options_.voxel_size * options_.voxel_size))
        bad[c] = true;
    for (const std::uint32_t f :
         intersecting_faces(mesh_, std::move(changed), 2.0 * options_.voxel_size))
      if (const auto found = cut_of.find(f); found != cut_of.end()) bad[found->second] = true;
    return bad;
  }

  TriangleMesh& mesh_;
  const HandleRemovalOptions& options_;
  std::vector<std::vector<std::uint32_t>> patches_;  // Their faces.
};

}  // namespace

std::size_t remove_unmeasured_handles(TriangleMesh& mesh, const HandleRemovalOptions& options) {
  std::size_t removed = 0;
  int idle = 0;
  for (int pass = 0; pass < kPasses && idle < 2; ++pass) {
    const std::size_t now = HandleRemoval(mesh, options).pass(pass % 2 == 0 ? 0.0 : 0.5);
    idle = now == 0 ? idle + 1 : 0;
    removed += now;
  }
  return removed;
}

}  // namespace relief::fusion
