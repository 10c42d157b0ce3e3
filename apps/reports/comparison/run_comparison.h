#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "apps/reports/comparison/run_folder.h"
#include "relief/evaluation/mesh_errors.h"
#include "relief/evaluation/pose_errors.h"
#include "relief/scan/context.h"

namespace relief {

/// What a figure measures. It says the figure's unit, and how it is rounded.
enum class Quantity {
  kCount,
  kNumber,    ///< Without a unit.
  kFraction,  ///< Shown as a percentage.
  kTruth,     ///< 1: yes, 0: no.
  kLength,    ///< [unit]
  kArea,      ///< [unit^2]
  kVolume,    ///< [unit^3]
  kAngle,     ///< [degrees]
  kTime,      ///< [s]
  kMemory,    ///< [MB]
};

/// One figure of both runs.
struct ComparedFigure {
  std::string group;  ///< `alignment`, `refinement`, `model` or `cost`.
  std::string key;    ///< In the report, as `views_placed`.
  std::string title;  ///< In words.
  Quantity quantity = Quantity::kNumber;
  std::optional<double> a, b;
  bool same_unit = true;  ///< Whether a and b may be compared.

  std::optional<double> difference() const;  ///< b - a
  std::optional<double> ratio() const;       ///< b / a; nothing where a is 0.
};

/// An option that the runs were given with different values, or only one of them.
struct ComparedOption {
  std::string name;                 ///< As `--no-polish`.
  std::optional<std::string> a, b;  ///< Nothing: not given, so it has its default.
  bool changes_result = true;       ///< False for file names, threads and the like.
};

/// Whether the runs had the same view to start from.
enum class InputState { kSame, kOtherSamples, kOtherPose, kOnlyInA, kOnlyInB, kNotRecorded };

/// In words.
std::string to_string(InputState state);

/// What one run says of a view. Empty or nothing where it says nothing.
struct ViewOutcome {
  std::string alignment;                               ///< `verified`, `unverified`, `left out`.
  std::string refinement;                              ///< The status of its refinement.
  std::optional<double> rms_change, median_deviation;  ///< Of its refinement [unit].
};

struct ComparedView {
  std::string name;
  InputState input = InputState::kNotRecorded;
  ViewOutcome a, b;
  std::optional<evaluation::PoseError> pose;  ///< Of B's pose against A's; where both placed it.
};

/// The motion from the frame of run B into that of run A.
struct FrameMotion {
  RigidMotion a_from_b = RigidMotion::Identity();
  std::size_t views = 0;  ///< Common views that it was fitted to; 0: the frames were taken as one.
  double rotation_deg = 0.0;  ///< [degrees]
  double shift = 0.0;         ///< How far it moves the middle of B's model, else the origin [unit].
};

/// Both models, in the frame of run A.
struct ComparedModels {
  TriangleMesh a, b;
  evaluation::MutualDistances distances;
  double colour_scale = 0.0;  ///< Distance of full colour [unit].
};

/// One of the two runs.
struct RunSide {
  std::string folder;
  std::string version;  ///< Of relief.
  std::string program;  ///< Identity of the build; empty: not recorded.
  std::string input;    ///< What was scanned; empty: not recorded.
  bool finished = false;
  std::vector<std::string> missing;
};

/// Two runs side by side.
struct RunComparison {
  RunSide a, b;
  std::string unit;                ///< Of the lengths; empty if the runs have different ones.
  std::vector<std::string> notes;  ///< What to know before reading the figures, one sentence each.
  std::vector<ComparedOption> options;
  std::vector<ComparedFigure> figures;
  std::vector<ComparedView> views;
  FrameMotion frame;
  std::optional<evaluation::PoseErrorReport> poses;  ///< Of B against A; nothing: not comparable.
  std::optional<ComparedModels> models;              ///< Nothing: a model is missing.

  /// Whether both runs finished, and all that a run leaves was compared.
  bool complete() const;
};

struct RunComparisonOptions {
  bool align = true;  ///< Fit the frames by the poses of the common views.
  evaluation::MeshDistanceOptions distances;
  double colour_scale = 0.0;  ///< [unit]; 0: that of 95 % of the surfaces.
};

/// Compares two runs; what is missing on one side is left out, with a note. The models are moved
/// out of the folders. Errors: kBadInput for a model that is no surface, kInterrupted.
Result<RunComparison> compare_runs(RunFolder a, RunFolder b,
                                   const RunComparisonOptions& options = {},
                                   const Context& context = {});

/// All figures of the reports and of the models, in the order in which they are shown.
std::vector<ComparedFigure> compare_figures(const RunFolder& a, const RunFolder& b);

/// The poses of run B against those of run A, for views that both placed, after the motion between
/// the frames: the robust fit of evaluate_poses() if `fit`, the identity otherwise. The samples are
/// those of A's scan.json, of B's if that cannot be read. kUnsolvable: no common view, or no
/// samples.
struct ComparedPoses {
  evaluation::PoseErrorReport errors;
  RigidMotion a_from_b = RigidMotion::Identity();
};
Result<ComparedPoses> compare_poses(const RunFolder& a, const RunFolder& b, bool fit,
                                    const Context& context);

}  // namespace relief
