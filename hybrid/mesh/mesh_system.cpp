#include "hybrid/mesh/mesh_system.h"

#include <algorithm>
#include <cmath>

#include "scan/base/memory/paged_median.h"
#include "scan/base/parallel.h"
#include "scan/base/robust_scales.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kGrain = 4096;  // vertices of one piece of work; changes no result
// How stiff the surface keeps its shape where no normals tell [rad]. A move dies out over a length
// of quality / 0.05: 20 edges where that is an edge, 40 with half of it, 10 with twice.
constexpr double kShapeSigma = 0.05;
// How far off the mean normal of an edge may be on which the normals turn, for each radian: as if
// they turned at one place, at either end.
constexpr double kTurnError = 0.5;
// Edges on which normals turn as far as this cross a crease and say nothing [rad]. Half of the
// weight is left at 0.32 (19 degrees). At half of it relief of radius 6 edges would lose as much.
constexpr double kCrease = 0.6;
// Cosine between the blended normal of a vertex and the mesh's own along which it moves: moving the
// surface by d then takes a way of 2 d at most.
constexpr double kLeastAgreement = 0.5;

// The vector of vertex i, of one each.
Eigen::Vector3d at(const MeshValues& values, std::size_t i) {
  return Eigen::Map<const Eigen::Vector3d>(values.data() + 3 * i);
}
void set(MeshValues& values, std::size_t i, const Eigen::Vector3d& vector) {
  Eigen::Map<Eigen::Vector3d>(values.data() + 3 * i) = vector;
}

}  // namespace

template <typename Visit>
void MeshSystem::for_vertices(const Visit& visit) const {
  parallel_for(graph_.vertices(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) visit(i);
  });
}

MeshSystem::MeshSystem(const TriangleMesh& mesh, const MeshGraph& graph, const MeshNormals& normals,
                       const MeshSystemOptions& options)
    : mesh_(mesh), graph_(graph), options_(options) {
  directions_ = vertex_normals(mesh);
  const std::size_t count = mesh.vertices.size();
  normals_ = PagedArray<Eigen::Vector3f>(count);
  sigma_ = PagedArray<float>(count);
  position_weight_ = MeshValues(count);
  tangential_weight_ = MeshValues(count);
  sample_area_ = normals.sample_spacing * normals.sample_spacing;
  if (!(sample_area_ > 0.0)) sample_area_ = surface_area(mesh) / static_cast<double>(count);
  // An error that is tiny by accident must not pin its vertex.
  const double least = 0.2 * double{paged_median(mesh.quality)};
  const auto share_of = [&](std::size_t i) {
    return graph.vertex_area[i] > 0.0f ? double{graph.vertex_area[i]} / sample_area_ : 1.0;
  };
  for_vertices([&](std::size_t i) {
    const bool measured = normals.views[i] > 0;
    normals_[i] = directions_[i];
    if (measured) {
      normals_[i] = normals.normals[i];
      if (normals_[i].dot(directions_[i]) > kLeastAgreement) directions_[i] = normals_[i];
      sigma_[i] =
          options.sigma_normal > 0.0 ? static_cast<float>(options.sigma_normal) : normals.sigma[i];
    }
    const double sigma = options.sigma_position > 0.0 ? options.sigma_position
                                                      : std::max<double>(mesh.quality[i], least);
    // A vertex of a finer mesh than the samples stands for part of a sample.
    const double share = share_of(i);
    position_weight_[i] = share / (sigma * sigma);
    tangential_weight_[i] = measured
                                ? position_weight_[i] / (options.tangential * options.tangential)
                                : share / (kShapeSigma * kShapeSigma * sample_area_);
  });
  serial_for(count, [&](std::size_t i) { samples_ += share_of(i); });
  if (!normals.edges.empty()) middles_ = &normals.edges;
  weight_ = PagedArray<float>(graph_.neighbour.size());
  for_vertices([&](std::size_t i) {
    for (std::size_t k = graph_.begin[i]; k < graph_.begin[i + 1]; ++k)
      weight_[k] = static_cast<float>(base_weight(i, k));
  });
}

// The mean of the normals at both ends, or, where the middle of the edge has one too, Simpson's
// rule for the mean along the edge.
Eigen::Vector3d MeshSystem::edge_normal(std::size_t i, std::size_t k) const {
  const Eigen::Vector3d ends = (normals_[i] + normals_[graph_.neighbour[k]]).cast<double>();
  if (!middles_ || (*middles_)[k].isZero()) return 0.5 * ends;
  return (ends + 4.0 * (*middles_)[k].cast<double>()) / 6.0;
}

MeshSystem::Edge MeshSystem::edge(std::size_t i, std::size_t k) const {
  const std::uint32_t j = graph_.neighbour[k];
  Edge edge{edge_normal(i, k), 0.0};
  if (sigma_[i] > 0.0f && sigma_[j] > 0.0f)
    edge.residual = edge.normal.dot(mesh_.vertices[j] - mesh_.vertices[i]);
  return edge;
}

double MeshSystem::angular_variance(std::size_t i, std::size_t k) const {
  const std::uint32_t j = graph_.neighbour[k];
  if (!(sigma_[i] > 0.0f && sigma_[j] > 0.0f)) return kShapeSigma * kShapeSigma;
  const double at_i = sigma_[i], at_j = sigma_[j];
  return 0.5 * (at_i * at_i + at_j * at_j) +
         kTurnError * kTurnError * double{(normals_[i] - normals_[j]).squaredNorm()};
}

// Tukey's biweight of the turn.
double MeshSystem::smoothness(std::size_t i, std::size_t k) const {
  const std::uint32_t j = graph_.neighbour[k];
  if (!(sigma_[i] > 0.0f && sigma_[j] > 0.0f)) return 1.0;
  const double turn2 = double{(normals_[i] - normals_[j]).squaredNorm()} / (kCrease * kCrease);
  return turn2 < 1.0 ? (1.0 - turn2) * (1.0 - turn2) : 0.0;
}

// The sum over edges of 2 edge_area (slope along the edge)^2 is the integral of the squared slope:
// exactly so for equilateral faces. Divided by the area of a sample, it counts each sample's normal
// once, however fine the mesh.
double MeshSystem::base_weight(std::size_t i, std::size_t k) const {
  const double length2 = (mesh_.vertices[graph_.neighbour[k]] - mesh_.vertices[i]).squaredNorm();
  if (!(length2 > 0.0)) return 0.0;
  return 2.0 * smoothness(i, k) * double{graph_.edge_area[k]} /
         (sample_area_ * length2 * angular_variance(i, k));
}

MeshMoves MeshSystem::in_space(const MeshValues& displacements) const {
  const bool full = displacements.size() == 3 * directions_.size();
  MeshMoves moved(directions_.size());
  for_vertices([&](std::size_t i) {
    moved[i] = full ? at(displacements, i)
                    : Eigen::Vector3d(displacements[i] * directions_[i].cast<double>());
  });
  return moved;
}

double MeshSystem::in_errors(const MeshValues& a, const MeshValues& b) const {
  const std::size_t entries = a.size() / directions_.size();
  double sum = 0.0;
  serial_for(directions_.size(), [&](std::size_t i) {
    for (std::size_t k = entries * i; k < entries * (i + 1); ++k)
      sum += position_weight_[i] * (a[k] - b[k]) * (a[k] - b[k]);
  });
  return std::sqrt(sum / samples_);
}

void MeshSystem::reweight(const MeshValues& displacements) {
  const MeshMoves moved = in_space(displacements);
  for_vertices([&](std::size_t i) {
    for (std::size_t k = graph_.begin[i]; k < graph_.begin[i + 1]; ++k) {
      const std::uint32_t j = graph_.neighbour[k];
      const Edge e = edge(i, k);
      const double left = e.residual + e.normal.dot(moved[j] - moved[i]);
      const double variance =
          (mesh_.vertices[j] - mesh_.vertices[i]).squaredNorm() * angular_variance(i, k);
      double weight = base_weight(i, k);
      if (variance > 0.0) weight /= 1.0 + left * left / (kCauchyScale * kCauchyScale * variance);
      weight_[k] = static_cast<float>(weight);
    }
  });
}

// Minimises sum a x_i^2 + sum w (r_ij + c_j x_j - c_i x_i)^2 with c = normal . direction.
MeshMatrix MeshSystem::normal_matrix() const {
  MeshMatrix matrix;
  matrix.graph = &graph_;
  matrix.diagonal = MeshValues(graph_.vertices());
  matrix.off_diagonal = PagedArray<float>(graph_.neighbour.size());
  for_vertices([&](std::size_t i) {
    matrix.diagonal[i] = position_weight_[i];
    for (std::size_t k = graph_.begin[i]; k < graph_.begin[i + 1]; ++k) {
      const Eigen::Vector3d normal = edge_normal(i, k);
      const double weight = weight_[k], ci = normal.dot(directions_[i].cast<double>()),
                   cj = normal.dot(directions_[graph_.neighbour[k]].cast<double>());
      matrix.diagonal[i] += weight * ci * ci;
      matrix.off_diagonal[k] = static_cast<float>(-weight * ci * cj);
    }
  });
  return matrix;
}

Eigen::Vector3d MeshSystem::edge_residual(std::size_t i) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = graph_.begin[i]; k < graph_.begin[i + 1]; ++k) {
    const Edge e = edge(i, k);
    sum += double{weight_[k]} * e.residual * e.normal;
  }
  return sum;
}

MeshValues MeshSystem::normal_rhs() const {
  MeshValues rhs(graph_.vertices());
  for_vertices(
      [&](std::size_t i) { rhs[i] = directions_[i].cast<double>().dot(edge_residual(i)); });
  return rhs;
}

MeshValues MeshSystem::full_rhs() const {
  MeshValues rhs(3 * graph_.vertices());
  for_vertices([&](std::size_t i) { set(rhs, i, edge_residual(i)); });
  return rhs;
}

MeshValues MeshSystem::full_product(const MeshValues& d) const {
  MeshValues result(d.size());
  for_vertices([&](std::size_t i) {
    const Eigen::Vector3d here = at(d, i);
    const Eigen::Vector3d direction = directions_[i].cast<double>();
    const Eigen::Vector3d along = direction * direction.dot(here);
    Eigen::Vector3d sum = position_weight_[i] * along + tangential_weight_[i] * (here - along);
    for (std::size_t k = graph_.begin[i]; k < graph_.begin[i + 1]; ++k) {
      const Eigen::Vector3d normal = edge_normal(i, k);
      sum += double{weight_[k]} * normal * normal.dot(here - at(d, graph_.neighbour[k]));
    }
    set(result, i, sum);
  });
  return result;
}

MeshValues MeshSystem::full_precondition(const LinearMap& along_normals,
                                         const MeshValues& r) const {
  MeshValues lengths(directions_.size());
  for_vertices([&](std::size_t i) { lengths[i] = directions_[i].cast<double>().dot(at(r, i)); });
  const MeshValues solved = along_normals(lengths);
  MeshValues result(r.size());
  for_vertices([&](std::size_t i) {
    const Eigen::Vector3d direction = directions_[i].cast<double>();
    set(result, i,
        solved[i] * direction + (at(r, i) - lengths[i] * direction) / tangential_weight_[i]);
  });
  return result;
}

}  // namespace relief::hybrid
