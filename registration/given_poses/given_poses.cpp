#include "registration/given_poses/given_poses.h"

#include <algorithm>
#include <utility>

#include "registration/given_poses/kept_poses.h"
#include "registration/posegraph/pose_step.h"

namespace relief::registration {

namespace {

// Views that share a frame whatever their pairs say: known ones, and trusted ones.
void join_groups(const std::vector<bool>& together, std::vector<std::size_t>& group) {
  std::size_t first = group.size();
  for (std::size_t i = 0; i < group.size(); ++i)
    if (together[i]) first = std::min(first, group[i]);
  std::vector<bool> joined(group.size(), false);
  for (std::size_t i = 0; i < group.size(); ++i)
    if (together[i]) joined[group[i]] = true;
  for (std::size_t& g : group)
    if (joined[g]) g = first;
}

// Guesses alone may be meant in another convention.
PoseConvention convention_of(const std::vector<ViewSurface>& surfaces,
                             const std::vector<RigidMotion>& poses,
                             const std::vector<ViewRole>& roles, bool trust) {
  std::vector<bool> given;
  for (const ViewRole role : roles) {
    if (trust || role == ViewRole::kFixed) return {};
    given.push_back(role == ViewRole::kFree);
  }
  return find_pose_convention(surfaces, poses, given);
}

// `checked` has the refuted poses.
CheckedPoses settle(CheckedPoses checked, const std::vector<ViewRole>& roles,
                    const JointRefinement& refined, const PoseVerification& verified, bool trust) {
  checked.world_from_view.resize(roles.size());
  checked.group = verified.group;
  std::vector<bool> together(roles.size());
  for (std::size_t i = 0; i < roles.size(); ++i) {
    checked.known.push_back(roles[i] == ViewRole::kFixed);
    together[i] = checked.known[i] || (trust && roles[i] == ViewRole::kFree);
    if (roles[i] != ViewRole::kExcluded) checked.world_from_view[i] = refined.world_from_view[i];
  }
  join_groups(together, checked.group);
  return checked;
}

void merge_flags(const std::vector<bool>& more, std::vector<bool>& flags) {
  for (std::size_t i = 0; i < flags.size(); ++i)
    if (more[i]) flags[i] = true;
}

bool any(const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); }

// Views may go astray one after another; then all that are left keep their poses. Bounds the time.
constexpr int kMostRounds = 3;

// Given poses on their way to refined ones. Views that refining leads astray keep theirs, and the
// others are refined beside them.
class RefiningGiven {
 public:
  RefiningGiven(const std::vector<ViewSurface>& surfaces, const std::vector<RigidMotion>& given,
                const std::vector<ViewRole>& roles, const StartingPoseOptions& options)
      : surfaces_(surfaces),
        given_(given),
        roles_(roles),
        keep_given_(options.keep_given),
        association_(options.association),
        kept_(roles.size(), false),
        coincident_(roles.size(), false),
        laid_on_plane_(roles.size(), false),
        displacement_covariance_(roles.size(), Matrix6d::Zero()) {}

  Result<JointRefinement> run(const JointRefinementOptions& refinement, const Progress& progress,
                              const AlignUnits& units) {
    for (int round = 1;; ++round) {
      const auto roles = with_kept();
      auto refined = units.refine_jointly(surfaces_, given_, roles, refinement, progress);
      if (!refined) return refined;
      const GivenAndRefined compared(surfaces_, given_, refined->world_from_view, roles,
                                     association_);
      if (keep_those_astray(compared, *refined)) {
        if (round == kMostRounds) merge_flags(free(), kept_);
        continue;
      }
      if (!keep_given_ || !any(free()) || !compared.given_fit_as_well()) {
        set_covariances(*refined);
        return refined;
      }
      merge_flags(free(), kept_);
      JointRefinementOptions nothing_moves = refinement;
      nothing_moves.levels = 1;
      auto as_given = units.refine_jointly(surfaces_, given_, with_kept(), nothing_moves, progress);
      if (!as_given) return as_given;
      // What the views tell of their poses is what refining them finds.
      as_given->held = std::move(refined->held);
      as_given->pose_covariance = std::move(refined->pose_covariance);
      as_given->pose_std = std::move(refined->pose_std);
      as_given->joint_covariance = std::move(refined->joint_covariance);
      as_given->kept_motions = std::move(refined->kept_motions);
      set_covariances(*as_given);
      return as_given;
    }
  }

  const std::vector<bool>& kept() const { return kept_; }
  const std::vector<bool>& laid_on_plane() const { return laid_on_plane_; }

  // Of coincident views nothing tells whether others contradict them.
  std::vector<ViewRole> roles_to_verify() const {
    auto roles = roles_;
    for (std::size_t i = 0; i < roles.size(); ++i)
      if (coincident_[i]) roles[i] = ViewRole::kFixed;
    return without_views(laid_on_plane_, std::move(roles));
  }

 private:
  std::vector<ViewRole> with_kept() const {
    auto roles = roles_;
    for (std::size_t i = 0; i < roles.size(); ++i)
      if (kept_[i]) roles[i] = ViewRole::kFixed;
    return roles;
  }

  std::vector<bool> free() const {
    const auto roles = with_kept();
    std::vector<bool> free;
    for (const ViewRole role : roles) free.push_back(role == ViewRole::kFree);
    return free;
  }

  // Whether there are any.
  bool keep_those_astray(const GivenAndRefined& compared, const JointRefinement& refined) {
    const auto coincident = compared.coincident_views(),
               on_plane = compared.views_laid_on_planes(refined.pairs);
    merge_flags(coincident, coincident_);
    merge_flags(on_plane, laid_on_plane_);
    auto astray = compared.views_without_overlap();
    merge_flags(coincident, astray);
    merge_flags(on_plane, astray);
    merge_flags(astray, kept_);
    for (std::size_t i = 0; i < astray.size(); ++i) {
      if (!astray[i]) continue;
      const RigidTangent moved = tangent_at(refined.world_from_view[i] * given_[i].inverse(),
                                            given_[i] * surfaces_[i].centre());
      displacement_covariance_[i] = moved * moved.transpose();
    }
    return any(astray);
  }

  // Of a view that goes astray they are what it moved by: nothing tells its pose better.
  void set_covariances(JointRefinement& refined) const {
    for (std::size_t i = 0; i < displacement_covariance_.size(); ++i) {
      if (displacement_covariance_[i].isZero(0.0)) continue;
      refined.pose_covariance[i] = displacement_covariance_[i];
      refined.pose_std[i] = displacement_covariance_[i].diagonal().cwiseSqrt();
    }
  }

  const std::vector<ViewSurface>& surfaces_;
  const std::vector<RigidMotion>& given_;
  const std::vector<ViewRole>& roles_;
  const bool keep_given_;
  const Association association_;
  std::vector<bool> kept_;                         // Given poses that stay.
  std::vector<bool> coincident_;                   // Of these, those of coincident_views(),
  std::vector<bool> laid_on_plane_;                // and of views_laid_on_planes().
  std::vector<Matrix6d> displacement_covariance_;  // By what views went, squared; zero for others.
};

// Refines and verifies; views that are refuted are taken out, and the rest is refined again.
Result<RefinedGivenPoses> refine_and_verify(const std::vector<ViewSurface>& surfaces,
                                            const std::vector<RigidMotion>& poses,
                                            std::vector<ViewRole> roles,
                                            const StartingPoseOptions& options,
                                            const JointRefinementOptions& refinement,
                                            const Progress& progress, const AlignUnits& units) {
  const bool trust = options.given == GivenPoses::kTrust;
  CheckedPoses checked;
  checked.refuted.assign(roles.size(), false);
  checked.fits_in_part.resize(roles.size());
  std::vector<std::vector<std::size_t>> partners(roles.size());  // That refuted views fit in part.
  for (;;) {
    RefiningGiven refining(surfaces, poses, roles, options);
    auto refined = refining.run(refinement, progress, units);
    if (!refined) return refined.error();
    if (!report_progress(progress, 0.0, "verifying poses"))
      return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
    auto verified = verify_poses(surfaces, refined->world_from_view, refining.roles_to_verify(),
                                 verification_options(options));
    bool changed = false;
    for (std::size_t i = 0; i < roles.size() && !trust; ++i) {
      if (!verified.views[i].refuted) continue;
      checked.refuted[i] = changed = true;
      partners[i] = verified.views[i].fits_in_part_with;
      checked.fits_in_part[i] = refined->world_from_view[i];
      roles[i] = ViewRole::kExcluded;
    }
    if (changed) continue;
    for (std::size_t i = 0; i < roles.size(); ++i)
      if (std::ranges::all_of(partners[i], [&](std::size_t j) { return checked.refuted[j]; }))
        checked.fits_in_part[i].reset();
    checked = settle(std::move(checked), roles, *refined, verified, trust);
    checked.kept = refining.kept();
    checked.laid_on_plane = refining.laid_on_plane();
    return RefinedGivenPoses{std::move(checked), std::move(*refined), std::move(verified), {}};
  }
}

// Views of the largest group that confirm each other.
std::size_t most_confirmed(const RefinedGivenPoses& poses) {
  std::vector<std::size_t> sizes(poses.verified.group.size(), 0);
  for (const std::size_t group : poses.verified.group) ++sizes[group];
  return sizes.empty() ? 0 : *std::max_element(sizes.begin(), sizes.end());
}

}  // namespace

std::vector<ViewRole> roles_of(const std::vector<RangeView>& views, GivenPoses given) {
  std::vector<ViewRole> roles;
  for (const RangeView& view : views) {
    const bool used = view.pose == PoseKind::kGuess && given != GivenPoses::kIgnore;
    roles.push_back(view.pose == PoseKind::kKnown ? ViewRole::kFixed
                    : used                        ? ViewRole::kFree
                                                  : ViewRole::kExcluded);
  }
  return roles;
}

std::vector<ViewRole> without_views(const std::vector<bool>& views, std::vector<ViewRole> roles) {
  for (std::size_t i = 0; i < roles.size(); ++i)
    if (views[i]) roles[i] = ViewRole::kExcluded;
  return roles;
}

PoseVerificationOptions verification_options(const StartingPoseOptions& options) {
  PoseVerificationOptions verification;
  verification.limits.max_free_space_violation = options.max_free_space_violation;
  verification.association = options.association;
  return verification;
}

Result<RefinedGivenPoses> refine_given_poses(const std::vector<ViewSurface>& surfaces,
                                             const std::vector<RangeView>& views,
                                             const StartingPoseOptions& options,
                                             const JointRefinementOptions& refinement,
                                             const std::optional<PoseConvention>& asked,
                                             const Progress& progress, const AlignUnits& units) {
  const auto roles = roles_of(views, options.given);
  std::vector<RigidMotion> poses;
  for (const RangeView& view : views) poses.push_back(view.world_from_view);
  const auto refine = [&](const std::vector<RigidMotion>& from) {
    return refine_and_verify(surfaces, from, roles, options, refinement, progress, units);
  };
  const PoseConvention convention =
      asked ? *asked : convention_of(surfaces, poses, roles, options.given == GivenPoses::kTrust);
  if (convention.as_given()) return refine(poses);
  std::vector<RigidMotion> converted;
  for (const RigidMotion& pose : poses) converted.push_back(convention.world_from_view(pose));
  auto other = refine(converted);
  if (!other) return other;
  other->convention = convention;
  if (asked) return other;
  const auto all =
      static_cast<std::size_t>(std::count(roles.begin(), roles.end(), ViewRole::kFree));
  if (most_confirmed(*other) == all) return other;
  auto given = refine(poses);
  return given && most_confirmed(*other) > most_confirmed(*given) ? other : given;
}

}  // namespace relief::registration
