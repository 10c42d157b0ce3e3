#include "apps/reports/comparison/run_comparison.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "scan/evaluation/base/angles.h"

namespace relief {

namespace {

// Options that say where files are and how the work is done, not what is computed.
bool changes_result(const std::string& option) {
  static const std::set<std::string> kOthers{
      "--cache-limit",    "--export",   "--fresh",   "--json",           "--memory",
      "--output",         "--quiet",    "--report",  "--require-inputs", "--threads",
      "--no-html-report", "--progress", "--verbose", "--time-limit",     "--viewer-faces"};
  return !kOthers.contains(option);
}

RunSide side_of(const RunFolder& run) {
  return {.folder = run.folder.string(),
          .version = run.report.text("/relief"),
          .program = run.report.text("/run/program"),
          .input = run.report.text("/run/input"),
          .finished = run.finished,
          .missing = run.missing};
}

std::optional<std::string> given(const ReportFigures& report, const std::string& name) {
  const Json* options = report.find("/run/options");
  if (!options || !options->is_object() || !options->contains(name)) return std::nullopt;
  const Json& value = (*options)[name];
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::vector<ComparedOption> compare_options(const ReportFigures& a, const ReportFigures& b) {
  std::set<std::string> names;
  for (const ReportFigures* report : {&a, &b})
    if (const Json* options = report->find("/run/options"); options && options->is_object())
      for (const auto& [name, value] : options->items()) names.insert(name);
  std::vector<ComparedOption> differing;
  for (const std::string& name : names) {
    ComparedOption option{name, given(a, name), given(b, name), changes_result(name)};
    if (option.a != option.b) differing.push_back(std::move(option));
  }
  // Those that matter come first.
  std::stable_partition(differing.begin(), differing.end(),
                        [](const ComparedOption& option) { return option.changes_result; });
  return differing;
}

// Of all sections that list views.
std::vector<std::string> view_names(const RunFolder& a, const RunFolder& b) {
  std::vector<std::string> names;
  std::set<std::string> known;
  for (const RunFolder* run : {&a, &b})
    for (const std::string& place : {std::string("/run/inputs"), run->report.alignment() + "/views",
                                     std::string("/refine/views")})
      for (const std::string& entry : run->report.entries(place))
        if (std::string name = run->report.text(entry + "/name");
            !name.empty() && known.insert(name).second)
          names.push_back(std::move(name));
  return names;
}

InputState compare_input(const RunFolder& a, const RunFolder& b, const std::string& name) {
  if (a.report.size("/run/inputs") == 0 || b.report.size("/run/inputs") == 0)
    return InputState::kNotRecorded;
  const std::string in_a = a.report.entry_of("/run/inputs", name),
                    in_b = b.report.entry_of("/run/inputs", name);
  if (in_b.empty()) return InputState::kOnlyInA;
  if (in_a.empty()) return InputState::kOnlyInB;
  const auto same = [&](const char* key) {
    return a.report.text(in_a + key) == b.report.text(in_b + key);
  };
  if (!same("/samples_sha256")) return InputState::kOtherSamples;
  return same("/pose_sha256") ? InputState::kSame : InputState::kOtherPose;
}

ViewOutcome outcome_of(const ReportFigures& report, const std::string& name) {
  ViewOutcome outcome;
  if (const std::string entry = report.entry_of(report.alignment() + "/views", name);
      !entry.empty())
    outcome.alignment = report.text(entry + "/status");
  if (const std::string entry = report.entry_of("/refine/views", name); !entry.empty()) {
    outcome.refinement = report.text(entry + "/status");
    outcome.rms_change = report.number(entry + "/rms_change");
    outcome.median_deviation = report.number(entry + "/median_deviation");
  }
  return outcome;
}

std::vector<ComparedView> compare_views(const RunFolder& a, const RunFolder& b) {
  std::vector<ComparedView> views;
  for (const std::string& name : view_names(a, b))
    views.push_back({name, compare_input(a, b, name), outcome_of(a.report, name),
                     outcome_of(b.report, name), std::nullopt});
  return views;
}

std::vector<std::string> notes_on(const RunFolder& a, const RunFolder& b) {
  std::vector<std::string> notes;
  for (const auto& [name, run] : {std::pair("A", &a), std::pair("B", &b)}) {
    if (!run->finished && run->report.find("/run"))
      notes.push_back(fmt::format(
          "{} did not finish: what its folder has may be left from an earlier run.", name));
    for (const std::string& what : run->missing)
      notes.push_back(fmt::format("{} lacks {}.", name, what));
    if (run->took_earlier_results)
      notes.push_back(fmt::format(
          "{} took results of earlier runs, so its times are not those of computing them.", name));
  }
  if (a.report.text("/relief") != b.report.text("/relief"))
    notes.emplace_back("The runs are of different versions of relief.");
  else if (a.report.text("/run/program") != b.report.text("/run/program"))
    notes.emplace_back("The runs are of different builds of relief.");
  return notes;
}

Eigen::Vector3d middle_of(const std::optional<TriangleMesh>& model) {
  return model && !model->vertices.empty() ? Eigen::Vector3d(bounding_box(*model).center())
                                           : Eigen::Vector3d::Zero();
}

// Distances below this part of the model's size are rounding: write_mesh keeps vertices to 1e-7.
constexpr double kRounding = 1e-6;

double scale_of(const ComparedModels& models, double wanted) {
  if (wanted > 0.0) return wanted;
  return std::max({models.distances.a_to_b.all.distance.p95,
                   models.distances.b_to_a.all.distance.p95,
                   kRounding * bounding_box(models.a).diagonal().norm()});
}

Result<ComparedModels> compare_models(TriangleMesh a, TriangleMesh b, const RigidMotion& a_from_b,
                                      const RunComparisonOptions& options, const Context& context) {
  for (auto& vertex : b.vertices) vertex = a_from_b * vertex;
  const Eigen::Matrix3f rotation = a_from_b.linear().cast<float>();
  for (auto& normal : b.normals) normal = rotation * normal;
  auto distances = evaluation::mutual_distances(a, b, options.distances, context);
  if (!distances) return distances.error();
  ComparedModels models{std::move(a), std::move(b), std::move(*distances)};
  models.colour_scale = scale_of(models, options.colour_scale);
  return models;
}

class Comparer {
 public:
  Comparer(RunFolder a, RunFolder b, const RunComparisonOptions& options, const Context& context)
      : a_(std::move(a)), b_(std::move(b)), options_(options), context_(context) {}

  Result<RunComparison> operator()() {
    result_.a = side_of(a_);
    result_.b = side_of(b_);
    result_.notes = notes_on(a_, b_);
    result_.options = compare_options(a_.report, b_.report);
    result_.figures = compare_figures(a_, b_);
    result_.views = compare_views(a_, b_);
    const bool same_unit = a_.unit == b_.unit || a_.unit.empty() || b_.unit.empty();
    if (!same_unit) {
      note("A is in {}, B in {}: their poses and models are not compared.", a_.unit, b_.unit);
      return std::move(result_);
    }
    result_.unit = a_.unit.empty() ? b_.unit.empty() ? "unit" : b_.unit : a_.unit;
    if (auto done = add_poses(); !done) return done.error();
    if (auto done = add_models(); !done) return done.error();
    return std::move(result_);
  }

 private:
  template <typename... Values>
  void note(fmt::format_string<Values...> text, Values&&... values) {
    result_.notes.push_back(fmt::format(text, std::forward<Values>(values)...));
  }

  Result<void> add_poses() {
    auto poses = compare_poses(a_, b_, options_.align, context_);
    if (!poses && poses.error().kind == ErrorKind::kInterrupted) return poses.error();
    if (!poses) {
      note("The poses are not compared: {}.", poses.error().message);
      if (options_.align)
        note("The models are compared in the frames as they are, which may be different ones.");
      return {};
    }
    if (options_.align) {
      const Eigen::Vector3d middle = middle_of(b_.model);
      result_.frame = {.a_from_b = poses->a_from_b,
                       .views = poses->errors.views.size(),
                       .rotation_deg = evaluation::degrees(rotation_angle(poses->a_from_b)),
                       .shift = (poses->a_from_b * middle - middle).norm()};
    }
    for (ComparedView& view : result_.views)
      for (const evaluation::PoseError& error : poses->errors.views)
        if (error.name == view.name) view.pose = error;
    result_.poses = std::move(poses->errors);
    return {};
  }

  Result<void> add_models() {
    if (!a_.model || !b_.model) {
      note("The models are not compared: {}.", a_.model   ? "B has none"
                                               : b_.model ? "A has none"
                                                          : "there are none");
      return {};
    }
    auto models = compare_models(std::move(*a_.model), std::move(*b_.model), result_.frame.a_from_b,
                                 options_, context_);
    if (!models) return models.error();
    result_.models = std::move(*models);
    return {};
  }

  RunFolder a_, b_;
  const RunComparisonOptions& options_;
  const Context& context_;
  RunComparison result_;
};

}  // namespace

std::string to_string(InputState state) {
  switch (state) {
    case InputState::kSame:
      return "same";
    case InputState::kOtherSamples:
      return "other samples";
    case InputState::kOtherPose:
      return "other starting pose";
    case InputState::kOnlyInA:
      return "only in A";
    case InputState::kOnlyInB:
      return "only in B";
    case InputState::kNotRecorded:
      return "not recorded";
  }
  return "";
}

bool RunComparison::complete() const { return a.finished && b.finished && poses && models; }

Result<RunComparison> compare_runs(RunFolder a, RunFolder b, const RunComparisonOptions& options,
                                   const Context& context) {
  return Comparer(std::move(a), std::move(b), options, context)();
}

}  // namespace relief
