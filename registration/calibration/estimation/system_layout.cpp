#include "registration/calibration/estimation/system_layout.h"

namespace relief::registration {

namespace {

// Unknowns of a pair and their place among all.
struct Part {
  Eigen::Index from, to, count;
  double sign;
};

// The target's pose counts with the opposite sign.
std::vector<Part> parts_of(const PairSums& pair, const Sensors& sensors,
                           const SystemLayout& layout) {
  const auto terms_of = [&](std::size_t view) {
    return static_cast<Eigen::Index>(sensors.models[sensors.of_view[view]].terms());
  };
  const Eigen::Index source = terms_of(pair.source), target = terms_of(pair.target);
  std::vector<Part> parts;
  if (layout.pose[pair.source] >= 0) parts.push_back({0, layout.pose[pair.source], 6, 1.0});
  if (layout.pose[pair.target] >= 0) parts.push_back({0, layout.pose[pair.target], 6, -1.0});
  parts.push_back({6, layout.poses + layout.terms[pair.source], source, 1.0});
  parts.push_back({6 + source, layout.poses + layout.terms[pair.target], target, 1.0});
  return parts;
}

}  // namespace

SystemLayout::SystemLayout(const Sensors& sensors, const std::vector<bool>& held, bool of_views)
    : per_view(of_views) {
  std::vector<Eigen::Index> of_sensor(sensors.models.size(), -1);
  for (std::size_t i = 0; i < held.size(); ++i) {
    pose.push_back(held[i] ? -1 : poses);
    poses += held[i] ? 0 : 6;
    Eigen::Index& first = of_sensor[sensors.of_view[i]];
    if (per_view || first < 0) {
      first = coefficients;
      coefficients += static_cast<Eigen::Index>(sensors.models[sensors.of_view[i]].terms());
    }
    terms.push_back(first);
  }
}

std::vector<Eigen::Index> SystemLayout::coefficients_of(const ErrorModel& model,
                                                        const ErrorParameter& parameter,
                                                        const Sensors& sensors) const {
  std::vector<Eigen::Index> found;
  for (std::size_t view = 0; view < terms.size(); ++view) {
    if (!model.concerns(parameter, view, sensors)) continue;
    found.push_back(terms[view] + static_cast<Eigen::Index>(parameter.term));
    if (!per_view) break;  // Views of a sensor have the same coefficients.
  }
  return found;
}

void add_fold(const PairSums& pair, std::size_t fold, const Sensors& sensors,
              const SystemLayout& layout, QuadraticSum& all) {
  const QuadraticSum& sum = pair.folds[fold];
  const std::vector<Part> parts = parts_of(pair, sensors, layout);
  for (const Part& a : parts) {
    all.gradient.segment(a.to, a.count) += a.sign * sum.gradient.segment(a.from, a.count);
    for (const Part& b : parts)
      all.matrix.block(a.to, b.to, a.count, b.count) +=
          a.sign * b.sign * sum.matrix.block(a.from, b.from, a.count, b.count);
  }
  all.squares += sum.squares;
}

QuadraticSum sum_of_fold(const std::vector<PairSums>& pairs, std::size_t fold,
                         const Sensors& sensors, const SystemLayout& layout) {
  QuadraticSum all(layout.poses + layout.coefficients);
  for (const PairSums& pair : pairs) add_fold(pair, fold, sensors, layout, all);
  return all;
}

void add_common_motion(const PairSums& pair, const Sensors& sensors, const SystemLayout& layout,
                       ReducedSum& all) {
  const auto source =
      static_cast<Eigen::Index>(sensors.models[sensors.of_view[pair.source]].terms());
  const Eigen::MatrixXd motion = common_motion(pair, source);
  const Eigen::Index target = motion.rows() - source;
  const Eigen::Index s = layout.terms[pair.source], t = layout.terms[pair.target];
  all.matrix.block(s, s, source, source) += motion.topLeftCorner(source, source);
  all.matrix.block(t, t, target, target) += motion.bottomRightCorner(target, target);
  all.matrix.block(s, t, source, target) += motion.topRightCorner(source, target);
  all.matrix.block(t, s, target, source) += motion.bottomLeftCorner(target, source);
}

}  // namespace relief::registration
