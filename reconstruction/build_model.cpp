#include "relief/reconstruction/build_model.h"

#include <string>
#include <utility>
#include <vector>

#include "reconstruction/cache/stage_units.h"
#include "relief/scan/progress.h"
#include "scan/base/parallel.h"
#include "scan/units/input_hash.h"

namespace relief::reconstruction {

namespace {

Progress progress_of(const StageProgress& progress, Stage stage) {
  if (!progress) return {};
  return [&progress, stage](double fraction, std::string_view step) {
    return progress(stage, fraction, step);
  };
}

fusion::MergeOptions merge_options_of(const ModelOptions& options) {
  fusion::MergeOptions merge = options.merge;
  merge.threads = options.threads;
  return merge;
}

// Where finished meshes are kept, and what they depend on.
struct KeptMeshes {
  UnitStore* store = nullptr;
  std::vector<std::string> view_hashes;
};

// Moving the vertices changes the check of the mesh, and what was closed must still be. After an
// error the model is as it was.
Result<void> polish(const std::vector<RangeView>& views, const ModelOptions& options,
                    const StageProgress& progress, const KeptMeshes& kept, Model& model) {
  hybrid::PolishOptions polish = *options.polish;
  polish.threads = options.threads;
  if (!(polish.normals.max_distance > 0.0)) polish.normals.max_distance = model.merged.truncation;
  auto polished = polish_or_find(kept.store, kept.view_hashes, model.mesh, views, polish,
                                 progress_of(progress, Stage::kPolish));
  if (!polished) return polished.error();
  model.polished = *polished;
  if (polished->rounds == 0) return {};
  MeshCheck check = check_mesh(polished->mesh);
  if (model.check.watertight() && !check.watertight()) {
    model.polished.reset();
    return Error{ErrorKind::kUnsolvable, "polished, the surface would be no closed manifold"};
  }
  model.mesh = std::move(polished->mesh);
  model.check = std::move(check);
  return {};
}

Result<void> decimate(const fusion::DecimationOptions& options, Model& model) {
  if (options.faces == 0 && !(options.max_error > 0.0)) return {};
  auto decimated = fusion::decimate_mesh(model.mesh, options);
  if (!decimated) return decimated.error();
  model.faces_before_decimation = model.mesh.faces.size();
  model.mesh = std::move(decimated->mesh);
  model.check = decimated->check;
  return {};
}

Result<Model> finish(Result<fusion::MergeResult> merged, const LoadAllViews& all,
                     const ModelOptions& options, const StageProgress& progress,
                     const KeptMeshes& kept) {
  if (!merged) return merged.error();
  const std::vector<RangeView>* views = nullptr;
  if (options.polish) {
    release_freed_memory();  // What merging took.
    const auto loaded = all(*merged);
    if (!loaded) return loaded.error();
    views = *loaded;
  }
  Model model;
  model.mesh = std::move(merged->mesh);
  model.check = std::move(merged->check);
  model.merged = std::move(*merged);
  if (options.polish) {
    if (const auto done = polish(*views, options, progress, kept, model); !done) {
      if (done.error().kind != ErrorKind::kUnsolvable) return done.error();
      model.merged.notes.push_back("the model is not polished: " + done.error().message);
    }
  }
  if (auto done = decimate(options.decimation, model); !done) return done.error();
  return model;
}

}  // namespace

std::string_view to_string(Stage stage) {
  switch (stage) {
    case Stage::kAlign:
      return "align";
    case Stage::kCompare:
      return "compare";
    case Stage::kRefine:
      return "refine";
    case Stage::kAlignAgain:
      return "align again";
    case Stage::kMerge:
      return "merge";
    case Stage::kPolish:
      return "polish";
  }
  return "";
}

Result<Model> build_model(const std::vector<RangeView>& views, const ModelOptions& options,
                          const StageProgress& progress, UnitStore* store) {
  const LoadAllViews all = [&](const fusion::MergeResult&) {
    return Result<const std::vector<RangeView>*>(&views);
  };
  KeptMeshes kept{store, {}};
  if (store != nullptr) kept.view_hashes = hashes_of_views(views, options.threads);
  return finish(merge_or_find(store, kept.view_hashes, views, merge_options_of(options),
                              progress_of(progress, Stage::kMerge)),
                all, options, progress, kept);
}

Result<Model> build_model_from_source(const fusion::ViewSource& views, const LoadAllViews& all,
                                      const ModelOptions& options, const StageProgress& progress) {
  return finish(fusion::merge_from_source(views, merge_options_of(options),
                                          progress_of(progress, Stage::kMerge)),
                all, options, progress, {});
}

}  // namespace relief::reconstruction
