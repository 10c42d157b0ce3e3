#include "relief/interop/pcl_registration.h"

#include <cmath>
#include <limits>
#include <utility>

#include <pcl/common/transforms.h>

#include "registration/pairwise/icp.h"
#include "registration/surface/view_surface.h"
#include "relief/interop/pcl_conversion.h"

namespace relief::interop {

namespace {

// Organized clouds have points that are NaN: PCL's own tree gives them a neighbour, or asserts.
class FinitePointsTree : public pcl::search::KdTree<pcl::PointNormal> {
 public:
  int nearestKSearch(const pcl::PointNormal& point, int k, pcl::Indices& indices,
                     std::vector<float>& squared_distances) const override {
    if (point.getVector3fMap().allFinite())
      return KdTree::nearestKSearch(point, k, indices, squared_distances);
    indices.assign(static_cast<std::size_t>(k), 0);
    squared_distances.assign(static_cast<std::size_t>(k), std::numeric_limits<float>::infinity());
    return 0;
  }
};

// The rounding of 32-bit floats removed. kBadInput when it is no rigid motion.
Result<RigidMotion> rigid_motion(const Eigen::Matrix4f& matrix) {
  return rigid_motion_from_matrix(matrix.cast<double>(), "the initial guess");
}

registration::ViewSurfaceOptions surface_options(const registration::IcpOptions& options) {
  registration::ViewSurfaceOptions surface;
  surface.neighbour_index = options.association == registration::Association::kNearest;
  return surface;
}

}  // namespace

struct RangeViewRegistration::Target {
  Target(RangeView given, const registration::ViewSurfaceOptions& options)
      : view(std::move(given)), surface(view, options) {}
  RangeView view;
  registration::ViewSurface surface;
};

RangeViewRegistration::RangeViewRegistration() {
  reg_name_ = "RangeViewRegistration";
  max_iterations_ = options_.max_iterations;
  corr_dist_threshold_ = std::numeric_limits<double>::infinity();
  setSearchMethodTarget(KdTreePtr(new FinitePointsTree));
}

RangeViewRegistration::~RangeViewRegistration() = default;

void RangeViewRegistration::setInputTarget(const PointCloudTargetConstPtr& cloud) {
  target_view_.reset();
  Registration::setInputTarget(cloud);
}

void RangeViewRegistration::setIcpOptions(const registration::IcpOptions& options) {
  options_ = options;
  target_view_.reset();
}

void RangeViewRegistration::setSourceCamera(const std::optional<Camera>& camera) {
  source_camera_ = camera;
}

void RangeViewRegistration::setTargetCamera(const std::optional<Camera>& camera) {
  target_camera_ = camera;
  target_view_.reset();
}

void RangeViewRegistration::computeTransformation(PointCloudSource& output, const Matrix4& guess) {
  const auto start = rigid_motion(guess);
  auto found = start ? alignTo(*start) : Result<registration::IcpResult>(start.error());
  error_ = found ? std::string() : found.error().message;
  result_ = found ? std::move(*found) : registration::IcpResult();
  converged_ = found && result_.usable();
  if (found && !converged_) error_ = "the clouds do not overlap near the initial guess";
  nr_iterations_ = result_.iterations;
  final_transformation_ =
      found ? Matrix4(result_.target_from_source.matrix().cast<float>()) : guess;
  transformation_ = final_transformation_;
  pcl::transformPointCloudWithNormals(PointCloudSource(output), output, final_transformation_);
}

Result<registration::IcpResult> RangeViewRegistration::alignTo(
    const RigidMotion& target_from_source) {
  if (auto prepared = prepareTarget(); !prepared) return prepared.error();
  const auto source = from_pcl(usedSource(), source_camera_);
  if (!source) return Error{source.error().kind, "the source: " + source.error().message};
  const bool both_project = source->camera.can_project() && target_view_->view.camera.can_project();
  if (options_.association == registration::Association::kProjective && !both_project)
    return Error{ErrorKind::kBadInput,
                 "the camera of a cloud has no projection of points to pixels; use the association "
                 "kAuto or kNearest"};
  return registration::align_pair(registration::ViewSurface(*source, surface_options(options_)),
                                  target_view_->surface, target_from_source, effectiveOptions());
}

Result<void> RangeViewRegistration::prepareTarget() {
  if (target_view_) return {};
  auto view = from_pcl(*target_, target_camera_);
  if (!view) return Error{view.error().kind, "the target: " + view.error().message};
  target_view_ = std::make_unique<Target>(std::move(*view), surface_options(options_));
  return {};
}

// The source without the samples that are not among the indices.
RangeViewRegistration::PointCloudSource RangeViewRegistration::usedSource() const {
  PointCloudSource used = *input_;
  if (indices_->size() == used.size()) return used;
  std::vector<bool> wanted(used.size(), false);
  for (const auto index : *indices_) wanted[static_cast<std::size_t>(index)] = true;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (!wanted[i]) used[i].getVector3fMap().setConstant(std::numeric_limits<float>::quiet_NaN());
  return used;
}

registration::IcpOptions RangeViewRegistration::effectiveOptions() const {
  registration::IcpOptions options = options_;
  options.max_iterations = max_iterations_;
  options.search_distance = corr_dist_threshold_ < std::sqrt(std::numeric_limits<double>::max())
                                ? corr_dist_threshold_
                                : 0.0;
  return options;
}

}  // namespace relief::interop
