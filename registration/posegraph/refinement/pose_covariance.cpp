#include "registration/posegraph/refinement/pose_covariance.h"

#include <cassert>
#include <utility>

#include "registration/posegraph/pose_step.h"

namespace relief::registration {

namespace {

// A view's rows of A^-1.
std::vector<Matrix6d> rows_of(const PoseGraphProblem& information, std::size_t view,
                              std::size_t views) {
  std::vector<Matrix6d> rows;
  for (std::size_t i = 0; i < views; ++i) rows.push_back(information.inverse(view, i));
  return rows;
}

std::vector<Matrix6d> times(const std::vector<Matrix6d>& rows, const SymmetricBlocks& blocks) {
  std::vector<Matrix6d> product(rows.size(), Matrix6d::Zero());
  for (const auto& [place, block] : blocks) {
    const auto [row, column] = place;
    product[column].noalias() += rows[row] * block;
    if (row != column) product[row].noalias() += rows[column] * block.transpose();
  }
  return product;
}

}  // namespace

PoseCovariance::PoseCovariance(PoseGraphProblem information, SymmetricBlocks scatter,
                               std::vector<Eigen::Vector3d> centres)
    : parts_(std::make_shared<Parts>(
          Parts{std::move(information), {}, std::move(scatter), std::move(centres)})) {}

PoseCovariance::PoseCovariance(std::vector<Matrix6d> of_views, std::vector<Eigen::Vector3d> centres)
    : parts_(std::make_shared<Parts>(
          Parts{std::nullopt, std::move(of_views), {}, std::move(centres)})) {}

Matrix6d PoseCovariance::of(std::size_t view) const {
  const Matrix6d block = between(view, view);
  return 0.5 * (block + block.transpose());
}

Matrix6d PoseCovariance::between(std::size_t a, std::size_t b) const {
  if (!parts_) return Matrix6d::Zero();
  return tangents_about(parts_->centres[a]) * about_centre(a, b) *
         tangents_about(parts_->centres[b]).transpose();
}

Matrix6d PoseCovariance::about_centre(std::size_t a, std::size_t b) const {
  if (!parts_->information) {
    assert(a == b);
    return parts_->of_views[a];
  }
  const PoseGraphProblem& information = *parts_->information;
  const std::size_t views = parts_->centres.size();
  const auto half = times(rows_of(information, a, views), parts_->scatter);
  Matrix6d block = Matrix6d::Zero();
  for (std::size_t i = 0; i < views; ++i) block.noalias() += half[i] * information.inverse(i, b);
  return block;
}

}  // namespace relief::registration
