// Decompositions of Eigen, compiled in one place: each takes seconds to compile wherever it is
// used.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "relief/scan/rigid_motion.h"

namespace relief {

/// Eigenvalues, ascending, and eigenvectors of a symmetric matrix. Its lower half is read.
Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen_decomposition(
    const Eigen::Matrix3d& symmetric);
Eigen::SelfAdjointEigenSolver<Matrix6d> eigen_decomposition(const Matrix6d& symmetric);
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_decomposition(
    const Eigen::MatrixXd& symmetric);

/// x of A x = b for a symmetric A, by its factors L D L^T with pivoting. Directions in which A is 0
/// get 0.
Eigen::Vector3d solve_symmetric(const Eigen::Matrix3d& a, const Eigen::Vector3d& b);
Vector6d solve_symmetric(const Matrix6d& a, const Vector6d& b);
Matrix6d solve_symmetric(const Matrix6d& a, const Matrix6d& b);
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The same by Cholesky factors; nothing where A is not positive definite.
std::optional<Eigen::VectorXd> solve_positive_definite(const Eigen::MatrixXd& a,
                                                       const Eigen::VectorXd& b);

}  // namespace relief
