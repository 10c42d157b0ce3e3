#include "scan/io/normals/convention_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scan/base/median.h"

namespace relief {

namespace {

constexpr double kMostParts = 64.0;   // of a view, which is cut into squares
constexpr double kFewestParts = 8.0;  // that can be compared
constexpr double kDeviations = 5.0;   // of a mean over the parts: 6e-7 of a Gaussian lies beyond
// Mean gain of a loss in [0, 1] that matters: one window of 50 turns from right to wrong.
constexpr double kLeastGain = 0.02;
// Fraction of the parts that must say the same: by chance 14 % of times of 8 parts, 4e-5 of 64.
constexpr double kAgreeing = 0.75;

// 0 up to the angle that bias and noise explain, 1 from twice the bias above it.
double direction_loss(double angle, double stddev) {
  return std::clamp((angle - kLargestBias - 2.0 * stddev) / kLargestBias, 0.0, 1.0);
}

// The part of the view that a place of the lattice belongs to.
class Partition {
 public:
  explicit Partition(const Grid<int>& lattice)
      : side_(std::max(1, static_cast<int>(std::ceil(
                              std::sqrt(static_cast<double>(lattice.size()) / kMostParts))))),
        columns_((lattice.width() + side_ - 1) / side_),
        rows_((lattice.height() + side_ - 1) / side_) {}

  std::size_t size() const { return static_cast<std::size_t>(columns_ * rows_); }
  std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(row / side_ * columns_ + column / side_);
  }

 private:
  int side_, columns_, rows_;
};

// Calls `body(first, second, part)` for patches that are neighbours on the lattice.
template <typename Body>
void for_each_pair(const NormalPatches& found, const Partition& partition, const Body& body) {
  const Grid<int>& lattice = found.lattice;
  const auto patch = [&](int index) -> const NormalPatch& {
    return found.patches[static_cast<std::size_t>(index)];
  };
  for (int row = 0; row < lattice.height(); ++row)
    for (int column = 0; column < lattice.width(); ++column)
      for (const auto& [right, down] : {std::pair{1, 0}, {0, 1}})
        if (lattice(column, row) >= 0 && lattice.contains(column + right, row + down) &&
            lattice(column + right, row + down) >= 0)
          body(patch(lattice(column, row)), patch(lattice(column + right, row + down)),
               partition.at(column, row));
}

}  // namespace

void ConventionScores::add(const NormalEvidence& evidence) {
  const std::size_t count = conventions_.size();
  impossible_.resize(count, false);
  std::vector<Eigen::Matrix3d> to_view;
  for (std::size_t c = 0; c < count; ++c) {
    if (!evidence.possible(conventions_[c])) impossible_[c] = true;
    to_view.push_back(evidence.view_from_stored(conventions_[c]));
  }
  const NormalPatches& found = evidence.patches;
  const Partition partition(found.lattice);
  Part empty;
  empty.directions = empty.relief = Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(count));
  std::vector<Part> parts(partition.size(), empty);

  for (int row = 0; row < found.lattice.height(); ++row) {
    for (int column = 0; column < found.lattice.width(); ++column) {
      if (found.lattice(column, row) < 0) continue;
      const auto& patch = found.patches[static_cast<std::size_t>(found.lattice(column, row))];
      Part& part = parts[partition.at(column, row)];
      part.patches += 1.0;
      for (std::size_t c = 0; c < count; ++c) {
        const double cosine = patch.surface.dot(to_view[c] * patch.stored);
        part.directions[static_cast<Eigen::Index>(c)] +=
            direction_loss(std::acos(std::clamp(cosine, -1.0, 1.0)), patch.stddev);
      }
    }
  }

  std::vector<double> steps;
  for_each_pair(found, partition, [&](const NormalPatch& a, const NormalPatch& b, std::size_t) {
    steps.push_back((b.surface - a.surface).squaredNorm() + 4.0 * a.stddev * b.stddev);
  });
  const double scale = std::max(median(steps), std::numeric_limits<double>::epsilon());
  for_each_pair(found, partition, [&](const NormalPatch& a, const NormalPatch& b, std::size_t at) {
    const Eigen::Vector3d surface = b.surface - a.surface, stored = b.stored - a.stored;
    const auto loss = [&](const Eigen::Vector3d& error) {
      return error.squaredNorm() / (error.squaredNorm() + scale);
    };
    Part& part = parts[at];
    part.pairs += 1.0;
    part.plane += loss(surface);
    for (std::size_t c = 0; c < count; ++c)
      part.relief[static_cast<Eigen::Index>(c)] += loss(surface - to_view[c] * stored);
  });

  for (Part& part : parts)
    if (part.patches > 0.0) parts_.push_back(std::move(part));
}

bool ConventionScores::possible(std::size_t convention) const {
  return impossible_.empty() || !impossible_[convention];
}

double ConventionScores::disagreement(std::size_t convention) const {
  const auto c = static_cast<Eigen::Index>(convention);
  double directions = 0.0, relief = 0.0, patches = 0.0, pairs = 0.0;
  for (const Part& part : parts_) {
    directions += part.directions[c];
    relief += part.relief[c] - part.plane;
    patches += part.patches;
    pairs += part.pairs;
  }
  return (patches > 0.0 ? directions / patches : 0.0) + (pairs > 0.0 ? relief / pairs : 0.0);
}

std::size_t ConventionScores::best() const {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < conventions_.size(); ++c) {
    if (!possible(c)) continue;
    // Equal ones differ by rounding: the first of them is the most usual.
    if (const double value = disagreement(c); value < least - 1e-9) {
      least = value;
      best = c;
    }
  }
  return best;
}

// The mean of `difference` over the parts and its standard error, each part counting by its size.
template <typename Difference, typename Count>
ConventionScores::Comparison ConventionScores::compare(const Difference& difference,
                                                       const Count& count) const {
  double sum = 0.0, size = 0.0, parts = 0.0, agreeing = 0.0, opposed = 0.0;
  for (const Part& part : parts_) {
    const double n = count(part), d = difference(part);
    if (!(n > 0.0)) continue;
    sum += d;
    size += n;
    parts += 1.0;
    agreeing += d > kLeastGain * n ? 1.0 : 0.0;
    opposed += d < -kLeastGain * n ? 1.0 : 0.0;
  }
  if (parts < kFewestParts) return {};
  const double mean = sum / size;
  if (std::abs(mean) < kLeastGain) return {};
  if (std::max(agreeing, opposed) < kAgreeing * (agreeing + opposed)) return {};
  double squares = 0.0;
  for (const Part& part : parts_) {
    const double n = count(part);
    if (n > 0.0) squares += std::pow(difference(part) - mean * n, 2);
  }
  const double error = std::sqrt(squares * parts / (parts - 1.0)) / size;
  return {error > 0.0 ? mean / error
                      : std::copysign(std::numeric_limits<double>::infinity(), mean)};
}

bool ConventionScores::Comparison::clear() const { return deviations >= kDeviations; }

ConventionScores::Comparison ConventionScores::compare_directions(std::size_t better,
                                                                  std::size_t worse) const {
  const auto b = static_cast<Eigen::Index>(better), w = static_cast<Eigen::Index>(worse);
  return compare([=](const Part& part) { return part.directions[w] - part.directions[b]; },
                 [](const Part& part) { return part.patches; });
}

ConventionScores::Comparison ConventionScores::compare_relief(std::size_t better,
                                                              std::size_t worse) const {
  const auto b = static_cast<Eigen::Index>(better), w = static_cast<Eigen::Index>(worse);
  return compare([=](const Part& part) { return part.relief[w] - part.relief[b]; },
                 [](const Part& part) { return part.pairs; });
}

ConventionScores::Comparison ConventionScores::compare_with_plane(std::size_t better) const {
  const auto b = static_cast<Eigen::Index>(better);
  return compare([=](const Part& part) { return part.plane - part.relief[b]; },
                 [](const Part& part) { return part.pairs; });
}

bool ConventionScores::clearly_better(std::size_t a, std::size_t b) const {
  const Comparison directions = compare_directions(a, b), relief = compare_relief(a, b);
  if (directions.clear()) return relief.deviations > -kDeviations;
  return relief.clear() && compare_with_plane(a).clear() && directions.deviations > -kDeviations;
}

ConventionRanking ConventionScores::ranking() const {
  const std::size_t winner = best();
  ConventionRanking ranking;
  for (std::size_t c = 0; c < conventions_.size(); ++c) {
    ranking.disagreement.push_back(disagreement(c));
    if (possible(c) && (c == winner || !clearly_better(winner, c))) ranking.candidates.push_back(c);
  }
  return ranking;
}

}  // namespace relief
