#include "registration/global/judged_pairs.h"

#include "scan/units/content_hash.h"

namespace relief::registration {

namespace {

std::string key_of(std::size_t i, std::size_t j, const RigidMotion& i_from_j,
                   double search_distance, const JudgeOptions& options) {
  const auto& [association, probes, max_normal_angle_deg, min_stddev] = options;
  return ContentHash()
      .add(i, j, i_from_j, search_distance, association, probes, max_normal_angle_deg, min_stddev)
      .hex();
}

// What is known under the key, else what `compute` returns.
template <typename Value, typename Compute>
Value remembered(std::unordered_map<std::string, Value>& known, std::mutex& mutex,
                 const std::string& key, const Compute& compute) {
  {
    const std::lock_guard lock(mutex);
    if (const auto found = known.find(key); found != known.end()) return found->second;
  }
  const Value value = compute();
  const std::lock_guard lock(mutex);
  known.emplace(key, value);
  return value;
}

}  // namespace

PoseEvidence JudgedPairs::judge(std::size_t i, std::size_t j, const RigidMotion& i_from_j,
                                const JudgeOptions& options) {
  return remembered(judged_, mutex_, key_of(i, j, i_from_j, 0.0, options),
                    [&] { return judge_pose(surfaces_[j], surfaces_[i], i_from_j, options); });
}

PoseHypothesis JudgedPairs::settle(std::size_t i, std::size_t j, const RigidMotion& i_from_j,
                                   double search_distance, const JudgeOptions& options) {
  return remembered(settled_, mutex_, key_of(i, j, i_from_j, search_distance, options), [&] {
    return refine_hypothesis(surfaces_[j], surfaces_[i], i_from_j, search_distance, options);
  });
}

}  // namespace relief::registration
