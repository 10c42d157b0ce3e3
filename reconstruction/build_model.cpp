#include "relief/reconstruction/build_model.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "reconstruction/memory_check.h"
#include "reconstruction/stage_context.h"
#include "scan/base/parallel.h"
#include "scan/units/input_hash.h"

namespace relief::reconstruction {

namespace {

// Views without normals polish nothing.
Result<void> check_room_to_polish(const std::vector<RangeView>& views, const TriangleMesh& mesh) {
  const bool any_normals = std::any_of(views.begin(), views.end(),
                                       [](const RangeView& view) { return view.has_normals(); });
  return any_normals ? check_memory_to_polish(mesh.vertices.size()) : Result<void>();
}

// The units of a model depend on these.
using ViewHashes = std::vector<std::string>;

// Moving the vertices changes the check of the mesh, and what was closed must still be. After an
// error the model is as it was.
Result<void> polish(const std::vector<RangeView>& views, const ModelOptions& options,
                    const StageContext& context, const ViewHashes& hashes, Model& model) {
  hybrid::PolishOptions polish = *options.polish;
  if (!(polish.normals.max_distance > 0.0)) polish.normals.max_distance = model.merged.truncation;
  auto polished = polish_or_find(hashes, model.mesh, views, polish, context.of(Stage::kPolish),
                                 context.missing_unit_error(Stage::kPolish));
  if (!polished) return polished.error();
  model.polished = *polished;
  if (polished->rounds == 0) return {};
  MeshCheck check = check_moved_vertices(polished->mesh, model.check);
  if (model.check.watertight() && !check.watertight()) {
    model.polished.reset();
    return Error{ErrorKind::kUnsolvable, "polished, the surface would be no closed manifold"};
  }
  model.mesh = std::move(polished->mesh);
  model.check = std::move(check);
  return {};
}

// Says why more faces are left than were wanted.
void note_faces_left(const fusion::DecimationOptions& options, Model& model) {
  const std::size_t left = model.mesh.faces.size();
  if (options.faces == 0 || left <= options.faces) return;
  std::string note = "warning: " + std::to_string(options.faces) + " faces were wanted and " +
                     std::to_string(left) +
                     " are left: with fewer the surface would change its topology (" +
                     std::to_string(model.check.components) + " components, genus " +
                     std::to_string(model.check.genus) + ") or fold over";
  if (options.max_error > 0.0) note += ", or move by more than the decimation error";
  if (model.check.boundary_edges > 0) note += ", and the borders of holes stay as they are";
  model.merged.notes.push_back(std::move(note));
}

Result<void> decimate(const fusion::DecimationOptions& options, Model& model) {
  if (options.faces == 0 && !(options.max_error > 0.0)) return {};
  auto decimated = fusion::decimate_mesh(model.mesh, options);
  if (!decimated) return decimated.error();
  model.faces_before_decimation = model.mesh.faces.size();
  model.mesh = std::move(decimated->mesh);
  model.check = decimated->check;
  note_faces_left(options, model);
  return {};
}

Result<Model> finish(Result<fusion::MergeResult> merged, const LoadAllViews& all,
                     const ModelOptions& options, const StageContext& context,
                     const ViewHashes& hashes) {
  if (!merged) return merged.error();
  const std::vector<RangeView>* views = nullptr;
  if (options.polish) {
    release_freed_memory();  // What merging took.
    const auto loaded = all(*merged);
    if (!loaded) return loaded.error();
    views = *loaded;
    if (const auto room = check_room_to_polish(*views, merged->mesh); !room) return room.error();
  }
  Model model;
  model.mesh = std::move(merged->mesh);
  model.check = std::move(merged->check);
  model.merged = std::move(*merged);
  if (options.polish) {
    if (const auto done = polish(*views, options, context, hashes, model); !done) {
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
    case Stage::kCalibrate:
      return "calibrate";
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

Result<Model> build_model_in(const StageContext& stages, const std::vector<RangeView>& views,
                             const ModelOptions& options) {
  const LoadAllViews all = [&](const fusion::MergeResult&) {
    return Result<const std::vector<RangeView>*>(&views);
  };
  return run_in(stages.context, [&] {
    const ViewHashes hashes = stages.context.store ? hashes_of_views(views) : ViewHashes();
    return finish(merge_or_find(hashes, views, options.merge, stages.of(Stage::kMerge),
                                stages.missing_unit_error(Stage::kMerge)),
                  all, options, stages, hashes);
  });
}

Result<Model> build_model(const std::vector<RangeView>& views, const ModelOptions& options,
                          const Context& context, const StageProgress& progress) {
  return build_model_in({context, progress}, views, options);
}

Result<Model> build_model_from_source(const fusion::ViewSource& views, const LoadAllViews& all,
                                      const ModelOptions& options, const Context& context,
                                      const StageProgress& progress) {
  return run_in(context, [&] {
    Context without_store = context;
    without_store.store = nullptr;
    const StageContext stages{without_store, progress};
    return finish(fusion::merge_from_source(views, options.merge, stages.of(Stage::kMerge)), all,
                  options, stages, {});
  });
}

}  // namespace relief::reconstruction
