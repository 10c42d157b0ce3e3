// Errors of aligned poses against the Cramer-Rao bound of the noise and against the covariances
// that the alignment reports, over simulated scans of the built-in object.
//   cmake --preset bench && cmake --build --preset bench &&
//   build/bench/bench/relief_pose_accuracy [RUNS [VIEWS [SIZE [NOISE [SAMPLES]]]]]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include <Eigen/Dense>

#include "registration/posegraph/joint/joint_refinement.h"
#include "relief/simulation/simulate.h"
#include "scan/evaluation/poses/pose_bound.h"

namespace relief {
namespace {

struct Settings {
  int runs = 100, views = 12, size = 256;
  double noise = 0.3;  // Of the range [sample spacings].
  int samples = 0;     // Of the last steps; 0: all.
};

std::vector<RangeView> exact_ring(const Settings& settings, double& spacing,
                                  Eigen::Vector3d& centre) {
  const simulation::SimulationObject object = simulation::built_in_simulation_object(0);
  centre = object.centre;
  simulation::SimulationOptions options;
  options.views = settings.views;
  options.width = options.height = settings.size;
  options.mesh_divisions = 0;
  const auto simulated = simulation::simulate(object, options);
  if (!simulated) std::abort();
  spacing = simulated->spacing;
  return simulated->truth.views;
}

std::vector<RangeView> noisy(std::vector<RangeView> views, double sigma, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, sigma);
  for (auto& view : views) {
    view.normals = {};  // The bound is that of the ranges.
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        if (view.has_sample(u, v))
          view.range(u, v) += normal(generator) / view.camera.ray(u, v).direction.norm();
  }
  return views;
}

std::vector<RigidMotion> disturbed(const std::vector<RangeView>& views, double spacing,
                                   std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  std::vector<RigidMotion> poses;
  for (const auto& view : views) {
    RigidTangent tangent;
    for (double& value : tangent) value = normal(generator);
    tangent.head<3>() *= 0.005;
    tangent.tail<3>() *= spacing;
    poses.push_back(poses.empty() ? view.world_from_view
                                  : motion_from_tangent(tangent) * view.world_from_view);
  }
  return poses;
}

// The error of a pose as tangent about the world point `c`, which the view sees as `c_view`.
RigidTangent error_about(const RigidMotion& estimate, const RigidMotion& truth,
                         const Eigen::Vector3d& c_view) {
  const Eigen::AngleAxisd turn(estimate.linear() * truth.linear().transpose());
  RigidTangent error;
  error << turn.angle() * turn.axis(), estimate * c_view - truth * c_view;
  return error;
}

Eigen::MatrixXd covariance_but_of_the_first(const registration::PoseCovariance& covariance,
                                            std::size_t views) {
  Eigen::MatrixXd all(6 * (views - 1), 6 * (views - 1));
  for (std::size_t a = 1; a < views; ++a)
    for (std::size_t b = 1; b < views; ++b)
      all.block<6, 6>(static_cast<Eigen::Index>(6 * (a - 1)),
                      static_cast<Eigen::Index>(6 * (b - 1))) = covariance.between(a, b);
  return all;
}

struct Sums {
  double bound = 0.0, whitened = 0.0, diagonal = 0.0, displacement = 0.0, seconds = 0.0;
  int iterations = 0;
  Eigen::VectorXd error;  // Sum of the errors of all runs, about the centre.
};

void measure_run(const std::vector<RangeView>& truth, const Eigen::MatrixXd& information,
                 const Eigen::Vector3d& centre, double spacing, const Settings& settings,
                 std::uint32_t seed, Sums& sums) {
  const auto views = noisy(truth, settings.noise * spacing, seed);
  std::vector<registration::ViewSurface> surfaces;
  for (const auto& view : views) surfaces.emplace_back(view);
  std::vector<registration::ViewRole> roles(views.size(), registration::ViewRole::kFree);
  roles[0] = registration::ViewRole::kFixed;
  registration::JointRefinementOptions options;
  options.final_samples = settings.samples;
  const auto start = std::chrono::steady_clock::now();
  const auto refined =
      registration::refine_jointly(surfaces, disturbed(views, spacing, seed), roles, options);
  sums.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  sums.iterations += refined->iterations;

  const auto free = static_cast<Eigen::Index>(6 * (views.size() - 1));
  Eigen::VectorXd about_centre(free), about_views(free);
  double displacement = 0.0;
  for (std::size_t i = 1; i < views.size(); ++i) {
    const RigidMotion &estimate = refined->world_from_view[i], &exact = truth[i].world_from_view;
    const auto row = static_cast<Eigen::Index>(6 * (i - 1));
    about_centre.segment<6>(row) = error_about(estimate, exact, exact.inverse() * centre);
    about_views.segment<6>(row) = error_about(estimate, exact, surfaces[i].centre());
    displacement += about_views.segment<3>(row + 3).norm();
  }
  const Eigen::MatrixXd covariance =
      covariance_but_of_the_first(refined->joint_covariance, views.size());
  const auto d = static_cast<double>(free);
  sums.bound += about_centre.dot(information.bottomRightCorner(free, free) * about_centre) / d;
  sums.whitened += about_views.dot(covariance.ldlt().solve(about_views)) / d;
  sums.diagonal += (about_views.array().square() / covariance.diagonal().array()).mean();
  sums.error = sums.error.size() == 0 ? about_centre : Eigen::VectorXd(sums.error + about_centre);
  sums.displacement += displacement / static_cast<double>(views.size() - 1) / spacing;
}

int run(const Settings& settings) {
  double spacing = 0.0;
  Eigen::Vector3d centre;
  const auto truth = exact_ring(settings, spacing, centre);
  const Eigen::MatrixXd information =
      evaluation::pose_information(truth, settings.noise * spacing, centre);
  Sums sums;
  for (int i = 0; i < settings.runs; ++i)
    measure_run(truth, information, centre, spacing, settings, static_cast<std::uint32_t>(i + 1),
                sums);
  const double n = settings.runs;
  // The mean error has a part of 1 / n of the scatter in it.
  const auto free = sums.error.size();
  const double mean_squared =
      sums.error.dot(information.bottomRightCorner(free, free) * sums.error) / (n * n) /
      static_cast<double>(free);
  const double total = sums.bound / n;
  const double systematic = n > 1 ? std::max(0.0, (n * mean_squared - total) / (n - 1)) : 0.0;
  std::printf(
      "%d runs, %d views of %dx%d, noise %.2f spacings\n"
      "error / Cramer-Rao bound                    %.3f\n"
      "  of which the same in all runs             %.3f\n"
      "squared error / reported variance           %.3f\n"
      "the same, whitened by the whole covariance  %.3f\n"
      "mean displacement of the views' centres     %.4f spacings\n"
      "renewals of the correspondences             %.1f\n"
      "seconds per run                             %.2f\n",
      settings.runs, settings.views, settings.size, settings.size, settings.noise, std::sqrt(total),
      std::sqrt(systematic), sums.diagonal / n, sums.whitened / n, sums.displacement / n,
      sums.iterations / n, sums.seconds / n);
  return 0;
}

}  // namespace
}  // namespace relief

int main(int argc, char** argv) {
  relief::Settings settings;
  if (argc > 1) settings.runs = std::atoi(argv[1]);
  if (argc > 2) settings.views = std::atoi(argv[2]);
  if (argc > 3) settings.size = std::atoi(argv[3]);
  if (argc > 4) settings.noise = std::atof(argv[4]);
  if (argc > 5) settings.samples = std::atoi(argv[5]);
  return relief::run(settings);
}
