#include "fusion/surface/isosurface.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <utility>
#include <vector>

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

constexpr int kBrickNodes = kBlockSide + 1;

// Names the vertex on a lattice edge, the same from every block that meets it.
struct VertexKey {
  NodeKey node;
  std::uint32_t axis;
  auto operator<=>(const VertexKey&) const = default;
};

float away_from_zero(float value, float least) {
  if (std::abs(value) >= least) return value;
  return value > 0.0f ? least : -least;
}

float least_value(const SparseField& field) {
  return static_cast<float>(1e-3 * field.lattice().spacing);
}

// Runs VTK's contour filter on the 8^3 cells of a block. One object per thread. The filter gets the
// signs of the values alone, which decide how vertices are joined: every vertex is then in the very
// middle of its edge, whose name no rounding can change, however much its two values differ.
class BlockContour {
 public:
  BlockContour() {
    image_->SetDimensions(kBrickNodes, kBrickNodes, kBrickNodes);
    values_->SetNumberOfValues(kBrickNodes * kBrickNodes * kBrickNodes);
    image_->GetPointData()->SetScalars(values_);
    contour_->SetInputData(image_);
    contour_->SetValue(0, 0.0);
    contour_->ComputeNormalsOff();
    contour_->ComputeGradientsOff();
    contour_->ComputeScalarsOff();
  }

  // Appends the corners of the block's triangles.
  void extract(const SparseField& field, std::size_t b, std::vector<VertexKey>& corners) {
    field.gather(b, padded_);
    if (!load_signs()) return;
    values_->Modified();
    image_->Modified();
    contour_->Update();
    vtkPolyData* output = contour_->GetOutput();
    vtkCellArray* triangles = output->GetPolys();
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    for (triangles->InitTraversal(); triangles->GetNextCell(count, ids);) {
      // VTK winds triangles to face smaller values.
      for (const vtkIdType k : {0, 2, 1})
        corners.push_back(key(field.first_node(b), output, ids[k]));
    }
  }

 private:
  // False when all values have one sign.
  bool load_signs() {
    bool positive = false, negative = false;
    float* out = values_->GetPointer(0);
    for (int z = 0; z < kBrickNodes; ++z) {
      for (int y = 0; y < kBrickNodes; ++y) {
        for (int x = 0; x < kBrickNodes; ++x) {
          const bool outside = padded_[padded_index(x, y, z)] > 0.0f;
          (outside ? positive : negative) = true;
          *out++ = outside ? 1.0f : -1.0f;
        }
      }
    }
    return positive && negative;
  }

  // Two coordinates of a contour point are integers, exactly; the third lies half between two.
  static VertexKey key(const Node& first, vtkPolyData* output, vtkIdType id) {
    double place[3];
    output->GetPoint(id, place);
    Node node;
    std::uint32_t axis = 0;
    for (int k = 0; k < 3; ++k) {
      const double below = std::floor(place[k]);
      node[k] = static_cast<int>(below);
      if (place[k] != below) axis = static_cast<std::uint32_t>(k);
    }
    return {key_of(first + node), axis};
  }

  vtkNew<vtkImageData> image_;
  vtkNew<vtkFloatArray> values_;
  vtkNew<vtkFlyingEdges3D> contour_;
  SparseField::Padded padded_;
};

// Consecutive blocks [begin, end).
struct BlockRange {
  std::size_t begin = 0, end = 0;
};

// The next brick from block `begin` on: whole layers of blocks of one z, so that its vertices come
// before those of all later bricks.
BlockRange next_brick(const SparseField& field, std::size_t begin) {
  constexpr std::size_t kBrickBlocks = 4096;  // Bounds the memory; changes no result.
  std::size_t end = std::min(begin + kBrickBlocks, field.block_count());
  while (end < field.block_count() && field.block(end).z() == field.block(end - 1).z()) ++end;
  return {begin, end};
}

// The corners of a brick's triangles, three by three, in the order of the blocks.
std::vector<VertexKey> triangle_corners(const SparseField& field, const BlockRange& brick,
                                        MemoryLimit* memory) {
  constexpr std::size_t kGrain = 64;  // Blocks of one piece of work; changes no result.
  const std::size_t blocks = brick.end - brick.begin;
  std::vector<std::vector<VertexKey>> by_range((blocks + kGrain - 1) / kGrain);
  parallel_for(blocks, kGrain, [&](std::size_t begin, std::size_t end) {
    evict_pages(memory);
    BlockContour contour;
    for (std::size_t b = brick.begin + begin; b < brick.begin + end; ++b)
      if (field.active(b)) contour.extract(field, b, by_range[begin / kGrain]);
  });
  std::vector<VertexKey> corners;
  for (const auto& range : by_range) corners.insert(corners.end(), range.begin(), range.end());
  return corners;
}

// Where the linear interpolant of the field vanishes on the lattice edge of a vertex.
Eigen::Vector3d zero_on_edge(const SparseField& field, const VertexKey& key) {
  const int axis = static_cast<int>(key.axis);
  const Node node = node_of(key.node);
  const float least = least_value(field);
  const double a = away_from_zero(field.value(node), least);
  const double b = away_from_zero(field.value(node + Node(Node::Unit(axis))), least);
  Eigen::Vector3d place = node.cast<double>();
  place[axis] += a / (a - b);
  return field.lattice().origin + field.lattice().spacing * place;
}

// Joins bricks, given in their order, to one mesh. Vertices are numbered in the order of their
// keys, so those on the upper border of a brick get their numbers with the next one, and the
// brick's faces wait for them.
class BrickJoiner {
 public:
  explicit BrickJoiner(const SparseField& field) : field_(field) {}

  // `top`: the layer of nodes from which on vertices belong to the next brick.
  void add(std::vector<VertexKey> corners, int top) {
    std::vector<VertexKey> keys = std::move(open_);
    keys.insert(keys.end(), corners.begin(), corners.end());
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    const auto split = std::partition_point(keys.begin(), keys.end(), [&](const VertexKey& key) {
      return node_of(key.node).z() < top;
    });
    open_.assign(split, keys.end());
    keys.erase(split, keys.end());
    number(std::move(keys));
    corners_ = std::move(corners);
  }

  TriangleMesh finish() {
    number(std::move(open_));
    return {.vertices = joined(std::move(vertices_)), .faces = joined(std::move(faces_))};
  }

 private:
  template <typename T>
  using Pieces = std::vector<PagedVector<T>>;  // Of bricks, in their order.

  // Each piece is gone as soon as it is in its place.
  template <typename T>
  static PagedVector<T> joined(Pieces<T> pieces) {
    std::size_t size = 0;
    for (const auto& piece : pieces) size += piece.size();
    PagedVector<T> all;
    all.reserve(size);
    for (auto& piece : pieces) {
      append_paged(piece, all);
      piece = {};
    }
    return all;
  }

  // Makes vertices of `keys`, which follow all earlier ones, and the faces that waited for them.
  void number(std::vector<VertexKey> keys) {
    const std::size_t first = first_ + keys_.size();
    keys_.insert(keys_.end(), keys.begin(), keys.end());
    auto& vertices = vertices_.emplace_back(keys.size());
    parallel_for(keys.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) vertices[v] = zero_on_edge(field_, keys[v]);
    });
    add_faces();
    keys_ = std::move(keys);
    first_ = first;
  }

  void add_faces() {
    const std::size_t count = corners_.size() / 3;
    auto& faces = faces_.emplace_back(count);
    parallel_for(count, 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
          const auto place = std::lower_bound(keys_.begin(), keys_.end(), corners_[3 * f + k]);
          faces[f][k] =
              static_cast<std::uint32_t>(first_ + static_cast<std::size_t>(place - keys_.begin()));
        }
      }
    });
    corners_.clear();
  }

  const SparseField& field_;
  Pieces<Eigen::Vector3d> vertices_;
  Pieces<TriangleMesh::Face> faces_;
  std::vector<VertexKey> open_;     // Vertices of the last brick that the next one numbers.
  std::vector<VertexKey> corners_;  // Of the last brick's triangles.
  std::vector<VertexKey> keys_;     // The last brick's vertices.
  std::size_t first_ = 0;           // The number of the first vertex of `keys_`.
};

}  // namespace

TriangleMesh extract_isosurface(const SparseField& field, MemoryLimit* memory) {
  BrickJoiner joiner(field);
  for (BlockRange brick = next_brick(field, 0); brick.begin < brick.end;
       brick = next_brick(field, brick.end)) {
    if (!check(memory)) return {};
    joiner.add(triangle_corners(field, brick, memory),
               kBlockSide * (field.block(brick.end - 1).z() + 1));
  }
  return joiner.finish();
}

}  // namespace relief::fusion
