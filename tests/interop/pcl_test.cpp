// The one test file that includes PCL: its headers take long to compile.
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/common/transforms.h>
#include <pcl/console/print.h>
#include <pcl/registration/icp.h>

#include "registration/pairwise/icp.h"
#include "relief/interop/pcl_conversion.h"
#include "relief/interop/pcl_registration.h"
#include "tests/interop/coloured_view.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/geometry_matchers.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"

namespace relief::interop {
namespace {

using testing::cameras_of_all_models;
using testing::coloured_view;
using testing::expect_same_mesh;
using testing::expect_same_samples;
using ::testing::HasSubstr;
using testing::mesh_with_attributes;

using Cloud = pcl::PointCloud<pcl::PointNormal>;
using ColouredCloud = pcl::PointCloud<pcl::PointXYZRGBNormal>;
using Registration = pcl::Registration<pcl::PointNormal, pcl::PointNormal>;

constexpr double kFloat = 2e-6;  // A few roundings of 32-bit floats.

class PclConversionOfViews : public ::testing::TestWithParam<Camera> {};
INSTANTIATE_TEST_SUITE_P(Cameras, PclConversionOfViews,
                         ::testing::ValuesIn(cameras_of_all_models()), testing::PrintedName());

TEST_P(PclConversionOfViews, GivesThemBack) {
  const RangeView view = coloured_view(GetParam());
  const auto found = value_of(from_pcl(to_pcl<pcl::PointXYZRGBNormal>(view), GetParam()));
  expect_same_samples(found, view, kFloat);
  EXPECT_TRUE(
      std::equal(found.colours.begin(), found.colours.end(), view.colours.begin(),
                 [&](const Colour& a, const Colour& b) { return a == b || a == Colour{}; }));
  EXPECT_EQ(found.colours(24, 18), view.colours(24, 18));
}

TEST(PclConversion, FindsTheCamera) {
  const RangeView view = coloured_view(cameras_of_all_models()[0]);
  const auto found = value_of(from_pcl(to_pcl<pcl::PointNormal>(view)));
  expect_same_samples(found, view, 1e-5);
  ASSERT_EQ(found.camera.model(), Camera::Model::kPinhole);
  EXPECT_NEAR(found.camera.intrinsics().fx, 60.0, 1e-3);
  EXPECT_NEAR(found.camera.intrinsics().cy, 17.5, 1e-3);
  EXPECT_TRUE(found.colours.empty());
}

TEST(PclConversion, TheViewpointPutsPointsIntoTheWorld) {
  const RangeView view = coloured_view(cameras_of_all_models()[0]);
  const Cloud cloud = to_pcl<pcl::PointNormal>(view);
  EXPECT_EQ(cloud.width, 48u);
  EXPECT_EQ(cloud.height, 36u);
  EXPECT_FALSE(cloud.is_dense);
  EXPECT_FALSE(pcl::isXYZFinite(cloud.at(0, 0)));
  const Eigen::Vector3f in_world = cloud.sensor_orientation_ * cloud.at(20, 18).getVector3fMap() +
                                   cloud.sensor_origin_.head<3>();
  EXPECT_NEAR((in_world.cast<double>() - view.world_from_view * view.point(20, 18)).norm(), 0,
              1e-5);
}

TEST(PclConversion, ViewsWithoutNormalsOrColoursStayWithout) {
  RangeView view = coloured_view(cameras_of_all_models()[0]);
  view.normals = {};
  view.colours = {};
  view.world_from_view.setIdentity();
  const auto found = value_of(from_pcl(to_pcl<pcl::PointXYZRGBNormal>(view)));
  EXPECT_FALSE(found.has_normals());
  EXPECT_TRUE(found.colours.empty());
  EXPECT_EQ(found.pose, PoseKind::kAbsent);
}

TEST(PclConversion, NamesWhatIsNoView) {
  EXPECT_THAT(from_pcl(Cloud()), HasError("no points"));
  EXPECT_THAT(from_pcl(Cloud(100, 1)), HasError("not organized"));
  Cloud cloud = to_pcl<pcl::PointNormal>(coloured_view(cameras_of_all_models()[0]));
  EXPECT_THAT(from_pcl(cloud, cameras_of_all_models()[2]), HasError("camera is 40x40"));
  cloud.sensor_orientation_.coeffs().setZero();
  EXPECT_THAT(from_pcl(cloud), HasError("viewpoint"));
  for (auto& point : cloud) point.x = std::numeric_limits<float>::quiet_NaN();
  cloud.sensor_orientation_.setIdentity();
  EXPECT_THAT(from_pcl(cloud), HasError("finite"));
}

TEST(PclConversion, GivesMeshesBack) {
  const TriangleMesh mesh = mesh_with_attributes();
  const auto found = value_of(from_pcl(to_pcl(mesh)));
  expect_same_mesh(found, mesh, 1e-6);
  TriangleMesh bare;
  bare.vertices = mesh.vertices;
  bare.faces = mesh.faces;
  expect_same_mesh(*from_pcl(to_pcl(bare)), bare, 1e-6);
}

TEST(PclConversion, MeshesAreReadableByPcl) {
  const TriangleMesh mesh = mesh_with_attributes();
  ColouredCloud cloud;
  pcl::fromPCLPointCloud2(to_pcl(mesh).cloud, cloud);
  ASSERT_EQ(cloud.size(), 4u);
  EXPECT_FLOAT_EQ(cloud[3].z, 1.7f);
  EXPECT_EQ(cloud[3].b, 255);
  EXPECT_EQ(Eigen::Vector3f(cloud[3].getNormalVector3fMap()), mesh.normals[3]);
}

TEST(PclConversion, NamesWhatIsNoMesh) {
  pcl::PolygonMesh mesh = to_pcl(mesh_with_attributes());
  mesh.polygons[2].vertices[1] = 9;
  EXPECT_THAT(from_pcl(mesh), HasError("polygon 2: vertex index 9 of 4"));
  mesh.polygons[2].vertices.resize(2);
  EXPECT_THAT(from_pcl(mesh), HasError("2 corners"));
  mesh.polygons[2].vertices = {0, 1, 2, 3};
  EXPECT_EQ(from_pcl(mesh)->faces.size(), 5u);
  mesh.cloud.fields[0].name = "a";
  EXPECT_THAT(from_pcl(mesh), HasError("x, y and z"));
  mesh.cloud.data.resize(10);
  EXPECT_THAT(from_pcl(mesh), HasError("less data"));
}

// Two neighbouring views of a bumpy object with noise, and a guess that is wrong by three degrees.
class PclRegistration : public ::testing::Test {
 protected:
  PclRegistration() {
    const auto moved = testing::perturbed(views_, Eigen::Vector3d::Zero(), 0.05, 2.0);
    guess_ = (moved[0].world_from_view.inverse() * moved[1].world_from_view).cast<float>().matrix();
  }

  RigidMotion truth() const {
    return views_[0].world_from_view.inverse() * views_[1].world_from_view;
  }
  // Mean distance of the source's points from where they are in truth [sample spacings].
  double error(const Eigen::Matrix4f& found) const {
    const RigidMotion motion(found.cast<double>());
    double sum = 0.0, count = 0.0;
    for (const auto& p : points_of(views_[1])) {
      if (!p.allFinite()) continue;
      sum += (motion * p - truth() * p).norm();
      count += 1.0;
    }
    return sum / count / sample_spacing(views_[0]);
  }
  // As a PCL program does it, whatever the method.
  Eigen::Matrix4f align(Registration& method) {
    method.setInputSource(source_);
    method.setInputTarget(target_);
    method.align(output_, guess_);
    EXPECT_TRUE(method.hasConverged());
    return method.getFinalTransformation();
  }

  std::vector<RangeView> views_ = testing::ring_of_views({.pixels = 160});
  Cloud::Ptr target_{new Cloud(to_pcl<pcl::PointNormal>(views_[0]))};
  Cloud::Ptr source_{new Cloud(to_pcl<pcl::PointNormal>(views_[1]))};
  Eigen::Matrix4f guess_;
  Cloud output_;
};

// PCL's own methods want no points that are NaN.
Cloud::Ptr finite_points(const Cloud& cloud) {
  Cloud::Ptr finite(new Cloud);
  for (const auto& point : cloud)
    if (pcl::isXYZFinite(point)) finite->push_back(point);
  return finite;
}

TEST_F(PclRegistration, FindsTheMotionInPlaceOfPclsIcp) {
  const Registration::Ptr ours(new RangeViewRegistration);
  const double our_error = error(align(*ours));
  EXPECT_GT(error(guess_), 1.0);
  EXPECT_LT(our_error, 0.1);

  target_ = finite_points(*target_);
  source_ = finite_points(*source_);
  const Registration::Ptr icp(new pcl::IterativeClosestPoint<pcl::PointNormal, pcl::PointNormal>);
  icp->setMaxCorrespondenceDistance(5.0);
  icp->setMaximumIterations(50);
  EXPECT_LT(our_error, error(align(*icp)));
}

TEST_F(PclRegistration, GivesTheSameAsTheDirectCall) {
  RangeViewRegistration ours;
  ours.setSourceCamera(views_[1].camera);
  ours.setTargetCamera(views_[0].camera);
  const Eigen::Matrix4f found = align(ours);
  const registration::ViewSurface target(views_[0]), source(views_[1]);
  const registration::IcpResult direct = registration::align_pair(
      source, target, RigidMotion(guess_.cast<double>()), registration::IcpOptions());
  EXPECT_LT((found.cast<double>() - direct.target_from_source.matrix()).cwiseAbs().maxCoeff(),
            1e-3);
  EXPECT_NEAR(ours.getIcpResult().overlap, direct.overlap, 0.01);
  EXPECT_GT(ours.getIcpResult().covariance.trace(), 0.0);
}

TEST_F(PclRegistration, AssociatesAsTheOptionsSay) {
  RangeViewRegistration ours;
  const Eigen::Matrix4f projective = align(ours);
  registration::IcpOptions options;
  options.association = registration::Association::kNearest;
  ours.setIcpOptions(options);
  EXPECT_LT((align(ours) - projective).cwiseAbs().maxCoeff(), 0.1f);
  EXPECT_TRUE(ours.hasConverged());
}

TEST_F(PclRegistration, MovesTheOutputAndScoresTheFit) {
  RangeViewRegistration ours;
  const Eigen::Matrix4f found = align(ours);
  ASSERT_EQ(output_.size(), source_->size());
  EXPECT_EQ(output_.height, source_->height);
  const Eigen::Vector4f moved = found * source_->at(80, 80).getVector4fMap();
  EXPECT_NEAR((output_.at(80, 80).getVector4fMap() - moved).norm(), 0.0f, 1e-4f);
  const Eigen::Vector3f turned =
      found.topLeftCorner<3, 3>() * source_->at(80, 80).getNormalVector3fMap();
  EXPECT_NEAR((output_.at(80, 80).getNormalVector3fMap() - turned).norm(), 0.0f, 1e-4f);
  EXPECT_LT(ours.getFitnessScore(5.0), 1.0);
  EXPECT_LT(ours.getFitnessScore(), 1e6) << "points that are NaN do not count";
}

TEST_F(PclRegistration, UsesIndicesAndKeepsTheTarget) {
  RangeViewRegistration ours;
  align(ours);
  const pcl::IndicesPtr upper(new pcl::Indices);
  for (std::size_t i = 0; i < source_->size() * 3 / 4; ++i)
    upper->push_back(static_cast<pcl::index_t>(i));
  const registration::IcpResult whole = ours.getIcpResult();
  ours.setIndices(upper);
  ours.align(output_, guess_);
  EXPECT_EQ(output_.size(), upper->size());
  EXPECT_LT(error(ours.getFinalTransformation()), 0.3);
  EXPECT_NE(ours.getIcpResult().target_from_source.matrix(), whole.target_from_source.matrix());
}

TEST_F(PclRegistration, PclsSettingsSetTheOptions) {
  RangeViewRegistration ours;
  ours.setMaximumIterations(1);
  align(ours);
  EXPECT_EQ(ours.getIcpResult().termination, registration::IcpTermination::kIterationLimit);
  ours.setMaximumIterations(40);
  ours.setMaxCorrespondenceDistance(20.0);
  EXPECT_LT(error(align(ours)), 0.1);
}

TEST_F(PclRegistration, ViewsThatDoNotOverlapDoNotConverge) {
  RangeViewRegistration ours;
  align(ours);
  guess_(0, 3) += 1000.0f;
  ours.align(output_, guess_);
  EXPECT_FALSE(ours.hasConverged());
  EXPECT_EQ(ours.getIcpResult().termination, registration::IcpTermination::kNoOverlap);
  EXPECT_THAT(ours.getErrorMessage(), HasSubstr("overlap"));
}

TEST_F(PclRegistration, SaysWhyCloudsCannotBeAligned) {
  RangeViewRegistration ours;
  ours.setInputTarget(target_);
  ours.setInputSource(finite_points(*source_));
  ours.align(output_, guess_);
  EXPECT_FALSE(ours.hasConverged());
  EXPECT_EQ(ours.getFinalTransformation(), guess_);
  EXPECT_THAT(ours.getErrorMessage(), HasSubstr("the source: the points are not organized"));

  ours.setInputSource(source_);
  ours.setInputTarget(finite_points(*target_));
  ours.align(output_, guess_);
  EXPECT_FALSE(ours.hasConverged());
  EXPECT_THAT(ours.getErrorMessage(), HasSubstr("the target: the points are not organized"));

  ours.setInputTarget(target_);
  ours.align(output_, 2.0f * guess_);
  EXPECT_FALSE(ours.hasConverged());
  ours.align(output_, guess_);
  EXPECT_TRUE(ours.hasConverged());
  EXPECT_EQ(ours.getErrorMessage(), "");
}

TEST(PclRegistrationInput, EmptyCloudsAreNotTaken) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  RangeViewRegistration ours;
  ours.setInputSource(Cloud::Ptr(new Cloud));
  ours.setInputTarget(Cloud::Ptr(new Cloud));
  Cloud output;
  ours.align(output);
  EXPECT_FALSE(ours.hasConverged());
}

}  // namespace
}  // namespace relief::interop
