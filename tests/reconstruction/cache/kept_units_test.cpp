// Reconstructions with a store of finished units: the bytes of those without one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "reconstruction/cache/result_codec_private.h"
#include "relief/reconstruction/reconstruct.h"
#include "relief/simulation/simulate.h"
#include "scan/units/input_hash.h"
#include "tests/support/memory_store.h"

namespace relief::reconstruction {
namespace {

using ::testing::ElementsAre;
using testing::MemoryStore;
using ::testing::Pair;

std::vector<RangeView> scans(std::uint64_t seed = 1) {
  simulation::SimulationOptions options;
  options.views = 8;
  options.width = options.height = 80;
  options.mesh_divisions = 0;
  options.seed = seed;
  return simulation::simulate(options).value().scans.views;
}

registration::Alignment without_times(registration::Alignment alignment) {
  for (registration::SolverSummary& solve : alignment.solves) solve.seconds = 0.0;
  return alignment;
}

// Everything but times.
std::string bytes_of(const Reconstruction& result) {
  ContentHash hash;
  for (const RangeView& view : result.views) hash.add(hash_of_view(view));
  hash.add(result.model.mesh, encode_unit(result.model.check), encode_unit(result.model.merged));
  hash.add(encode_unit(without_times(result.first_alignment)), encode_unit(result.consistency));
  for (hybrid::RefineSummary summary : result.refinements) {
    summary.seconds = 0.0;
    hash.add(encode_unit(summary));
  }
  if (result.second_alignment)
    hash.add(encode_unit(without_times(result.second_alignment->alignment)));
  hash.add(result.model.polished.has_value());
  if (result.model.polished) hash.add(result.model.polished->rms_move);
  return hash.hex();
}

std::string run(const std::vector<RangeView>& views, UnitStore* store,
                const ReconstructionOptions& options = {}, std::uint64_t seed = 1) {
  return bytes_of(reconstruct(views, options, {.seed = seed, .store = store}).value());
}

const std::string& without_store() {
  static const std::string bytes = run(scans(), nullptr);
  return bytes;
}

// A store that holds all units of the scans.
const MemoryStore& full() {
  static MemoryStore store;
  static const std::string bytes = run(scans(), &store);
  EXPECT_EQ(bytes, without_store());
  return store;
}

TEST(KeptUnits, AreOneForEachPieceOfWork) {
  EXPECT_THAT(full().found, ::testing::IsEmpty());
  EXPECT_THAT(full().computed,
              ElementsAre(Pair("align", 1), Pair("align_again", 1), Pair("calibrate", 1),
                          Pair("compare", 1), Pair("field", 2), Pair("joint", 2), Pair("merge", 1),
                          Pair("polish", 1), Pair("refine", 8)));
}

TEST(KeptUnits, GiveTheBytesOfComputing) {
  MemoryStore store = full();
  store.start_again();
  EXPECT_EQ(on_threads(1, [&] { return run(scans(), &store); }), without_store());
  EXPECT_THAT(store.computed, ::testing::IsEmpty());
  EXPECT_EQ(store.found["refine"], 8);
}

// Any part of the units may be there.
TEST(KeptUnits, MayBeMissingOrDamaged) {
  for (std::size_t skip = 0; skip < 3; ++skip) {
    MemoryStore store = full();
    store.start_again();
    std::size_t at = 0;
    for (auto unit = store.units.begin(); unit != store.units.end(); ++at) {
      if (at % 3 == skip) {
        unit = store.units.erase(unit);
        continue;
      }
      if (at % 3 == (skip + 1) % 3) unit->second.resize(unit->second.size() - 1);
      ++unit;
    }
    EXPECT_EQ(run(scans(), &store), without_store());
    EXPECT_FALSE(store.computed.empty());
  }
}

TEST(KeptUnits, OfFinishedViewsOutliveAnInterruption) {
  MemoryStore store;
  ReconstructionCallbacks callbacks;
  callbacks.progress = [&](Stage stage, double, std::string_view) {
    return stage != Stage::kRefine || store.computed["refine"] < 3;
  };
  ASSERT_FALSE(reconstruct(scans(), {}, {.threads = 1, .store = &store}, callbacks));
  EXPECT_EQ(store.computed["refine"], 3);
  store.start_again();
  EXPECT_EQ(run(scans(), &store), without_store());
  EXPECT_EQ(store.found["refine"], 3);
  EXPECT_EQ(store.computed["refine"], 5);
  EXPECT_EQ(store.found["align"], 1);
}

// Poses that stay and no comparison: nothing else depends on the view that was replaced.
TEST(KeptUnits, OfOtherViewsStayWhenOneIsReplaced) {
  std::vector<RangeView> views = scans();
  for (RangeView& view : views) view.pose = PoseKind::kKnown;
  ReconstructionOptions options;
  options.contradicted = ContradictedRanges::kKeep;
  MemoryStore store;
  run(views, &store, options);
  store.start_again();
  views[3].range(48, 48) *= 1.0001;
  const std::string resumed = run(views, &store, options);
  EXPECT_EQ(store.found["refine"], 7);
  EXPECT_EQ(store.computed["refine"], 1);
  EXPECT_EQ(store.computed["merge"], 1);
  EXPECT_EQ(resumed, run(views, nullptr, options));
}

TEST(KeptUnits, OfRefiningDoNotDependOnPoseAndName) {
  MemoryStore store = full();
  store.start_again();
  std::vector<RangeView> views = scans();
  for (RangeView& view : views) view.name += "-renamed";
  ReconstructionOptions options;
  EXPECT_EQ(run(views, &store, options), run(views, nullptr, options));
  EXPECT_EQ(store.computed["align"], 1);
  EXPECT_EQ(store.found["refine"], 8);
}

// As after an interruption while poses are looked for.
TEST(KeptUnits, OfPairsAreTakenWherePosesAreFoundByShape) {
  std::vector<RangeView> views = scans();
  for (std::size_t i = 0; i < 3; ++i) {
    views[i].pose = PoseKind::kAbsent;
    views[i].world_from_view = RigidMotion::Identity();
  }
  MemoryStore store;
  const std::string bytes = run(views, &store);
  const int pairs = store.computed["pair"];
  EXPECT_GT(pairs, 3);
  store.forget("align");
  store.forget("joint");
  for (int forgotten = 0; forgotten < 2; ++forgotten) {
    const auto pair = std::find_if(store.units.begin(), store.units.end(), [&](const auto& unit) {
      return store.kinds[unit.first] == "pair";
    });
    store.units.erase(pair);
  }
  store.start_again();
  EXPECT_EQ(run(views, &store), bytes);
  EXPECT_EQ(store.found["pair"], pairs - 2);
  EXPECT_EQ(store.computed["pair"], 2);
  EXPECT_EQ(store.computed["refine"], 0);
}

TEST(KeptUnits, OfOtherOptionsAreNotTaken) {
  MemoryStore store = full();
  store.start_again();
  ReconstructionOptions options;
  options.model.merge.voxel_size = 3.0;
  EXPECT_EQ(run(scans(), &store, options, 7), run(scans(), nullptr, options, 7));
  EXPECT_EQ(store.found["align"], 1);
  EXPECT_EQ(store.computed["refine"], 8);
  EXPECT_EQ(store.computed["merge"], 1);
}

TEST(KeptUnits, AreNeverErrors) {
  MemoryStore store;
  EXPECT_FALSE(reconstruct({}, {}, {.store = &store}));
  EXPECT_TRUE(store.units.empty());
}

}  // namespace
}  // namespace relief::reconstruction
