#include "registration/posegraph/refinement/pair_information.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <Eigen/Dense>

#include "registration/pairwise/robust.h"
#include "scan/base/cell_key.h"
#include "scan/base/linear_algebra.h"
#include "scan/base/robust_scales.h"

namespace relief::registration {

namespace {

// Samples whose correspondences are held at a time. Bounds the memory, changes no result.
constexpr std::size_t kBatch = 4096;

// The cube of a lattice that holds `p`.
std::uint64_t patch_of(const Eigen::Vector3d& p, double edge) {
  const auto cell = (p / edge).array().floor().cast<std::int64_t>().eval();
  return cell_key(cell.z(), cell.y(), cell.x());
}

class Accumulator {
 public:
  Accumulator(PairInformation& sum, double patch) : sum_(sum), patch_(patch) {}

  // A point and normal relative to the centre, its residual and 1 / sigma with the confidence.
  void add(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double distance,
           double scale) {
    RigidTangent j;
    j << point.cross(normal), normal;
    const double r = scale * distance;
    const double w = losses_.add(r * r);
    const RigidTangent score = (w * scale * r) * j;
    sum_.information.noalias() += (w * scale * scale) * j * j.transpose();
    sum_.score += score;
    ++sum_.count;
    if (patch_ > 0.0) add_to_patch(patch_of(point, patch_), score);
  }

  void finish() {
    sum_.losses = losses_.sum();
    std::sort(sum_.patches.begin(), sum_.patches.end(),
              [](const auto& a, const auto& b) { return a.patch < b.patch; });
  }

 private:
  void add_to_patch(std::uint64_t key, const RigidTangent& score) {
    const auto [place, is_new] = place_of_.try_emplace(key, sum_.patches.size());
    if (is_new) sum_.patches.push_back({key, RigidTangent::Zero()});
    sum_.patches[place->second].score += score;
  }

  PairInformation& sum_;
  double patch_;
  CauchyLosses losses_{kCauchyScale};
  std::unordered_map<std::uint64_t, std::size_t> place_of_;
};

}  // namespace

std::vector<std::uint32_t> in_grid_order(const ViewSurface& view, std::size_t count) {
  const auto inner = view.samples(), edge = view.edge_samples();
  const std::size_t total = inner.size() + edge.size();
  const std::size_t wanted = count > 0 ? std::min(count, total) : total;
  const std::size_t of_edge = total > 0 ? wanted * edge.size() / total : 0;
  std::vector<std::uint32_t> samples;
  samples.reserve(wanted);
  const auto append = [&](std::span<const std::uint32_t> part, std::size_t first) {
    samples.insert(samples.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(first));
  };
  append(inner, wanted - of_edge);
  append(edge, of_edge);
  std::sort(samples.begin(), samples.end());
  return samples;
}

double pair_deviation(const ViewSurface& source, const ViewSurface& target,
                      const RigidMotion& target_from_source, const CorrespondenceOptions& search) {
  return find_correspondences(source, target, target_from_source, search).sigma;
}

PairInformation pair_information(const ViewSurface& source, const ViewSurface& target,
                                 const RigidMotion& world_from_source,
                                 const RigidMotion& world_from_target,
                                 std::span<const std::uint32_t> samples,
                                 const PairInformationOptions& options) {
  PairInformation sum;
  const RigidMotion target_from_source = world_from_target.inverse() * world_from_source;
  RigidMotion centred_from_target = world_from_target;
  centred_from_target.translation() -= options.centre;

  const double sigma = options.sigma > 0.0
                           ? options.sigma
                           : pair_deviation(source, target, target_from_source, options.search);
  if (sigma <= 0.0) return sum;
  CorrespondenceOptions everywhere = options.search;
  everywhere.part = SurfacePart::kWhole;
  Accumulator accumulator(sum, options.patch);
  std::vector<Correspondence> batch;
  for (std::size_t begin = 0; begin < samples.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, samples.size() - begin);
    batch.clear();
    append_correspondences(source, target, target_from_source, samples.subspan(begin, count),
                           everywhere, batch);
    for (const auto& c : batch) {
      if (std::abs(c.distance) > options.search.max_sigmas * sigma) continue;
      accumulator.add(centred_from_target * c.target.point,
                      centred_from_target.linear() * c.target.normal, c.distance,
                      std::sqrt(c.weight) / sigma);
    }
  }
  accumulator.finish();
  return sum;
}

void add_normals(const NormalMatchesSpan& normals, const RigidMotion& world_from_target,
                 const Eigen::Vector3d& centre, const RigidTangent& since, PairInformation& sum) {
  if (normals.items.empty()) return;
  RigidMotion centred_from_target = world_from_target;
  centred_from_target.translation() -= centre;
  const double precision = 1.0 / (normals.effective_sigma * normals.effective_sigma);
  Matrix6d information = Matrix6d::Zero();
  RigidTangent score = RigidTangent::Zero();
  double losses = 0.0;
  for (const NormalMatch& in_target : normals.items) {
    const NormalMatch match = in_target.moved(centred_from_target);
    for (int k = 0; k < 2; ++k) {
      const auto j = [&](const Eigen::Matrix<double, 3, 2>& gradient) -> RigidTangent {
        return match.derivative(k, gradient, Eigen::Vector3d::Zero());
      };
      const double weight =
          precision * match.weight * cauchy_weight(match.residual[k] / normals.sigma, kCauchyScale);
      // Products of both views' gradients: the noise of either alone would count as relief.
      const RigidTangent s = j(match.source_gradient), t = j(match.target_gradient);
      information += 0.5 * weight * (s * t.transpose() + t * s.transpose());
      score += weight * match.residual[k] * j(match.gradient());
      losses += weight * match.residual[k] * match.residual[k];
    }
  }
  sum.information += information;
  sum.independent += information;
  sum.losses += losses + since.dot(2.0 * score + information * since);
  sum.score += score + information * since;
}

void ignore_motions(const std::vector<DegenerateDirection>& motions, const Eigen::Vector3d& centre,
                    PairInformation& sum) {
  if (motions.empty() || sum.count == 0) return;
  // Rotations count by the lever that they have.
  const Vector6d diagonal = sum.information.diagonal();
  const double lever = diagonal.head<3>().sum() / std::max(diagonal.tail<3>().sum(), 1e-300);
  const Matrix6d rest = without_motions(motions, centre, std::max(lever, 1e-300));
  sum.information = rest.transpose() * sum.information * rest;
  sum.independent = rest.transpose() * sum.independent * rest;
  sum.score = rest.transpose() * sum.score;
  for (PatchScore& patch : sum.patches) patch.score = rest.transpose() * patch.score;
}

}  // namespace relief::registration
