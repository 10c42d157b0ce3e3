#include "fusion/surface/vertex_colours.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "fusion/holes/plates/thin_plate.h"
#include "fusion/surface/vertex_groups.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Sweeps of relaxation. Bounds the time: they smooth over about sqrt(3 / 4 * 60) = 7 edges.
// Colours, unlike surfaces, need not be harmonic to the last digit.
constexpr int kSweeps = 60;

// Vertices that are relaxed one after the other. Between such parts, which threads share, colours
// are those of the sweep before: the result depends on this number, but not on that of threads.
constexpr std::size_t kPart = 8192;

// Colours of vertices, and which of them are known.
struct Painting {
  PagedVector<Eigen::Vector3f> colour;
  PagedArray<std::uint8_t> known;
};

Painting measured_colours(const TriangleMesh& mesh, const std::vector<ViewSampler>& views,
                          const VertexAttributeOptions& options) {
  const std::size_t count = mesh.vertices.size();
  Painting painting{paged_filled<Eigen::Vector3f>(count, Eigen::Vector3f::Zero()),
                    PagedArray<std::uint8_t>(count)};
  parallel_for(count, 1024, [&](std::size_t begin, std::size_t end) {
    evict_pages(options.memory);
    TsdfIntegrator collector(views, options.truncation, options.voxel_size);
    visit_in_groups(mesh, begin, end, collector, [&](std::size_t v) {
      if (mesh.filled[v]) return;
      collector.collect(mesh.vertices[v], mesh.normals[v].cast<double>());
      const auto colour = collector.colour(mesh.vertices[v]);
      if (!colour) return;
      painting.colour[v] = colour->cast<float>();
      painting.known[v] = 1;
    });
  });
  return painting;
}

// Spreads known colours to the other vertices, nearest ones first, and smooths what was spread.
class Spreading {
 public:
  Spreading(const TriangleMesh& mesh, Painting& painting)
      : mesh_(mesh), painting_(painting), around_(mesh, unknown(painting.known)) {}

  void run() {
    for (std::vector<std::uint32_t> ring = first_ring(); !ring.empty(); ring = next_ring(ring)) {
      std::vector<Eigen::Vector3f> means;
      for (const std::uint32_t v : ring) means.push_back(mean_around(v));
      for (std::size_t k = 0; k < ring.size(); ++k) {
        painting_.colour[ring[k]] = means[k];
        painting_.known[ring[k]] = 1;
      }
      spread_.insert(spread_.end(), ring.begin(), ring.end());
    }
    // Vertices of near indices are near each other, and in memory.
    std::sort(spread_.begin(), spread_.end());
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      before_ = paged_copy(painting_.colour);
      parallel_for(spread_.size(), kPart, [&](std::size_t begin, std::size_t end) {
        relax(std::span(spread_).subspan(begin, end - begin), sweep % 2 == 0);
      });
    }
  }

 private:
  static PagedArray<std::uint8_t> unknown(const PagedArray<std::uint8_t>& known) {
    PagedArray<std::uint8_t> flags(known.size());
    for (std::size_t v = 0; v < known.size(); ++v) flags[v] = !known[v];
    return flags;
  }

  template <typename Visit>
  void visit_neighbours(std::uint32_t v, const Visit& visit) const {
    around_.visit(v, [&](std::uint32_t f) {
      for (const std::uint32_t w : mesh_.faces[f])
        if (w != v) visit(w);
    });
  }

  // The vertices after this one in its faces: on a closed surface each neighbour is one once.
  template <typename Visit>
  void visit_followers(std::uint32_t v, const Visit& visit) const {
    around_.visit(v, [&](std::uint32_t f) {
      const TriangleMesh::Face& face = mesh_.faces[f];
      visit(face[0] == v ? face[1] : face[1] == v ? face[2] : face[0]);
    });
  }

  Eigen::Vector3f mean_around(std::uint32_t v) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int count = 0;
    visit_neighbours(v, [&](std::uint32_t w) {
      if (!painting_.known[w]) return;
      sum += painting_.colour[w];
      ++count;
    });
    return count > 0 ? Eigen::Vector3f(sum / static_cast<float>(count)) : sum;
  }

  // One sweep over a part of the vertices, in either direction.
  void relax(std::span<const std::uint32_t> part, bool forward) {
    const std::uint32_t first = part.front(), last = part.back();
    for (std::size_t k = 0; k < part.size(); ++k) {
      const std::uint32_t v = part[forward ? k : part.size() - 1 - k];
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int count = 0;
      visit_followers(v, [&](std::uint32_t w) {
        sum += w < first || w > last ? before_[w] : painting_.colour[w];
        ++count;
      });
      painting_.colour[v] = sum / static_cast<float>(count);
    }
  }

  std::vector<std::uint32_t> first_ring() const {
    std::vector<std::uint32_t> ring;
    for (std::uint32_t v = 0; v < painting_.known.size(); ++v) {
      if (painting_.known[v]) continue;
      bool beside = false;
      visit_neighbours(v, [&](std::uint32_t w) { beside = beside || painting_.known[w]; });
      if (beside) ring.push_back(v);
    }
    return ring;
  }

  std::vector<std::uint32_t> next_ring(const std::vector<std::uint32_t>& ring) const {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t v : ring)
      visit_neighbours(v, [&](std::uint32_t w) {
        if (!painting_.known[w]) next.push_back(w);
      });
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    return next;
  }

  const TriangleMesh& mesh_;
  Painting& painting_;
  FacesAround around_;                   // Of vertices whose colour is unknown at first.
  std::vector<std::uint32_t> spread_;    // The vertices that colours were spread to.
  PagedVector<Eigen::Vector3f> before_;  // The colours before a sweep.
};

Colour rounded(const Eigen::Vector3f& colour) {
  const auto channel = [](float value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0l, 255l));
  };
  return {channel(colour.x()), channel(colour.y()), channel(colour.z())};
}

}  // namespace

void set_vertex_colours(TriangleMesh& mesh, const std::vector<ViewSampler>& views,
                        const VertexAttributeOptions& options) {
  if (std::none_of(views.begin(), views.end(), [](const auto& view) { return view.has_colours(); }))
    return;
  Painting painting = measured_colours(mesh, views, options);
  Spreading(mesh, painting).run();
  mesh.colours.reserve(mesh.vertices.size());
  serial_for(mesh.vertices.size(),
             [&](std::size_t v) { mesh.colours.push_back(rounded(painting.colour[v])); });
}

}  // namespace relief::fusion
