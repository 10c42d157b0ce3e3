#include "registration/global/features/view_similarity.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Core>

namespace relief::registration {

namespace {

// These tell the order in which pairs are searched. Kinds of features: 1300 points of a view are 8
// of each. Fewer kinds tell views apart worse, more count each by chance.
constexpr Eigen::Index kWords = 160;
// Bounds the time: 75 for each word.
constexpr Eigen::Index kTrainingFeatures = 12000;
constexpr int kRounds = 8;  // Of k-means; bounds the time.

// For each feature the word closest to it.
std::vector<Eigen::Index> closest_words(const LocalFeatures& features, const LocalFeatures& words) {
  const Eigen::VectorXf squares = words.colwise().squaredNorm().transpose();
  std::vector<Eigen::Index> closest(static_cast<std::size_t>(features.cols()));
  for (Eigen::Index i = 0; i < features.cols(); ++i)
    (squares - 2.0f * (words.transpose() * features.col(i)))
        .minCoeff(&closest[static_cast<std::size_t>(i)]);
  return closest;
}

LocalFeatures training_set(const std::vector<const LocalFeatures*>& views) {
  Eigen::Index total = 0, rows = 0;
  for (const auto* view : views) {
    total += view->cols();
    if (view->cols() > 0) rows = view->rows();
  }
  const Eigen::Index stride = std::max<Eigen::Index>(1, total / kTrainingFeatures);
  LocalFeatures set(rows, total == 0 ? 0 : (total + stride - 1) / stride);
  Eigen::Index passed = 0;
  for (const auto* view : views)
    for (Eigen::Index i = 0; i < view->cols(); ++i, ++passed)
      if (passed % stride == 0) set.col(passed / stride) = view->col(i);
  return set;
}

// Lloyd's k-means from evenly spread features.
LocalFeatures vocabulary(const LocalFeatures& training) {
  const Eigen::Index count = std::min(kWords, training.cols());
  LocalFeatures words(training.rows(), count);
  for (Eigen::Index w = 0; w < count; ++w) words.col(w) = training.col(w * training.cols() / count);
  for (int round = 0; round < kRounds; ++round) {
    const auto closest = closest_words(training, words);
    LocalFeatures sums = LocalFeatures::Zero(words.rows(), count);
    Eigen::VectorXf members = Eigen::VectorXf::Zero(count);
    for (Eigen::Index i = 0; i < training.cols(); ++i) {
      const Eigen::Index w = closest[static_cast<std::size_t>(i)];
      sums.col(w) += training.col(i);
      ++members[w];
    }
    for (Eigen::Index w = 0; w < count; ++w)
      if (members[w] > 0.0f) words.col(w) = sums.col(w) / members[w];
  }
  return words;
}

// A column per view, of length 1: how much of it is of each kind, by the inverse frequency of the
// kind.
Eigen::MatrixXf weighted_counts(const std::vector<const LocalFeatures*>& views,
                                const LocalFeatures& words) {
  Eigen::MatrixXf counts =
      Eigen::MatrixXf::Zero(words.cols(), static_cast<Eigen::Index>(views.size()));
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (views[v]->cols() == 0) continue;
    auto column = counts.col(static_cast<Eigen::Index>(v));
    for (const Eigen::Index w : closest_words(*views[v], words)) ++column[w];
    column /= static_cast<float>(views[v]->cols());
  }
  const Eigen::VectorXf frequency = counts.rowwise().mean();
  for (Eigen::Index v = 0; v < counts.cols(); ++v) {
    counts.col(v) = (counts.col(v).array() / (frequency.array() + 1e-6f)).sqrt();
    if (counts.col(v).norm() > 0.0f) counts.col(v).normalize();
  }
  return counts;
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> rank_pairs(
    const std::vector<const LocalFeatures*>& views) {
  struct Ranked {
    std::size_t rank = 0;
    float similarity = 0.0f;
    std::size_t a = 0, b = 0;
  };
  const LocalFeatures training = training_set(views);
  Eigen::MatrixXf similarity = Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(views.size()),
                                                     static_cast<Eigen::Index>(views.size()));
  if (training.cols() > 0) {
    const auto counts = weighted_counts(views, vocabulary(training));
    similarity = counts.transpose() * counts;
  }
  const auto at = [&](std::size_t a, std::size_t b) {
    return similarity(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
  };
  std::vector<Ranked> ranked;
  for (std::size_t a = 0; a < views.size(); ++a) {
    for (std::size_t b = a + 1; b < views.size(); ++b) {
      std::size_t of_a = 0, of_b = 0;  // How many are more similar.
      for (std::size_t c = 0; c < views.size(); ++c) {
        if (c != a && at(a, c) > at(a, b)) ++of_a;
        if (c != b && at(b, c) > at(a, b)) ++of_b;
      }
      ranked.push_back({std::min(of_a, of_b), at(a, b), a, b});
    }
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const Ranked& x, const Ranked& y) {
    return x.rank != y.rank ? x.rank < y.rank : x.similarity > y.similarity;
  });
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const Ranked& pair : ranked) pairs.emplace_back(pair.a, pair.b);
  return pairs;
}

}  // namespace relief::registration
