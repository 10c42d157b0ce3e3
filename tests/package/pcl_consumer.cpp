// Aligns two clouds by relief's registration in place of PCL's.
#include <cstdio>

#include <relief/interop/pcl_conversion.h>
#include <relief/interop/pcl_registration.h>

#include "relief/simulation/simulate.h"

using Cloud = pcl::PointCloud<pcl::PointNormal>;

int main() {
  relief::simulation::SimulationOptions options;
  options.views = 8;
  options.width = options.height = 96;
  options.mesh_divisions = 0;
  const auto simulation = relief::simulation::simulate(options);
  if (!simulation) return 1;
  const auto& views = simulation->truth.views;
  const Cloud::Ptr target(new Cloud(relief::interop::to_pcl<pcl::PointNormal>(views[0])));
  const Cloud::Ptr source(new Cloud(relief::interop::to_pcl<pcl::PointNormal>(views[1])));
  const relief::RigidMotion truth = views[0].world_from_view.inverse() * views[1].world_from_view;

  const pcl::Registration<pcl::PointNormal, pcl::PointNormal>::Ptr registration(
      new relief::interop::RangeViewRegistration);
  registration->setInputSource(source);
  registration->setInputTarget(target);
  Eigen::Matrix4f guess = truth.matrix().cast<float>();
  guess(0, 3) += 1.0f;
  Cloud moved;
  registration->align(moved, guess);
  const Eigen::Matrix4f found = registration->getFinalTransformation();
  const double error = (found.cast<double>() - truth.matrix()).topRightCorner<3, 1>().norm();
  std::printf("pcl_consumer: %s, %.3f from the truth, fitness score %.3g\n",
              registration->hasConverged() ? "converged" : "not converged", error,
              registration->getFitnessScore(1.0));
  return registration->hasConverged() && error < 0.5 ? 0 : 1;
}
