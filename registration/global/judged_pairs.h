#pragma once

#include <cstddef>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "registration/global/pair_search.h"
#include "registration/surface/view_surface.h"
#include "registration/verification/pose_evidence.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What judge_pose() and refine_hypothesis() say of pairs of views, remembered: when links are
/// added the same ways of joining views are tried again. Safe to use from several threads.
class JudgedPairs {
 public:
  /// `surfaces` outlive this.
  explicit JudgedPairs(const std::vector<ViewSurface>& surfaces) : surfaces_(surfaces) {}

  /// judge_pose() of view j at a pose relative to view i.
  PoseEvidence judge(std::size_t i, std::size_t j, const RigidMotion& i_from_j,
                     const JudgeOptions& options);
  /// refine_hypothesis() from there.
  PoseHypothesis settle(std::size_t i, std::size_t j, const RigidMotion& i_from_j,
                        double search_distance, const JudgeOptions& options);

 private:
  const std::vector<ViewSurface>& surfaces_;
  std::mutex mutex_;  // Of the maps, whose keys are hashes of the arguments.
  std::unordered_map<std::string, PoseEvidence> judged_;
  std::unordered_map<std::string, PoseHypothesis> settled_;
};

}  // namespace relief::registration
