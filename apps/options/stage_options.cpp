#include "apps/options/stage_options.h"

#include <map>
#include <numbers>
#include <string>

#include "apps/options/number_checks.h"

namespace relief {

namespace {

const std::map<std::string, hybrid::Stencil> kStencils = {
    {"edge", hybrid::Stencil::kCompactEdge}, {"paper", hybrid::Stencil::kPaperCentral}};
const std::map<std::string, hybrid::BiasModel> kBiasModels = {
    {"latent", hybrid::BiasModel::kLatent},
    {"two-step", hybrid::BiasModel::kTwoStep},
    {"none", hybrid::BiasModel::kNone}};
const std::map<std::string, hybrid::MeshForm> kForms = {{"normal", hybrid::MeshForm::kAlongNormals},
                                                        {"full", hybrid::MeshForm::kFull}};
const std::map<std::string, hybrid::Solver> kSolvers = {{"multigrid", hybrid::Solver::kMultigrid},
                                                        {"cholesky", hybrid::Solver::kCholesky}};
const std::map<std::string, registration::GivenPoses> kGivenPoses = {
    {"check", registration::GivenPoses::kCheck},
    {"trust", registration::GivenPoses::kTrust},
    {"ignore", registration::GivenPoses::kIgnore}};
// The names that the option --coarse had for them.
const std::map<std::string, registration::GivenPoses> kCoarseSearches = {
    {"auto", registration::GivenPoses::kCheck},
    {"never", registration::GivenPoses::kTrust},
    {"always", registration::GivenPoses::kIgnore}};

constexpr double kRadians = std::numbers::pi / 180.0;

const std::map<std::string, registration::CalibrationScope> kCalibrationScopes = {
    {"auto", registration::CalibrationScope::kAuto},
    {"off", registration::CalibrationScope::kOff},
    {"shared", registration::CalibrationScope::kShared},
    {"per-view", registration::CalibrationScope::kPerView}};

const std::map<std::string, registration::Association> kAssociations = {
    {"auto", registration::Association::kAuto},
    {"projective", registration::Association::kProjective},
    {"nearest", registration::Association::kNearest}};

}  // namespace

hybrid::RefineOptions RefineFlags::resolved() const {
  hybrid::RefineOptions resolved = options;
  if (sigma_normal_deg) resolved.sigma_normal = *sigma_normal_deg * kRadians;
  return resolved;
}

reconstruction::ModelOptions MergeFlags::resolved() const {
  reconstruction::ModelOptions resolved = options;
  if (no_polish)
    resolved.polish.reset();
  else if (polish_sigma_normal_deg)
    resolved.polish->sigma_normal = *polish_sigma_normal_deg * kRadians;
  return resolved;
}

void add_refine_options(CLI::App& command, RefineFlags& flags) {
  auto* group = command.add_option_group("Refinement");
  hybrid::RefineOptions& options = flags.options;
  group->add_option("--stencil", options.stencil, "Normal constraints: edge, or the published ones")
      ->transform(CLI::CheckedTransformer(kStencils))
      ->default_str("edge");
  group->add_option("--bias", options.bias, "Low-frequency error of the normals")
      ->transform(CLI::CheckedTransformer(kBiasModels))
      ->default_str("latent");
  group
      ->add_option("--sigma-position", options.sigma_position,
                   "Noise of the range [unit]; default: estimated per view")
      ->check(positive_number());
  group
      ->add_option("--sigma-normal", flags.sigma_normal_deg,
                   "Noise of the normals [deg]; default: estimated per view")
      ->check(positive_number());
  group->add_option(
      "--lambda", options.lambda,
      "Weight of positions against normals as published, in (0, 1); replaces the noise "
      "of the normals");
  group
      ->add_option("--smoothing-scale", options.smoothing_scale,
                   "Scale of the two-step correction [samples]; default: where the errors cross")
      ->check(positive_number());
  group->add_option("--robust-rounds", options.robust_rounds, "Rounds of robust reweighting")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  group->add_flag("--deviation,!--no-deviation", options.deviation,
                  "Find the standard deviation of every refined sample (the default)");
  group->add_option("--solver", options.solver, "Linear solver: multigrid or cholesky")
      ->transform(CLI::CheckedTransformer(kSolvers))
      ->default_str("multigrid");
}

void add_align_options(CLI::App& command, registration::AlignOptions& options) {
  auto* group = command.add_option_group("Alignment");
  registration::JointRefinementOptions& refinement = options.refinement;
  auto* poses =
      group
          ->add_option("--poses", options.starting_poses.given,
                       "Given poses: check (refined, kept unless other views refute them), trust "
                       "(refined, kept always), ignore (all poses are found by shape)")
          ->transform(CLI::CheckedTransformer(kGivenPoses))
          ->default_str("check");
  group->add_option("--coarse", options.starting_poses.given, "The former name of --poses")
      ->transform(CLI::CheckedTransformer(kCoarseSearches))
      ->excludes(poses)
      ->group("");
  group
      ->add_option_function<registration::Association>(
          "--association",
          [&options](registration::Association association) {
            options.starting_poses.association = association;
            options.refinement.association = association;
          },
          "Corresponding points: projective (the pixel that sees a point), nearest (the closest "
          "sample), auto (projective where the camera allows)")
      ->transform(CLI::CheckedTransformer(kAssociations))
      ->default_str("auto");
  group
      ->add_option("--correspondences", refinement.correspondences,
                   "Correspondences per direction of a pair of views")
      ->check(CLI::Range(6, 1000000))
      ->capture_default_str();
  group
      ->add_option("--search-distance", refinement.search_distance,
                   "How far off the starting poses may be [unit]; 0: a fifth of a view's radius")
      ->check(nonnegative_number())
      ->capture_default_str();
  group
      ->add_option("--min-overlap", refinement.min_overlap,
                   "Pairs of views that share less than this fraction are not used")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  group
      ->add_option_function<std::string>(
          "--normals",
          [&options](const std::string& use) { options.surface.normal_signal = use == "auto"; },
          "Align normal maps too: auto (where the geometry is degenerate) or off")
      ->check(CLI::IsMember({"auto", "off"}))
      ->default_str("auto");
  group
      ->add_option("--max-iterations", refinement.max_iterations,
                   "Renewals of the correspondences, per level")
      ->check(positive_number())
      ->capture_default_str();
}

void add_calibration_options(CLI::App& command, registration::CalibrationOptions& options) {
  auto* group = command.add_option_group("Calibration");
  group
      ->add_option(
          "--calibration", options.scope,
          "Errors of the sensors that held-out samples and views confirm: auto (of all views of a "
          "sensor and of single views), shared (of all views only), per-view (of single views "
          "without confirmation by others too), or off")
      ->transform(CLI::CheckedTransformer(kCalibrationScopes))
      ->default_str("auto");
  group
      ->add_option("--calibration-samples", options.samples,
                   "Samples per direction of a pair of views that errors are estimated from")
      ->check(CLI::Range(100, 1000000))
      ->capture_default_str();
}

namespace {

void add_polish_options(CLI::App& command, MergeFlags& flags) {
  auto* group = command.add_option_group("Polishing");
  hybrid::PolishOptions& options = *flags.options.polish;
  group->add_flag("--no-polish", flags.no_polish,
                  "Leave the mesh as merged, not refined with the normals of the views");
  group
      ->add_option("--polish-form", options.form,
                   "How vertices move: normal (along the surface normal) or full (in space)")
      ->transform(CLI::CheckedTransformer(kForms))
      ->default_str("normal");
  group
      ->add_option("--polish-sigma-position", options.sigma_position,
                   "Error of the merged positions [unit]; default: per vertex, as merged")
      ->check(positive_number());
  group
      ->add_option("--polish-sigma-normal", flags.polish_sigma_normal_deg,
                   "Error of the blended normals [deg]; default: per vertex, from the views")
      ->check(positive_number());
}

}  // namespace

void add_merge_options(CLI::App& command, MergeFlags& flags) {
  auto* group = command.add_option_group("Merging");
  fusion::MergeOptions& options = flags.options.merge;
  group
      ->add_option(
          "--voxel", options.voxel_size,
          "Lattice spacing [unit]; 0: the median sample spacing, 0.8 of it for refined views")
      ->check(nonnegative_number())
      ->capture_default_str();
  group
      ->add_option("--truncation", options.truncation,
                   "How far from a view's surface it counts [unit]; 0: from voxel and noise")
      ->check(nonnegative_number())
      ->capture_default_str();
  group->add_flag_callback(
      "--keep-components", [&options] { options.keep_components = true; },
      "Keep also the components that less than a twentieth of the samples lie on");
  group->add_flag_callback(
      "--keep-contradicted", [&options] { options.keep_contradicted = true; },
      "Take all samples of views that others contradict; else only where no other view measured");
  group->add_flag_callback(
      "--keep-handles", [&options] { options.keep_handles = true; },
      "Keep also the handles within eight voxels that no view measured");
  group
      ->add_option_function<std::string>(
          "--holes", [&options](const std::string& holes) { options.keep_holes = holes == "keep"; },
          "What to do where no view measured: fill, or keep open")
      ->check(CLI::IsMember({"fill", "keep"}))
      ->default_str("fill");
  group
      ->add_option("--largest-fill", options.largest_fill,
                   "Holes that reach farther than this from what was measured stay open [unit]; 0: "
                   "all are filled")
      ->check(nonnegative_number())
      ->capture_default_str();
  fusion::DecimationOptions& decimation = flags.options.decimation;
  group->add_option("--faces", decimation.faces, "Decimate to this number of faces; 0: do not")
      ->capture_default_str();
  group
      ->add_option("--decimation-error", decimation.max_error,
                   "Decimate as far as the surface moves by no more than this [unit]; 0: no bound")
      ->check(nonnegative_number())
      ->capture_default_str();
  add_polish_options(command, flags);
}

}  // namespace relief
