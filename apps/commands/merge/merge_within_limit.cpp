#include "apps/commands/merge/merge_within_limit.h"

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "apps/console/console.h"
#include "apps/console/progress_display.h"
#include "reconstruction/memory_check.h"
#include "relief/io/project_io.h"
#include "relief/scan/static_background.h"
#include "scan/base/parallel.h"
#include "scan/io/project/loading/settled_views.h"
#include "scan/io/project/loading/view_loader.h"

namespace relief {

namespace {

using SharedView = std::shared_ptr<const RangeView>;

// The views of a project, read one at a time.
class ProjectViews {
 public:
  ProjectViews(std::vector<ViewSpec> specs, std::vector<ChosenConvention> conventions,
               const StaticBackground& background)
      : specs_(std::move(specs)), conventions_(std::move(conventions)), background_(background) {}

  fusion::ViewSource source() {
    return {specs_.size(), [this](std::size_t i) { return load(i); }};
  }
  bool any_normals() const { return any_normals_; }

 private:
  Result<SharedView> load(std::size_t i) {
    auto loaded = load_view(specs_[i]);
    if (!loaded) return loaded.error();
    set_normals(*loaded, conventions_[i]);
    remove_background(background_.masks[i], loaded->view);
    if (i >= read_) {  // notes once
      for (const std::string& note : loaded->notes) Console::info(note);
      read_ = i + 1;
    }
    any_normals_ |= loaded->view.has_normals();
    return SharedView(std::make_shared<const RangeView>(std::move(loaded->view)));
  }

  std::vector<ViewSpec> specs_;
  std::vector<ChosenConvention> conventions_;
  const StaticBackground& background_;
  std::size_t read_ = 0;
  bool any_normals_ = false;
};

void drop_damaged(std::vector<ViewSpec>& specs) {
  std::erase_if(specs, [](const ViewSpec& spec) {
    const auto loaded = load_view(spec);
    if (!loaded) Console::info("a view is left out: " + loaded.error().message);
    return !loaded;
  });
}

// Views are read one at a time, and only their ranges kept.
Result<StaticBackground> find_background(const ProjectInput& input,
                                         const std::vector<ViewSpec>& specs) {
  StaticBackground none;
  none.masks.resize(specs.size());
  if (!input.look_for_background || input.keep_background) return none;
  auto found = find_static_background(specs.size(), [&](std::size_t i) -> Result<SharedView> {
    auto loaded = load_view(specs[i]);
    if (!loaded) return loaded.error();
    RangeView ranges;
    ranges.camera = loaded->view.camera;
    ranges.range = std::move(loaded->view.range);
    ranges.world_from_view = loaded->view.world_from_view;
    ranges.pose = loaded->view.pose;
    return SharedView(std::make_shared<const RangeView>(std::move(ranges)));
  });
  if (found)
    for (const std::string& line : describe(*found, true)) Console::info(line);
  return found;
}

}  // namespace

Result<reconstruction::Model> merge_within_limit(const ProjectInput& input,
                                                 const reconstruction::ModelOptions& options,
                                                 const Context& context, std::string& unit) {
  auto spec = read_project_spec(input.path, input.options);
  if (!spec) return spec.error();
  unit = spec->unit;
  for (const std::string& note : spec->notes) Console::info(note);
  if (input.options.skip_damaged) drop_damaged(spec->views);
  auto conventions = settle_views(spec->views);
  if (!conventions) return conventions.error();
  for (const std::string& note : conventions->notes) Console::info(note);
  auto background = find_background(input, spec->views);
  if (!background) return background.error();
  release_freed_memory();
  ProjectViews views(std::move(spec->views), std::move(conventions->views), *background);
  ScanProject project;
  const auto load = [&](const fusion::MergeResult& mesh) -> Result<const std::vector<RangeView>*> {
    if (views.any_normals()) {
      const auto room = reconstruction::check_memory_to_polish(mesh.mesh.vertices.size());
      if (!room) return room.error();
    }
    auto all =
        read_project(input.path, input.options, context.with_progress(console_progress("read")));
    if (!all) return all.error();
    project = std::move(*all);
    remove_background(*background, project.views);
    return &project.views;
  };
  return reconstruction::build_model_from_source(views.source(), load, options, context,
                                                 console_stage_progress());
}

}  // namespace relief
