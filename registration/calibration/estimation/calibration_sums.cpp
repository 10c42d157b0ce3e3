#include "registration/calibration/estimation/calibration_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "registration/pairwise/robust.h"
#include "registration/posegraph/refinement/pair_information.h"
#include "scan/base/cell_key.h"
#include "scan/base/counter_random.h"
#include "scan/base/parallel_batches.h"
#include "scan/base/robust_scales.h"

namespace relief::registration {

namespace {

// Rows that are multiplied at a time. Bounds the memory.
constexpr Eigen::Index kRows = 256;

// How far apart the samples are that make the range near a pixel [pixels]: the noise of
// triangulating scanners and the interpolation of ranges reach over three.
constexpr int kRing = 5;

// Directed pairs whose sums are in memory at a time, of 0.1 MB each. Bounds the memory.
constexpr std::size_t kPairsAtOnce = 128;

// Errors of views are smooth: of the samples in a patch of (R12), eight by eight, one tells that
// their mean is 0.
constexpr double kCommonWeight = 1.0 / 64.0;

std::size_t fold_of(const Eigen::Vector3d& point, double patch) {
  const auto cell = (point / patch).array().floor().cast<std::int64_t>().eval();
  return CounterRandom::scrambled(cell_key(cell.x(), cell.y(), cell.z())) % kFolds;
}

// Rows of one fold, summed when there are enough of them.
class RowSum {
 public:
  RowSum(QuadraticSum& sum, Eigen::Index size) : sum_(sum), rows_(kRows, size), residuals_(kRows) {
    sum_ = QuadraticSum(size);
  }

  // A whitened and weighted residual and its derivatives.
  void add(const Eigen::VectorXd& derivatives, double residual) {
    rows_.row(count_) = derivatives.transpose();
    residuals_[count_] = residual;
    if (++count_ == kRows) flush();
  }

  void flush() {
    if (count_ == 0) return;
    const auto rows = rows_.topRows(count_);
    const auto residuals = residuals_.head(count_);
    sum_.matrix.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
    sum_.gradient.noalias() += rows.transpose() * residuals;
    sum_.squares += residuals.squaredNorm();
    count_ = 0;
  }

  void finish() {
    flush();
    sum_.matrix = Eigen::MatrixXd(sum_.matrix.selfadjointView<Eigen::Lower>());
  }

 private:
  QuadraticSum& sum_;
  Eigen::MatrixXd rows_;
  Eigen::VectorXd residuals_;
  Eigen::Index count_ = 0;
};

// One directed pair.
class PairSummation {
 public:
  PairSummation(const CalibratedViews& views, std::size_t source, std::size_t target)
      : views_(views),
        source_(source),
        target_(target),
        world_from_target_(views.world_from_view[target]),
        target_from_source_(world_from_target_.inverse() * views.world_from_view[source]) {}

  PairSums sum(std::span<const std::uint32_t> samples, const CalibrationSumOptions& options) {
    const ViewSurface &source = (*views_.surfaces)[source_], &target = (*views_.surfaces)[target_];
    PairSums sums;
    sums.source = source_;
    sums.target = target_;
    sums.deviation = pair_deviation(source, target, target_from_source_, options.search);
    const auto size = static_cast<Eigen::Index>(6 + views_.sensor_of(source_).terms() +
                                                views_.sensor_of(target_).terms());
    std::vector<RowSum> rows;
    for (QuadraticSum& fold : sums.folds) rows.emplace_back(fold, size);
    if (sums.deviation > 0.0) add_all(samples, options, sums.deviation, rows);
    for (RowSum& fold : rows) fold.finish();
    return sums;
  }

 private:
  void add_all(std::span<const std::uint32_t> samples, const CalibrationSumOptions& options,
               double deviation, std::vector<RowSum>& rows) {
    std::vector<Correspondence> found;
    append_correspondences((*views_.surfaces)[source_], (*views_.surfaces)[target_],
                           target_from_source_, samples, options.search, found);
    for (const Correspondence& c : found) {
      if (std::abs(c.distance) > options.search.max_sigmas * deviation) continue;
      if (std::isnan(nearby_range(source_, c.source.pixel)) ||
          std::isnan(nearby_range(target_, c.target.pixel)))
        continue;
      const double whitening = std::sqrt(c.weight) / deviation;
      const double weight = std::sqrt(cauchy_weight(whitening * c.distance, kCauchyScale));
      const std::size_t fold = fold_of(world_from_target_ * c.target.point, options.patch);
      rows[fold].add(weight * whitening * derivatives(c), weight * whitening * c.distance);
    }
  }

  double nearby_range(std::size_t view, const Eigen::Vector2d& pixel) const {
    return views_.nearby_ranges[view](static_cast<int>(std::lround(pixel.x())),
                                      static_cast<int>(std::lround(pixel.y())));
  }

  // Of the point-to-plane distance: (R4) about the centre, and (C1) of both sensors.
  Eigen::VectorXd derivatives(const Correspondence& c) const {
    const SensorModel &of_source = views_.sensor_of(source_),
                      &of_target = views_.sensor_of(target_);
    const Eigen::Vector3d normal = world_from_target_.linear() * c.target.normal;
    const Eigen::Vector3d point = world_from_target_ * c.target.point - views_.centre;
    Eigen::VectorXd j(6 + of_source.terms() + of_target.terms());
    j.head<6>() << point.cross(normal), normal;
    double* const terms = j.data() + 6;
    of_source.project(
        (*views_.given)[source_], c.source.pixel, nearby_range(source_, c.source.pixel),
        target_from_source_.linear().transpose() * c.target.normal, {terms, of_source.terms()});
    of_target.project((*views_.given)[target_], c.target.pixel,
                      nearby_range(target_, c.target.pixel), c.target.normal,
                      {terms + of_source.terms(), of_target.terms()});
    j.tail(static_cast<Eigen::Index>(of_target.terms())) *= -1.0;
    return j;
  }

  const CalibratedViews& views_;
  std::size_t source_, target_;
  const RigidMotion& world_from_target_;
  RigidMotion target_from_source_;
};

}  // namespace

Grid<double> nearby_ranges(const RangeView& view) {
  Grid<double> result(view.width(), view.height(), kNoSample);
  constexpr std::array<std::pair<int, int>, 4> kHalf = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      double sum = 0.0;
      int count = 0;
      for (const auto& [x, y] : kHalf) {
        const int du = kRing * x, dv = kRing * y;
        if (!view.has_sample(u + du, v + dv) || !view.has_sample(u - du, v - dv)) continue;
        sum += 0.5 * (view.range(u + du, v + dv) + view.range(u - du, v - dv));
        ++count;
      }
      if (count > 0) result(u, v) = sum / count;
    }
  }
  return result;
}

QuadraticSum& QuadraticSum::operator+=(const QuadraticSum& other) {
  matrix += other.matrix;
  gradient += other.gradient;
  squares += other.squares;
  return *this;
}

Eigen::MatrixXd common_motion(const PairSums& pair, Eigen::Index source_terms) {
  const Eigen::Index terms = pair.folds[0].gradient.size() - 6;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(terms, terms);
  for (const QuadraticSum& fold : pair.folds) sum += fold.matrix.bottomRightCorner(terms, terms);
  // Derivatives by the target's terms have the opposite sign.
  sum.topRightCorner(source_terms, terms - source_terms) *= -1.0;
  sum.bottomLeftCorner(terms - source_terms, source_terms) *= -1.0;
  return kCommonWeight * 0.25 * sum;
}

std::vector<PairSums> sum_pairs(const CalibratedViews& views, const std::vector<ViewPair>& pairs,
                                const CalibrationSumOptions& options) {
  std::vector<PairSums> sums;
  for_each_pair_sums(views, pairs, options,
                     [&](PairSums pair) { sums.push_back(std::move(pair)); });
  return sums;
}

void for_each_pair_sums(const CalibratedViews& views, const std::vector<ViewPair>& pairs,
                        const CalibrationSumOptions& options,
                        const std::function<void(PairSums)>& take) {
  const auto sum = [&](std::size_t i) {
    const std::size_t source = source_of(pairs, i), target = target_of(pairs, i);
    const auto all = (*views.surfaces)[source].samples();
    const std::vector<std::uint32_t> samples(
        all.begin(),
        all.begin() + static_cast<std::ptrdiff_t>(std::min(all.size(), options.samples)));
    return PairSummation(views, source, target).sum(samples, options);
  };
  parallel_map_in_batches<PairSums>(2 * pairs.size(), kPairsAtOnce, sum,
                                    [&](std::size_t, PairSums pair) { take(std::move(pair)); });
}

}  // namespace relief::registration
