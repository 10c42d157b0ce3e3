#include "relief/hybrid/polish_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "hybrid/mesh/mesh_guard.h"
#include "relief/scan/context.h"
#include "relief/scan/mesh_check.h"
#include "scan/base/counter_random.h"
#include "tests/hybrid/mesh_shapes.h"
#include "tests/support/result_matchers.h"

namespace relief::hybrid {
namespace {

using testing::add_vertex_noise;
using testing::box_mesh;
using testing::exact_normals;
using testing::plane_mesh;
using testing::sphere_mesh;
using testing::torus_mesh;

PolishedMesh polished(const TriangleMesh& mesh, const MeshNormals& normals,
                      const PolishOptions& options = {}) {
  auto result = value_of(polish_mesh(mesh, normals, options));
  EXPECT_EQ(result.status, PolishStatus::kPolished) << to_string(result.status);
  return result;
}

PolishOptions in_form(MeshForm form) {
  PolishOptions options;
  options.form = form;
  return options;
}

double sphere_rms(const TriangleMesh& mesh, double radius) {
  double sum = 0.0;
  for (const auto& vertex : mesh.vertices) sum += std::pow(vertex.norm() - radius, 2);
  return std::sqrt(sum / static_cast<double>(mesh.vertices.size()));
}

// The smallest cosine of the angle by which a face turned.
double worst_turn(const TriangleMesh& before, const TriangleMesh& after) {
  double worst = 1.0;
  for (std::size_t f = 0; f < before.faces.size(); ++f)
    worst = std::min(
        worst, face_cross(before, f).normalized().dot(face_cross(after, f).stableNormalized()));
  return worst;
}

MeshNormals random_normals(const TriangleMesh& mesh, std::uint64_t seed) {
  MeshNormals normals = exact_normals(mesh, 1.0, 0.001);
  const CounterRandom random(seed, 0);
  for (std::size_t i = 0; i < normals.normals.size(); ++i)
    normals.normals[i] =
        Eigen::Vector3d(random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2))
            .normalized()
            .cast<float>();
  return normals;
}

class PolishInBothForms : public ::testing::TestWithParam<MeshForm> {};
INSTANTIATE_TEST_SUITE_P(Forms, PolishInBothForms,
                         ::testing::Values(MeshForm::kAlongNormals, MeshForm::kFull),
                         [](const auto& test) -> std::string {
                           return test.param == MeshForm::kFull ? "Full" : "AlongNormals";
                         });

TEST_P(PolishInBothForms, ANoisySphereWithTrueNormalsBecomesTheSphere) {
  const TriangleMesh sphere = sphere_mesh(30.0, 24);
  const MeshNormals normals = exact_normals(sphere, 1.3, 0.005);
  TriangleMesh noisy = sphere;
  add_vertex_noise(noisy, 0.2, 1);
  const PolishedMesh result = polished(noisy, normals, in_form(GetParam()));
  EXPECT_LT(sphere_rms(result.mesh, 30.0), 0.2 / 8.0);
  EXPECT_GT(result.rms_move, 0.15);
  EXPECT_EQ(result.with_normal, sphere.vertices.size());
  EXPECT_TRUE(check_mesh(result.mesh).watertight());
}

TEST_P(PolishInBothForms, ANoisyTorusWithTrueNormalsBecomesTheTorus) {
  const TriangleMesh torus = torus_mesh(30.0, 10.0, 160, 56);
  const MeshNormals normals = exact_normals(torus, 1.15, 0.005);
  TriangleMesh noisy = torus;
  add_vertex_noise(noisy, 0.2, 2);
  const PolishedMesh result = polished(noisy, normals, in_form(GetParam()));
  double sum = 0.0;
  for (const auto& vertex : result.mesh.vertices)
    sum += std::pow(testing::torus_distance(vertex, 30.0, 10.0), 2);
  EXPECT_LT(std::sqrt(sum / static_cast<double>(torus.vertices.size())), 0.2 / 8.0);
}

TEST_P(PolishInBothForms, ACheckerboardOnAPlaneFallsTwentyfold) {
  const TriangleMesh plane = plane_mesh(40);
  const MeshNormals normals = exact_normals(plane, 1.0, 0.03);
  TriangleMesh rough = plane;
  for (Eigen::Vector3d& vertex : rough.vertices)
    vertex.z() = std::lround(vertex.x() + vertex.y()) % 2 ? 0.1 : -0.1;
  PolishOptions options = in_form(GetParam());
  options.sigma_position = 0.1;
  options.robust_rounds = 0;
  const PolishedMesh result = polished(rough, normals, options);
  double sum = 0.0;
  for (const auto& vertex : result.mesh.vertices) sum += vertex.z() * vertex.z();
  EXPECT_LT(std::sqrt(sum / static_cast<double>(plane.vertices.size())), 0.1 / 20.0);
}

TEST_P(PolishInBothForms, TheResultTurnsAndScalesWithTheMesh) {
  TriangleMesh noisy = sphere_mesh(10.0, 8);
  MeshNormals normals = exact_normals(noisy, 1.3, 0.01);
  add_vertex_noise(noisy, 0.1, 3);
  PolishOptions options = in_form(GetParam());
  options.tolerance = 1e-9;
  const PolishedMesh result = polished(noisy, normals, options);

  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  TriangleMesh turned = noisy;
  for (auto& vertex : turned.vertices) vertex = 1000.0 * (turn * vertex);
  for (auto& quality : turned.quality) quality *= 1000.0f;
  for (auto& normal : normals.normals) normal = (turn * normal.cast<double>()).cast<float>();
  normals.sample_spacing *= 1000.0;
  const PolishedMesh other = polished(turned, normals, options);
  for (std::size_t i = 0; i < noisy.vertices.size(); ++i)
    EXPECT_LT((turn.transpose() * other.mesh.vertices[i] / 1000.0 - result.mesh.vertices[i]).norm(),
              1e-5);
}

TEST_P(PolishInBothForms, TheSameBytesOnAnyNumberOfThreads) {
  TriangleMesh noisy = sphere_mesh(30.0, 40);
  const MeshNormals normals = exact_normals(noisy, 0.8, 0.01);
  add_vertex_noise(noisy, 0.2, 4);
  const PolishOptions options = in_form(GetParam());
  const auto polished_on = [&](int threads) {
    return on_threads(threads, [&] { return polished(noisy, normals, options); });
  };
  const PolishedMesh one = polished_on(1), three = polished_on(3);
  EXPECT_EQ(std::memcmp(one.mesh.vertices.data(), three.mesh.vertices.data(),
                        one.mesh.vertices.size() * sizeof(Eigen::Vector3d)),
            0);
}

TEST_P(PolishInBothForms, WrongNormalsFlipNoFaceAndOpenNothing) {
  TriangleMesh noisy = sphere_mesh(20.0, 16);
  add_vertex_noise(noisy, 0.1, 5);
  noisy.quality.assign(noisy.vertices.size(), 10.0f);
  const auto result = value_of(polish_mesh(noisy, random_normals(noisy, 6), in_form(GetParam())));
  EXPECT_GT(worst_turn(noisy, result.mesh), 0.0);
  EXPECT_TRUE(check_mesh(result.mesh).watertight());
  EXPECT_TRUE(find_self_intersections(result.mesh).pairs.empty());
}

TEST_P(PolishInBothForms, EdgesOfABoxStaySharp) {
  const TriangleMesh box = box_mesh({20, 16, 12}, 1.0);
  const MeshNormals normals = exact_normals(box, 1.0, 0.01);
  TriangleMesh noisy = box;
  noisy.quality.assign(box.vertices.size(), 0.05f);
  const PolishedMesh kept = polished(noisy, normals, in_form(GetParam()));
  double largest = 0.0;
  for (std::size_t i = 0; i < box.vertices.size(); ++i)
    largest = std::max(largest, (kept.mesh.vertices[i] - box.vertices[i]).norm());
  EXPECT_LT(largest, 0.02);

  add_vertex_noise(noisy, 0.05, 7);
  const PolishedMesh result = polished(noisy, normals, in_form(GetParam()));
  double before = 0.0, after = 0.0;
  for (std::size_t i = 0; i < box.vertices.size(); ++i) {
    before += (noisy.vertices[i] - box.vertices[i]).squaredNorm();
    after += (result.mesh.vertices[i] - box.vertices[i]).squaredNorm();
  }
  EXPECT_LT(std::sqrt(after), 0.6 * std::sqrt(before));
}

// A cap without normals follows its border, with no step and no kink where it begins.
TEST_P(PolishInBothForms, FilledPartsMoveWithTheirBorder) {
  const TriangleMesh sphere = sphere_mesh(30.0, 24);
  MeshNormals normals = exact_normals(sphere, 1.3, 0.005);
  TriangleMesh mesh = sphere;
  add_vertex_noise(mesh, 0.2, 8);
  mesh.filled.assign(mesh.vertices.size(), 0);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (sphere.vertices[i].z() < 15.0) continue;
    mesh.vertices[i] = sphere.vertices[i];
    mesh.filled[i] = 1;
    mesh.quality[i] = static_cast<float>(sphere.vertices[i].z() - 14.0);
    normals.normals[i].setZero();
    normals.views[i] = 0;
  }
  const PolishedMesh result = polished(mesh, normals, in_form(GetParam()));
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3d outwards =
        (mesh.corner(f, 0) + mesh.corner(f, 1) + mesh.corner(f, 2)).normalized();
    if (outwards.z() > 0.5) {
      EXPECT_GT(face_cross(result.mesh, f).normalized().dot(outwards), std::cos(0.2));
    }
  }
  EXPECT_LT(sphere_rms(result.mesh, 30.0), 0.2 / 5.0);
}

TEST(PolishMesh, ExactMeshesStayAsTheyAre) {
  TriangleMesh sphere = sphere_mesh(30.0, 16);
  sphere.quality.assign(sphere.vertices.size(), 0.1f);
  const PolishedMesh result = polished(sphere, exact_normals(sphere, 2.0, 0.01));
  EXPECT_LT(result.max_move, 0.01);
  EXPECT_EQ(result.damped, 0u);
}

TEST(PolishMesh, WithoutNormalsOrErrorsTheMeshIsAsGiven) {
  TriangleMesh sphere = sphere_mesh(30.0, 4);
  MeshNormals normals = exact_normals(sphere, 5.0, 0.01);
  const auto no_errors = value_of(polish_mesh(sphere, normals));
  EXPECT_EQ(no_errors.status, PolishStatus::kMissingUncertainty);
  normals.views.assign(sphere.vertices.size(), 0);
  const auto no_normals = value_of(polish_mesh(sphere, normals));
  EXPECT_EQ(no_normals.status, PolishStatus::kNoNormals);
  EXPECT_EQ(no_normals.mesh.vertices, sphere.vertices);
}

TEST(PolishMesh, BadInputIsNamed) {
  TriangleMesh sphere = sphere_mesh(30.0, 4);
  sphere.quality.assign(sphere.vertices.size(), 0.1f);
  const MeshNormals normals = exact_normals(sphere, 5.0, 0.01);
  PolishOptions options;
  options.tangential = 0.0;
  EXPECT_THAT(polish_mesh(sphere, normals, options), HasError("tangential"));
  EXPECT_THAT(polish_mesh(sphere_mesh(30.0, 5), normals), HasError());
  sphere.vertices[3].x() = std::nan("");
  EXPECT_THAT(polish_mesh(sphere, normals), HasError());
}

TEST(PolishMesh, StopsOnRequest) {
  TriangleMesh sphere = sphere_mesh(30.0, 4);
  sphere.quality.assign(sphere.vertices.size(), 0.1f);
  const auto result = polish_mesh(sphere, exact_normals(sphere, 5.0, 0.01), {},
                                  {.progress = [](double, std::string_view) { return false; }});
  EXPECT_THAT(result, HasError(ErrorKind::kInterrupted));
}

TEST(GuardedMove, SoundMovesAreLeftAlone) {
  const TriangleMesh sphere = sphere_mesh(10.0, 8);
  std::vector<Eigen::Vector3d> outwards;
  for (const Eigen::Vector3d& vertex : sphere.vertices) outwards.push_back(0.1 * vertex);
  const GuardedMove move = guarded_move(sphere, outwards);
  EXPECT_EQ(move.damped, 0u);
  for (std::size_t i = 0; i < sphere.vertices.size(); ++i)
    EXPECT_LT((move.vertices[i] - 1.1 * sphere.vertices[i]).norm(), 1e-12);
}

// Both sides of a thin plate would pass through each other.
TEST(GuardedMove, TheSidesOfAThinPlateDoNotPassThroughEachOther) {
  const TriangleMesh plate = box_mesh({20, 20, 0.2}, 1.0);
  std::vector<Eigen::Vector3d> moves(plate.vertices.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < plate.vertices.size(); ++i) {
    const Eigen::Vector3d& vertex = plate.vertices[i];
    if (vertex.head<2>().norm() < 5.0) moves[i].z() = vertex.z() > 0.0 ? -0.15 : 0.15;
  }
  const GuardedMove move = guarded_move(plate, moves);
  EXPECT_GT(move.damped, 0u);
  TriangleMesh moved = plate;
  moved.vertices = move.vertices;
  EXPECT_TRUE(find_self_intersections(moved).pairs.empty());
  EXPECT_TRUE(check_mesh(moved).watertight());
}

// Spikes as sharp as the faces allow, pushed about at random by more than their size.
TEST(GuardedMove, SharpShapesNeitherFlipNorIntersect) {
  TriangleMesh spikes = sphere_mesh(10.0, 10);
  for (std::size_t i = 0; i < spikes.vertices.size(); i += 7) spikes.vertices[i] *= 1.4;
  ASSERT_TRUE(find_self_intersections(spikes).pairs.empty());
  const CounterRandom random(9, 0);
  std::vector<Eigen::Vector3d> moves(spikes.vertices.size());
  for (std::size_t k = 0; k < 3 * moves.size(); ++k)
    moves[k / 3][static_cast<Eigen::Index>(k % 3)] = 1.5 * random.normal(k);
  const GuardedMove move = guarded_move(spikes, moves);
  EXPECT_GT(move.damped, 100u);
  TriangleMesh moved = spikes;
  moved.vertices = move.vertices;
  EXPECT_GT(worst_turn(spikes, moved), 0.0);
  EXPECT_TRUE(find_self_intersections(moved).pairs.empty());
  EXPECT_TRUE(check_mesh(moved).watertight());
}

}  // namespace
}  // namespace relief::hybrid
