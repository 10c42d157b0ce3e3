#pragma once

#include <memory>
#include <optional>
#include <string>

#include <pcl/point_types.h>
#include <pcl/registration/registration.h>

#include "relief/registration/align_pair.h"
#include "relief/scan/camera.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief::interop {

/// relief's pairwise alignment (align_pair) as a registration method of PCL: use it wherever a
/// pcl::Registration is expected, as in place of pcl::IterativeClosestPointWithNormals.
///
/// Both clouds are organized: points in the frame of their sensor, NaN where there is no sample.
/// Their normals may be absent; they are used where both clouds have them. Viewpoints must
/// be rigid motions and are not used further: the initial guess and the result map coordinates of
/// the source to coordinates of the target. Where indices are set, only these samples of the source
/// count.
///
/// What PCL's settings mean here:
///  - setMaxCorrespondenceDistance: IcpOptions::search_distance; infinite (the default): automatic;
///  - setMaximumIterations: IcpOptions::max_iterations, of each level;
///  - correspondence and transformation estimation, rejectors, RANSAC and the epsilons: nothing.
///
/// hasConverged() is true when the views overlap, also when an iteration limit ended the search;
/// getIcpResult() tells which. getFitnessScore() is PCL's; points that are NaN do not count.
///
/// Clouds that cannot be aligned (not organized, empty, of another size than their camera) do not
/// end the program: hasConverged() is then false, getFinalTransformation() the guess, and
/// getErrorMessage() tells why. Where the clouds do not overlap, getFinalTransformation() is the
/// last pose that had enough correspondences.
class RangeViewRegistration : public pcl::Registration<pcl::PointNormal, pcl::PointNormal> {
 public:
  using Ptr = pcl::shared_ptr<RangeViewRegistration>;
  using ConstPtr = pcl::shared_ptr<const RangeViewRegistration>;

  RangeViewRegistration();
  ~RangeViewRegistration() override;

  void setInputTarget(const PointCloudTargetConstPtr& cloud) override;

  /// The rays of the clouds; without a camera they are found from the points (from_pcl).
  void setSourceCamera(const std::optional<Camera>& camera);
  void setTargetCamera(const std::optional<Camera>& camera);

  /// All options but those for which PCL has a setting (see above), which stay as they are.
  void setIcpOptions(const registration::IcpOptions& options);
  const registration::IcpOptions& getIcpOptions() const { return options_; }

  /// Of the last call of align: its covariance, overlap and degenerate directions, among others.
  const registration::IcpResult& getIcpResult() const { return result_; }
  /// Why the last call of align gave no result; empty when it gave one.
  const std::string& getErrorMessage() const { return error_; }

 protected:
  void computeTransformation(PointCloudSource& output, const Matrix4& guess) override;

 private:
  struct Target;

  Result<registration::IcpResult> alignTo(const RigidMotion& target_from_source);
  Result<void> prepareTarget();
  PointCloudSource usedSource() const;
  registration::IcpOptions effectiveOptions() const;

  registration::IcpOptions options_;
  registration::IcpResult result_;
  std::string error_;
  std::optional<Camera> source_camera_, target_camera_;
  std::unique_ptr<Target> target_view_;  // Kept from one source to the next.
};

}  // namespace relief::interop
