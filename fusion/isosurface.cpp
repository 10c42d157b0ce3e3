#include "fusion/isosurface.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <compare>
#include <vector>

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include "scan/parallel.h"

namespace relief {

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

// Runs VTK's contour filter on the 8^3 cells of a block. One object per thread.
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
    if (!load(least_value(field))) return;
    values_->Modified();
    image_->Modified();
    contour_->Update();
    vtkPolyData* output = contour_->GetOutput();
    vtkCellArray* triangles = output->GetPolys();
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    for (triangles->InitTraversal(); triangles->GetNextCell(count, ids);) {
      assert(count == 3);
      // VTK winds triangles to face smaller values.
      for (const vtkIdType k : {0, 2, 1})
        corners.push_back(key(field.first_node(b), output, ids[k]));
    }
  }

 private:
  // False when all values have one sign.
  bool load(float least) {
    bool positive = false, negative = false;
    float* out = values_->GetPointer(0);
    for (int z = 0; z < kBrickNodes; ++z) {
      for (int y = 0; y < kBrickNodes; ++y) {
        for (int x = 0; x < kBrickNodes; ++x) {
          const float value = away_from_zero(padded_[padded_index(x, y, z)], least);
          (value > 0.0f ? positive : negative) = true;
          *out++ = value;
        }
      }
    }
    return positive && negative;
  }

  // Two coordinates of a contour point are integers, exactly; the third lies between two.
  static VertexKey key(const Node& first, vtkPolyData* output, vtkIdType id) {
    double place[3];
    output->GetPoint(id, place);
    Node node;
    std::uint32_t axis = 3;
    for (int k = 0; k < 3; ++k) {
      const double below = std::floor(place[k]);
      node[k] = static_cast<int>(below);
      if (place[k] != below) axis = static_cast<std::uint32_t>(k);
    }
    assert(axis < 3);
    return {key_of(first + node), axis};
  }

  vtkNew<vtkImageData> image_;
  vtkNew<vtkFloatArray> values_;
  vtkNew<vtkFlyingEdges3D> contour_;
  SparseField::Padded padded_;
};

// The corners of all triangles, three by three, in the order of the blocks.
std::vector<VertexKey> triangle_corners(const SparseField& field, int threads) {
  constexpr std::size_t kGrain = 64;
  const std::size_t blocks = field.block_count();
  std::vector<std::vector<VertexKey>> by_range((blocks + kGrain - 1) / kGrain);
  parallel_for(blocks, kGrain, threads, [&](std::size_t begin, std::size_t end) {
    BlockContour contour;
    for (std::size_t b = begin; b < end; ++b)
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
  assert((a > 0.0) != (b > 0.0));
  Eigen::Vector3d place = node.cast<double>();
  place[axis] += a / (a - b);
  return field.lattice().origin + field.lattice().spacing * place;
}

}  // namespace

TriangleMesh extract_isosurface(const SparseField& field, int threads) {
  const std::vector<VertexKey> corners = triangle_corners(field, threads);
  std::vector<VertexKey> keys = corners;
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  TriangleMesh mesh;
  mesh.vertices.resize(keys.size());
  parallel_for(keys.size(), 4096, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) mesh.vertices[v] = zero_on_edge(field, keys[v]);
  });
  mesh.faces.resize(corners.size() / 3);
  parallel_for(mesh.faces.size(), 4096, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto place = std::lower_bound(keys.begin(), keys.end(), corners[3 * f + k]);
        mesh.faces[f][k] = static_cast<std::uint32_t>(place - keys.begin());
      }
    }
  });
  return mesh;
}

}  // namespace relief
