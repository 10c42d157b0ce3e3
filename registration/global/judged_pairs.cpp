#include "registration/global/judged_pairs.h"

#include <cstring>

namespace relief::registration {

namespace {

template <typename Number>
void append_bytes(const Number& number, std::string& key) {
  const std::size_t size = key.size();
  key.resize(size + sizeof number);
  std::memcpy(key.data() + size, &number, sizeof number);
}

std::string key_of(std::size_t i, std::size_t j, const RigidMotion& i_from_j,
                   double search_distance, const JudgeOptions& options) {
  std::string key;
  append_bytes(i, key);
  append_bytes(j, key);
  const Eigen::Matrix4d& matrix = i_from_j.matrix();
  for (Eigen::Index k = 0; k < matrix.size(); ++k) append_bytes(matrix.data()[k], key);
  append_bytes(search_distance, key);
  append_bytes(options.association, key);
  append_bytes(options.probes, key);
  append_bytes(options.max_normal_angle_deg, key);
  append_bytes(options.min_stddev, key);
  return key;
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
