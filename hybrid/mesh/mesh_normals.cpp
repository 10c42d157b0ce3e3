#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "hybrid/mesh/mesh_graph.h"
#include "hybrid/mesh/normal_sampler.h"
#include "relief/hybrid/polish_mesh.h"
#include "scan/base/median.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"
#include "scan/base/robust_scales.h"

namespace relief::hybrid {

namespace {

constexpr double kSigmaUnknown = 2.0 * std::numbers::pi / 180.0;  // [rad]
constexpr double kLeastSigma = 1e-3;  // [rad]; float normals on curved surfaces know no better
// Part of the cut-off of Tukey's biweight within which all normals must lie for their mean to be a
// safe start: 3.3 sigma, which one in 200 normals with Gaussian errors exceeds.
constexpr double kNear = 0.5;
// How many measurements the common scatter counts for against a vertex's own.
constexpr double kPriorWeight = 3.0;
constexpr std::size_t kGrain = 2048;  // vertices of one piece of work; changes no result
// Vertices for which the views near them are looked up together; changes no result. Those of near
// indices are near each other in an extracted mesh.
constexpr std::size_t kGroup = 256;

double median_spacing(const std::vector<NormalSampler>& samplers) {
  std::vector<double> spacings;
  for (const NormalSampler& sampler : samplers) spacings.push_back(sampler.spacing());
  return median(std::move(spacings));
}

// For each group of vertices the views near these and their neighbours.
std::vector<NearViews> views_near_groups(const TriangleMesh& mesh, const MeshGraph& graph,
                                         const std::vector<NormalSampler>& samplers,
                                         double max_distance) {
  const std::size_t count = graph.vertices();
  return parallel_map<NearViews>((count + kGroup - 1) / kGroup, [&](std::size_t group) {
    const std::size_t begin = group * kGroup, end = std::min(begin + kGroup, count);
    Eigen::AlignedBox3d box;
    for (std::size_t i = begin; i < end; ++i) box.extend(mesh.vertices[i]);
    for (std::size_t k = graph.begin[begin]; k < graph.begin[end]; ++k)
      box.extend(mesh.vertices[graph.neighbour[k]]);
    return views_near(box, samplers, max_distance);
  });
}

// Which views may have a say somewhere: bit i for view i, i + 64, ...
using Observers = std::uint64_t;
constexpr Observers kAll = ~Observers{0};

// The observations at a vertex of those among the views near it that may have one; returns which
// did. Sorted, so that the order of the views does not change a bit of the sums.
Observers collect(const std::vector<NormalSampler>& samplers, const NearViews& near,
                  const Eigen::Vector3d& vertex, const Eigen::Vector3d& mesh_normal,
                  double max_distance, Observers asked,
                  std::vector<NormalObservation>& observations) {
  observations.clear();
  Observers observers = 0;
  for (const std::size_t i : near) {
    const Observers bit = Observers{1} << (i % 64);
    if (!(asked & bit)) continue;
    const auto observation = samplers[i].at(vertex, mesh_normal, max_distance);
    if (!observation) continue;
    observations.push_back(*observation);
    observers |= bit;
  }
  std::sort(observations.begin(), observations.end(),
            [](const NormalObservation& a, const NormalObservation& b) {
              return std::tie(a.weight, a.normal.x(), a.normal.y(), a.normal.z()) >
                     std::tie(b.weight, b.normal.x(), b.normal.y(), b.normal.z());
            });
  return observers;
}

struct Blend {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double variance = 0.0;   // of the views round it, along one tangent [rad^2]
  double effective = 0.0;  // (sum w)^2 / sum w^2
  int views = 0;           // that kept a say
};

// Of the observations at one place, a mean of normals after the other. Keeps scratch memory: one
// object per thread.
class Blender {
 public:
  explicit Blender(double sigma) : sigma_(sigma) {}

  // Starts from the spatial median (Weiszfeld 1937), which up to half of the weight cannot carry
  // away, and ends with Tukey's biweight, to which views far off mean nothing. Where none is far
  // off the mean serves as well to start from.
  Blend operator()(const std::vector<NormalObservation>& observations) {
    Blend blend = weighted_mean(
        observations, [](const NormalObservation& observation) { return observation.weight; });
    const bool agree = all_near(blend.normal, observations);
    for (int round = 0; round < 6 && observations.size() >= 3 && !agree; ++round) {
      const Eigen::Vector3d centre = blend.normal;
      blend = weighted_mean(observations, [&](const NormalObservation& observation) {
        return observation.weight / std::max(0.1 * sigma_, (observation.normal - centre).norm());
      });
    }
    kept_.swap(weights_);
    for (int round = 0; round < 3 && observations.size() >= 3; ++round) {
      const Eigen::Vector3d centre = blend.normal;
      const Blend next = weighted_mean(observations, [&](const NormalObservation& observation) {
        const double r2 = squared_distance(observation, centre);
        return r2 < 1.0 ? observation.weight * (1.0 - r2) * (1.0 - r2) : 0.0;
      });
      if (next.views == 0) break;
      blend = next;
      kept_.swap(weights_);
    }
    blend.variance = variance_about(blend.normal, observations);
    return blend;
  }

 private:
  template <typename Weight>
  Blend weighted_mean(const std::vector<NormalObservation>& observations, const Weight& weight_of) {
    Blend blend;
    double sum = 0.0, squares = 0.0;
    weights_.clear();
    for (const NormalObservation& observation : observations) {
      const double weight = std::max(0.0, weight_of(observation));
      weights_.push_back(weight);
      if (weight <= 0.0) continue;
      blend.normal += weight * observation.normal;
      sum += weight;
      squares += weight * weight;
      ++blend.views;
    }
    if (!(sum > 0.0) || blend.normal.norm() < 0.1 * sum) return {};
    blend.normal.normalize();
    blend.effective = sum * sum / squares;
    return blend;
  }

  // In units of what Tukey's biweight goes up to.
  double squared_distance(const NormalObservation& observation,
                          const Eigen::Vector3d& centre) const {
    return (observation.normal - centre).squaredNorm() /
           (kTukeyScale * kTukeyScale * 2 * sigma_ * sigma_);
  }

  bool all_near(const Eigen::Vector3d& centre,
                const std::vector<NormalObservation>& observations) const {
    return std::all_of(observations.begin(), observations.end(), [&](const auto& observation) {
      return squared_distance(observation, centre) < kNear * kNear;
    });
  }

  double variance_about(const Eigen::Vector3d& normal,
                        const std::vector<NormalObservation>& observations) const {
    double variance = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      variance += kept_[i] * 0.5 * (observations[i].normal - normal).squaredNorm();
      sum += kept_[i];
    }
    return sum > 0.0 ? variance / sum : 0.0;
  }

  double sigma_;
  std::vector<double> weights_;  // Of the observations, in the last round.
  std::vector<double> kept_;     // The same in the round that holds.
};

// The median over pairs of views at a sample of the vertices: squared differences of two
// normals are exponentially distributed with mean 4 sigma^2.
double scatter(const TriangleMesh& mesh, const PagedVector<Eigen::Vector3f>& mesh_normals,
               const std::vector<NormalSampler>& samplers, const std::vector<NearViews>& near,
               double max_distance) {
  // Bounds the time. As many pairs tell the scatter to 0.5 % (1 / (2 ln 2 sqrt(n))).
  constexpr std::size_t kVertices = 20000;
  const std::size_t stride = std::max<std::size_t>(1, mesh.vertices.size() / kVertices);
  const std::size_t count = (mesh.vertices.size() + stride - 1) / stride;
  std::vector<double> differences(count, -1.0);
  parallel_for(count, 256, [&](std::size_t begin, std::size_t end) {
    std::vector<NormalObservation> observations;
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = k * stride;
      if (!mesh.filled.empty() && mesh.filled[i]) continue;
      collect(samplers, near[i / kGroup], mesh.vertices[i], mesh_normals[i].cast<double>(),
              max_distance, kAll, observations);
      if (observations.size() >= 2)
        differences[k] = (observations[0].normal - observations[1].normal).squaredNorm();
    }
  });
  std::erase_if(differences, [](double d) { return d < 0.0; });
  if (differences.size() < 30) return kSigmaUnknown;
  return std::max(kLeastSigma, std::sqrt(median(differences) / (4.0 * std::numbers::ln2)));
}

// The standard error of the blend: the scatter at the vertex steadied by that of all vertices.
double standard_error(const Blend& blend, double sigma) {
  const double own = std::max(0.0, blend.effective - 1.0);
  const double variance =
      (kPriorWeight * sigma * sigma + blend.effective * blend.variance) / (kPriorWeight + own);
  return std::sqrt(variance / blend.effective);
}

// Asked are the views that had a say at either end.
void blend_edges(const TriangleMesh& mesh, const PagedVector<Eigen::Vector3f>& mesh_normals,
                 const std::vector<NormalSampler>& samplers, const MeshGraph& graph,
                 const std::vector<NearViews>& near, const PagedArray<Observers>& observers,
                 double max_distance, MeshNormals& blended) {
  blended.edges = paged_filled<Eigen::Vector3f>(graph.neighbour.size(), Eigen::Vector3f::Zero());
  const auto has = [&](std::size_t i) { return blended.views[i] > 0; };
  parallel_for(graph.vertices(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<NormalObservation> observations;
    Blender blend_observations(blended.sigma_view);
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t k = graph.begin[i]; k < graph.begin[i + 1]; ++k) {
        const std::uint32_t j = graph.neighbour[k];
        if (j < i || !has(i) || !has(j)) continue;
        collect(samplers, near[i / kGroup], 0.5 * (mesh.vertices[i] + mesh.vertices[j]),
                (mesh_normals[i] + mesh_normals[j]).cast<double>().normalized(), max_distance,
                observers[i] | observers[j], observations);
        const Blend blend = blend_observations(observations);
        if (blend.views == 0) continue;
        blended.edges[k] = blend.normal.cast<float>();
        const auto mirrored = std::lower_bound(
            graph.neighbour.begin() + static_cast<std::ptrdiff_t>(graph.begin[j]),
            graph.neighbour.begin() + static_cast<std::ptrdiff_t>(graph.begin[j + 1]), i);
        blended.edges[static_cast<std::size_t>(mirrored - graph.neighbour.begin())] =
            blended.edges[k];
      }
    }
  });
}

Result<MeshNormals> blend_views(const TriangleMesh& mesh, const std::vector<RangeView>& views,
                                const MeshNormalOptions& options, const Progress& progress) {
  const Error interrupted{ErrorKind::kInterrupted, "blending the normals was interrupted"};
  if (!report_progress(progress, 0.0, "blend normals")) return interrupted;
  MeshNormals blended;
  const std::size_t count = mesh.vertices.size();
  blended.normals = paged_filled<Eigen::Vector3f>(count, Eigen::Vector3f::Zero());
  blended.sigma = paged_filled(count, 0.0f);
  blended.views = paged_filled<std::uint16_t>(count, 0);
  const auto samplers = normal_samplers(views, options.silhouette_ramp);
  if (!samplers) return samplers.error();
  blended.sample_spacing = median_spacing(*samplers);
  if (samplers->empty()) return blended;

  const double max_distance =
      options.max_distance > 0.0 ? options.max_distance : 3.0 * blended.sample_spacing;
  const PagedVector<Eigen::Vector3f> mesh_normals = vertex_normals(mesh);
  if (!report_progress(progress, 0.3, "blend normals")) return interrupted;
  const MeshGraph graph = mesh_graph(mesh);
  const std::vector<NearViews> near = views_near_groups(mesh, graph, *samplers, max_distance);
  blended.sigma_view = options.sigma_view > 0.0
                           ? options.sigma_view
                           : scatter(mesh, mesh_normals, *samplers, near, max_distance);
  PagedArray<Observers> observers(count);
  parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<NormalObservation> observations;
    Blender blend_observations(blended.sigma_view);
    for (std::size_t i = begin; i < end; ++i) {
      if (!mesh.filled.empty() && mesh.filled[i]) continue;
      observers[i] = collect(*samplers, near[i / kGroup], mesh.vertices[i],
                             mesh_normals[i].cast<double>(), max_distance, kAll, observations);
      const Blend blend = blend_observations(observations);
      if (blend.views == 0) continue;
      blended.normals[i] = blend.normal.cast<float>();
      blended.sigma[i] = static_cast<float>(standard_error(blend, blended.sigma_view));
      blended.views[i] = static_cast<std::uint16_t>(std::min(blend.views, 65535));
    }
  });
  if (options.edges)
    blend_edges(mesh, mesh_normals, *samplers, graph, near, observers, max_distance, blended);
  blended.measured = static_cast<std::size_t>(
      std::count_if(blended.views.begin(), blended.views.end(), [](auto n) { return n > 0; }));
  if (!report_progress(progress, 1.0, "blend normals")) return interrupted;
  return blended;
}

}  // namespace

Result<MeshNormals> vertex_normals_from_views(const TriangleMesh& mesh,
                                              const std::vector<RangeView>& views,
                                              const MeshNormalOptions& options,
                                              const Context& context) {
  return run_in(context, [&] { return blend_views(mesh, views, options, context.progress); });
}

}  // namespace relief::hybrid
