#include "fusion/holes/fair_fill.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>

#include "fusion/holes/plates/thin_plate.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"
#include "scan/mesh/moved_faces.h"

namespace relief::fusion {

namespace {

// The closed field's surface is that far at most in the way of such rays. A vertex that would have
// to go farther stays.
constexpr double kFarthestRetreat = 1.5;  // [voxels]

// Rounds of finding invalid faces and holding their vertices. Bounds the time: what is left then
// stays a membrane.
constexpr int kRounds = 3;

// Stiffness at vertices that are held because their faces were invalid: the slope of the membrane
// there is no slope to continue.
constexpr double kHeld = 0.0;

// How far holding a vertex changes the plate [edges]: it moves by a voxel or two there, and not at
// all beyond. Two over 12 edges tilt it by 9 degrees; half as many would by 18.
constexpr int kChangedRings = 12;

// Regions of more vertices are solved one at a time: the factors of each take hundreds of
// megabytes, and seconds in which nobody can stop the work.
constexpr std::size_t kLargeRegion = 150000;

// How far the work on a region has come.
struct Settling {
  std::map<std::uint32_t, PlateVertex> pinned;  // Vertices that are held.
  std::vector<std::uint32_t> fresh;             // Of these, the ones held in this round of mending.
  bool settled = false;
  bool stays = false;     // As the closed field has it.
  bool unsolved = false;  // For want of a solution.
};

class Fairing {
 public:
  Fairing(const TriangleMesh& mesh, const std::vector<ViewSampler>& views,
          const FairFillOptions& options, const Progress& progress)
      : mesh_(mesh),
        views_(views),
        options_(options),
        progress_(progress),
        regions_(mesh, views, options),
        work_(regions_.all().size()),
        places_(paged_copy(mesh.vertices)),
        changed_(mesh.vertices.size()) {}

  Result<FairFill> run() {
    if (const auto kept = check(options_.memory); !kept) return kept.error();
    if (work_.empty() && regions_.too_large() == 0) return FairFill();
    for (int round = 0; round <= kRounds; ++round) settle_all(round == kRounds);
    serial_for(places_.size(),
               [&](std::size_t v) { changed_[v] = places_[v] != mesh_.vertices[v]; });
    for (int round = 0; !stopped_ && resolve_intersections(round); ++round) {
    }
    if (stopped_) return Error{ErrorKind::kInterrupted, "closing holes was interrupted"};
    if (const auto kept = check(options_.memory); !kept) return kept.error();
    const auto unsolved = static_cast<std::size_t>(std::count_if(
        work_.begin(), work_.end(), [](const Settling& work) { return work.unsolved; }));
    return FairFill{std::move(places_), unsolved, regions_.too_large(),
                    regions_.any_near_samples()};
  }

 private:
  // The large regions first, in this thread, which asks between them whether to go on.
  // Under a limit one region at a time: only so is it known what all take together.
  void settle_all(bool last) {
    for (std::size_t r = 0; r < work_.size() && keep_going(); ++r)
      if (is_large(r) && !work_[r].settled) settle(r, last);
    if (!keep_going()) return;
    on_threads(options_.memory ? 1 : 0, [&] {
      parallel_for(work_.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r)
          if (!is_large(r) && !work_[r].settled) settle(r, last);
      });
    });
  }

  bool is_large(std::size_t r) const { return regions_.all()[r].vertices.size() > kLargeRegion; }

  // Of the thread that began the work only.
  bool keep_going() {
    if (!stopped_) stopped_ = !report_progress(progress_, 0.0, "close holes");
    return !stopped_;
  }

  // What may move of a region, and what holds it.
  PlatePatch patch_of(std::size_t r) const {
    PlatePatch patch;
    patch.held = regions_.all()[r].border;
    for (const PlateVertex& vertex : regions_.all()[r].vertices) add(r, vertex, patch);
    return patch;
  }

  void add(std::size_t r, const PlateVertex& vertex, PlatePatch& patch) const {
    const auto pin = work_[r].pinned.find(vertex.vertex);
    if (pin == work_[r].pinned.end())
      patch.free.push_back(vertex);
    else
      patch.held.push_back(pin->second);
  }

  // The patch near the vertices that were held last. The surface around the patch keeps its place
  // and its slope.
  PlatePatch patch_near_fresh(std::size_t r) const {
    const std::unordered_map<std::uint32_t, int> rings =
        edges_from(work_[r].fresh, kChangedRings + 2, mesh_, regions_.around());
    PlatePatch patch;
    patch.held = regions_.all()[r].border;
    for (const PlateVertex& vertex : regions_.all()[r].vertices) {
      const auto ring = rings.find(vertex.vertex);
      if (ring == rings.end()) continue;
      if (ring->second <= kChangedRings)
        add(r, vertex, patch);
      else  // the slope of the first of these rings depends on the second
        patch.held.push_back({vertex.vertex, places_[vertex.vertex],
                              ring->second == kChangedRings + 1 ? vertex.stiffness : 0.0});
    }
    return patch;
  }

  // Lets the region come to rest, and pins what would then be in space seen empty.
  void settle(std::size_t r, bool last) {
    evict_pages(options_.memory);
    Settling& work = work_[r];
    const PlatePatch patch = work.fresh.empty() ? patch_of(r) : patch_near_fresh(r);
    work.fresh.clear();
    work.settled = true;
    if (patch.free.empty()) return;
    const std::vector<Eigen::Vector3d> rest =
        solve_thin_plate(mesh_, regions_.around(), patch, options_.memory);
    if (rest.empty()) {
      work.unsolved = true;
      return restore(r);
    }
    TsdfIntegrator collector(views_, options_.truncation, options_.voxel_size);
    for (std::size_t k = 0; k < rest.size(); ++k) {
      const std::uint32_t v = patch.free[k].vertex;
      places_[v] = allowed(v, rest[k], collector);
      changed_[v] = 1;
      if (places_[v] == rest[k] || last) continue;
      work.pinned.emplace(v, PlateVertex{v, places_[v]});
      work.settled = false;
    }
  }

  // The farthest point on a vertex's way to `end` that is in no space seen empty. If its start is,
  // the nearest behind the surface that is not.
  Eigen::Vector3d allowed(std::uint32_t v, const Eigen::Vector3d& end,
                          TsdfIntegrator& collector) const {
    if (!mesh_.filled[v] || !collector.in_empty_space(end)) return end;
    const Eigen::Vector3d& start = mesh_.vertices[v];
    if (!collector.in_empty_space(start)) return last_sound(start, end, collector);
    const Eigen::Vector3d behind =
        start - kFarthestRetreat * options_.voxel_size * mesh_.normals[v].cast<double>();
    return collector.in_empty_space(behind) ? start : last_sound(behind, start, collector);
  }

  // Of the points from `sound`, which is in no space seen empty, to `empty`, which is: the last
  // that is not.
  Eigen::Vector3d last_sound(Eigen::Vector3d sound, Eigen::Vector3d empty,
                             TsdfIntegrator& collector) const {
    for (int step = 0; step < 6; ++step) {
      const Eigen::Vector3d middle = 0.5 * (sound + empty);
      (collector.in_empty_space(middle) ? empty : sound) = middle;
    }
    return sound;
  }

  void restore(std::size_t r) {
    for (const PlateVertex& free : regions_.all()[r].vertices) {
      places_[free.vertex] = mesh_.vertices[free.vertex];
      changed_[free.vertex] = 1;
    }
    work_[r].stays = work_[r].settled = true;
  }

  // Faces that intersect have slipped along the surface, as slivers do: their vertices then move
  // along the normal only. Where that does not help they stay, with more and more of those around
  // them, while the rest comes to rest anew; in the end the region goes back. False: there was
  // none.
  bool resolve_intersections(int round) {
    const std::vector<std::uint32_t> invalid =
        invalid_faces(mesh_, places_, changed_, 2.0 * options_.voxel_size);
    std::fill(changed_.begin(), changed_.end(), 0);
    TsdfIntegrator collector(views_, options_.truncation, options_.voxel_size);
    bool any = false;
    for (const std::uint32_t f : invalid) {
      for (const std::uint32_t v : mesh_.faces[f]) {
        const std::uint32_t r = regions_.region_of(v);
        if (r == FairRegions::kNone || work_[r].stays) continue;
        any = true;
        if (round < kRounds)
          keep_from_slipping(v, collector);
        else if (round < 2 * kRounds)
          hold(v);
        else
          restore(r);
      }
    }
    if (any && round >= kRounds && round < 2 * kRounds) settle_all(true);
    return any;
  }

  // Keeps a vertex and its neighbours where the closed field has them.
  void hold(std::uint32_t vertex) {
    regions_.around().visit(vertex, [&](std::uint32_t f) {
      for (const std::uint32_t v : mesh_.faces[f]) {
        const std::uint32_t r = regions_.region_of(v);
        if (r == FairRegions::kNone) continue;
        places_[v] = mesh_.vertices[v];
        work_[r].pinned[v] = {v, places_[v], kHeld};
        work_[r].fresh.push_back(v);
        work_[r].settled = false;
        changed_[v] = 1;
      }
    });
  }

  void keep_from_slipping(std::uint32_t v, TsdfIntegrator& collector) {
    const Eigen::Vector3d normal = regions_.normals().at(v), start = mesh_.vertices[v];
    places_[v] = allowed(v, start + normal.dot(places_[v] - start) * normal, collector);
    changed_[v] = 1;
  }

  const TriangleMesh& mesh_;
  const std::vector<ViewSampler>& views_;
  const FairFillOptions& options_;
  const Progress& progress_;
  bool stopped_ = false;  // Written by the thread that began the work, while others rest.
  const FairRegions regions_;
  std::vector<Settling> work_;
  PagedVector<Eigen::Vector3d> places_;  // Of the vertices, as far as they have been moved.
  PagedArray<std::uint8_t> changed_;     // Vertices whose faces are still to be looked at.
};

}  // namespace

Result<FairFill> fair_filled_regions(const TriangleMesh& mesh,
                                     const std::vector<ViewSampler>& views,
                                     const FairFillOptions& options, const Progress& progress) {
  if (std::none_of(mesh.filled.begin(), mesh.filled.end(),
                   [](std::uint8_t flag) { return flag != 0; }))
    return FairFill();
  return Fairing(mesh, views, options, progress).run();
}

}  // namespace relief::fusion
