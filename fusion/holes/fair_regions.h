#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "fusion/holes/plates/thin_plate.h"
#include "fusion/holes/scattered_samples.h"
#include "fusion/holes/side_normals.h"
#include "fusion/views/view_sampler.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief::fusion {

struct FairFillOptions {
  double truncation = 0.0;        ///< As used for the field [unit].
  double voxel_size = 0.0;        ///< As used for the field [unit].
  MemoryLimit* memory = nullptr;  ///< May be null.
  /// Regions of more vertices stay as the closed field has them.
  std::size_t most_solved = kMostPlateVertices;
  /// Regions of more vertices are not bent, which takes many plates.
  std::size_t most_bent = 150000;
  /// Only regions with FairRegion::near_samples: to fair a mesh again whose regions have been
  /// faired.
  bool near_samples_only = false;
};

/// A connected set of vertices that may move: filled ones and a margin of what was measured.
struct FairRegion {
  /// Filled vertices are where the mesh has them; the margin's places are where the views measured
  /// the surface, to which it is drawn the more the farther it is from what was filled.
  PlateVertices vertices;
  PlateVertices border;  ///< Measured vertices beside these. They stay.
  /// Measured vertices beyond the border, that tell how the surface curves as it arrives.
  std::vector<std::uint32_t> approach;
  /// Whether the surface turns on its way across it so far that one step of a plate falls short.
  bool curved = false;
  /// Sorted: the vertices of small patches that were measured inside of a hole, all of which move.
  /// The closed field's surface rises in cones to these, and how steep it is tells nothing.
  std::vector<std::uint32_t> islands;
  /// Whether most filled vertices are within some edges of islands or of scattered samples.
  bool near_samples = false;

  /// All of these: vertices, border, approach.
  std::vector<std::uint32_t> with_approach() const;
};

/// A mesh, and for each vertex how many edges it is from the nearest filled one, up to a few.
struct MeshRings {
  /// Rings of measured vertices round the filled ones that move with them. Those of the third
  /// follow what was measured from waves of 2 pi / 4 voxels on: almost to the voxel.
  static constexpr int kMargin = 3;

  const TriangleMesh& mesh;
  const FacesAround& around;  ///< The faces at the vertices near filled ones.
  const PagedArray<std::uint8_t>& rings;
};

/// The regions of a merged mesh (`filled` and `normals` set) whose shape can be improved: those
/// with filled vertices that have only filled neighbours, and with a border, but not crevices.
class FairRegions {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  FairRegions(const TriangleMesh& mesh, const std::vector<ViewSampler>& views,
              const FairFillOptions& options);

  const std::vector<FairRegion>& all() const { return regions_; }
  bool any_near_samples() const;  ///< Whether any region has near_samples.
  /// Regions of more than `most_solved` vertices, which are not among these.
  std::size_t too_large() const { return too_large_; }
  std::uint32_t region_of(std::uint32_t vertex) const { return region_of_[vertex]; }  ///< Or kNone.
  const FacesAround& around() const { return around_; }
  const SideNormals& normals() const { return normals_; }

 private:
  MeshRings rings() const { return {mesh_, around_, rings_}; }
  std::vector<FairRegion> find(const FairFillOptions& options);
  PagedArray<std::uint8_t> near_regions() const;
  bool is_crevice(const FairRegion& region) const;
  bool is_deep(const FairRegion& region) const;
  void add_border(FairRegion& region) const;
  bool is_beside_measured(std::uint32_t vertex) const;
  void add_islands(const PagedArray<std::uint32_t>& regions, FairRegion& region) const;
  bool is_near_samples(const FairRegion& region) const;
  void prepare(FairRegion& region, const std::vector<ViewSampler>& views,
               const FairFillOptions& options) const;

  const TriangleMesh& mesh_;
  PagedArray<std::uint8_t> rings_;  // Edges to the nearest filled vertex, up to a few.
  FacesAround around_;
  std::unordered_map<std::uint32_t, ScatteredSamples> scattered_;
  std::size_t too_large_ = 0;
  PagedVector<std::uint32_t> region_of_;
  std::vector<FairRegion> regions_;
  SideNormals normals_;
};

}  // namespace relief::fusion
