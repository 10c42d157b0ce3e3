#include "reconstruction/cache/option_hash.h"

#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "fusion/units/merge_units.h"
#include "scan/units/input_hash.h"

namespace relief {
namespace {

template <typename Options>
using Change = std::function<void(Options&)>;

template <typename Options>
std::string key_after(const Change<Options>& change) {
  Options options;
  change(options);
  return unit_key("test", options).hash;
}

// Every change gives a key of its own.
template <typename Options>
void expect_all_differ(const std::vector<Change<Options>>& changes) {
  std::set<std::string> keys{unit_key("test", Options{}).hash};
  for (std::size_t i = 0; i < changes.size(); ++i)
    EXPECT_TRUE(keys.insert(key_after(changes[i])).second) << "change " << i;
}

TEST(OptionHash, ChangesWithEveryOptionOfAligning) {
  using Options = registration::AlignOptions;
  using namespace registration;
  expect_all_differ<Options>({
      [](auto& o) { o.surface.normals = NormalSource::kMeasured; },
      [](auto& o) { o.surface.normal_radius = 3; },
      [](auto& o) { o.surface.boundary_margin = 3; },
      [](auto& o) { o.surface.final_margin = 2; },
      [](auto& o) { o.surface.normal_signal = false; },
      [](auto& o) { o.surface.neighbour_index = true; },
      [](auto& o) { o.starting_poses.given = GivenPoses::kTrust; },
      [](auto& o) { o.starting_poses.search = false; },
      [](auto& o) { o.starting_poses.association = Association::kNearest; },
      [](auto& o) { o.starting_poses.min_overlap = 0.2; },
      [](auto& o) { o.starting_poses.max_free_space_violation = 0.03; },
      [](auto& o) { o.refinement.association = Association::kNearest; },
      [](auto& o) { o.refinement.correspondences = 1501; },
      [](auto& o) { o.refinement.levels = 4; },
      [](auto& o) { o.refinement.search_distance = 1.0; },
      [](auto& o) { o.refinement.final_samples = 7; },
      [](auto& o) { o.refinement.max_normal_angle_deg = 41.0; },
      [](auto& o) { o.refinement.min_overlap = 0.05; },
      [](auto& o) { o.refinement.min_correspondences = 51; },
      [](auto& o) { o.refinement.tolerance = 0.02; },
      [](auto& o) { o.refinement.max_iterations = 41; },
  });
}

TEST(OptionHash, ChangesWithEveryOptionOfRefining) {
  using Options = hybrid::RefineOptions;
  expect_all_differ<Options>({
      [](auto& o) { o.stencil = hybrid::Stencil::kPaperCentral; },
      [](auto& o) { o.bias = hybrid::BiasModel::kNone; },
      [](auto& o) { o.sigma_position = 0.0; },
      [](auto& o) { o.sigma_position = 1.0; },
      [](auto& o) { o.sigma_normal = 1.0; },
      [](auto& o) { o.lambda = 1.0; },
      [](auto& o) { o.sigma_bias_step = 1.0; },
      [](auto& o) { o.smoothing_scale = 1.0; },
      [](auto& o) { o.robust_rounds = 6; },
      [](auto& o) { o.solver = hybrid::Solver::kCholesky; },
      [](auto& o) { o.tolerance = 2e-6; },
      [](auto& o) { o.max_iterations = 501; },
      [](auto& o) { o.deviation = false; },
      [](auto& o) { o.discontinuities.grazing_angle_deg = 9.0; },
      [](auto& o) { o.discontinuities.free_step = 3.0; },
  });
}

TEST(OptionHash, ChangesWithEveryOptionOfMerging) {
  using Options = fusion::MergeOptions;
  expect_all_differ<Options>({
      [](auto& o) { o.voxel_size = 1.0; },
      [](auto& o) { o.truncation = 1.0; },
      [](auto& o) { o.silhouette_ramp = 7; },
      [](auto& o) { o.keep_holes = true; },
      [](auto& o) { o.largest_fill = 1.0; },
      [](auto& o) { o.keep_components = true; },
      [](auto& o) { o.keep_contradicted = true; },
      [](auto& o) { o.keep_handles = true; },
  });
}

TEST(OptionHash, ChangesWithEveryOptionOfPolishing) {
  using Options = hybrid::PolishOptions;
  expect_all_differ<Options>({
      [](auto& o) { o.form = hybrid::MeshForm::kFull; },
      [](auto& o) { o.sigma_position = 1.0; },
      [](auto& o) { o.sigma_normal = 1.0; },
      [](auto& o) { o.tangential = 2.0; },
      [](auto& o) { o.robust_rounds = 4; },
      [](auto& o) { o.tolerance = 2e-3; },
      [](auto& o) { o.max_iterations = 501; },
      [](auto& o) { o.normals.max_distance = 1.0; },
      [](auto& o) { o.normals.silhouette_ramp = 7; },
      [](auto& o) { o.normals.sigma_view = 1.0; },
      [](auto& o) { o.normals.edges = false; },
  });
}

TEST(OptionHash, ChangesWithTheOptionOfComparing) {
  using Options = reconstruction::CrossViewOptions;
  expect_all_differ<Options>({[](auto& o) { o.correct = false; }});
}

RangeView small_view() {
  RangeView view;
  view.name = "v";
  view.camera = Camera::pinhole(2, 2, {100.0, 100.0, 1.0, 1.0});
  view.range = {2, 2, 5.0};
  return view;
}

TEST(InputHash, ChangesWithEverythingAViewMeasured) {
  const std::vector<Change<RangeView>> changes{
      [](auto& v) { v.range(1, 1) = kNoSample; },
      [](auto& v) { v.range(0, 1) = 5.0000000000000009; },
      [](auto& v) {
        v.normals = {2, 2, Eigen::Vector3f::UnitZ()};
      },
      [](auto& v) {
        v.confidence = {2, 2, 1.0f};
      },
      [](auto& v) {
        v.deviation = {2, 2, 1.0f};
      },
      [](auto& v) {
        v.colours = {2, 2, Colour{}};
      },
      [](auto& v) {
        v.camera = Camera::pinhole(2, 2, {100.0, 100.0, 1.0, 1.1});
      },
      [](auto& v) {
        v.camera = Camera::pinhole_gl(2, 2, {100.0, 100.0, 1.0, 1.0});
      },
      [](auto& v) {
        v.camera = Camera::orthographic(2, 2, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
      },
      [](auto& v) {
        v.camera = Camera::orthographic(2, 2, {0, 0, 0}, {1, 0, 1e-18}, {0, 1, 0}, {0, 0, 1});
      },
      [](auto& v) { v.camera = Camera::ray_table(Grid<Ray>(2, 2), std::nullopt); },
      [](auto& v) { v.camera = Camera::ray_table(Grid<Ray>(2, 2), RationalProjection()); },
      [](auto& v) {
        v.camera = Camera::spherical(SphericalProjection::even(2, 2, 0.0, 0.1, 0.0, 0.1));
      },
      [](auto& v) {
        v.camera = Camera::spherical(SphericalProjection::even(2, 2, 0.0, 0.1, 0.0, 0.2));
      },
  };
  std::set<std::string> keys{hash_of_samples(small_view())};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    RangeView view = small_view();
    changes[i](view);
    EXPECT_TRUE(keys.insert(hash_of_samples(view)).second) << "change " << i;
  }
}

TEST(InputHash, KeepsNameAndPoseApartFromWhatWasMeasured) {
  for (const Change<RangeView>& change :
       std::vector<Change<RangeView>>{[](auto& v) { v.name = "w"; },
                                      [](auto& v) { v.world_from_view.translation().x() = 1.0; },
                                      [](auto& v) { v.pose = PoseKind::kKnown; }}) {
    RangeView view = small_view();
    change(view);
    EXPECT_EQ(hash_of_samples(view), hash_of_samples(small_view()));
    EXPECT_NE(hash_of_view(view), hash_of_view(small_view()));
  }
}

TEST(ContentHash, IsTheStandardOne) {
  EXPECT_EQ(ContentHash().add_bytes("abc", 3).hex(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(ContentHash, CountsLengths) {
  EXPECT_NE(unit_key("test", "ab", "c").hash, unit_key("test", "a", "bc").hash);
  EXPECT_NE(unit_key("test", std::vector<double>{}, std::vector<double>{1.0}).hash,
            unit_key("test", std::vector<double>{1.0}, std::vector<double>{}).hash);
  EXPECT_NE(unit_key("test", 1).hash, unit_key("other", 1).hash);
  EXPECT_EQ(program_identity().size(), 64u);
}

}  // namespace
}  // namespace relief
