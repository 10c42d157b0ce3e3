#include "scan/mesh/exact_predicates.h"

#include <array>
#include <cmath>
#include <limits>

namespace relief {

namespace {

// Half a unit in the last place of 1: the relative error of one rounded operation.
constexpr double kRounding = 0.5 * std::numeric_limits<double>::epsilon();

// A value and what rounding took from it: their sum is exact.
struct Rounded {
  double value, rest;
};

Rounded exact_sum(double a, double b) {
  const double sum = a + b, b_part = sum - a, a_part = sum - b_part;
  return {sum, (a - a_part) + (b - b_part)};
}

// The same when |a| >= |b| or a is 0.
Rounded exact_ordered_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

Rounded exact_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

// A number as an exact sum of at most N doubles, in order of magnitude and not overlapping in their
// bits, so that the last has the sign of the whole (Shewchuk 1997). Zeros are left out: exact
// differences of neighbouring coordinates then cost one term.
template <int N>
class Expansion {
 public:
  void append(double term) {
    if (term != 0.0) terms_[size_++] = term;
  }

  // Shewchuk's GROW-EXPANSION, in place: what is written was read before.
  void add(double number) {
    const int old_size = size_;
    size_ = 0;
    for (int i = 0; i < old_size; ++i) {
      const Rounded sum = exact_sum(number, terms_[i]);
      append(sum.rest);
      number = sum.value;
    }
    append(number);
  }

  int size() const { return size_; }
  double term(int i) const { return terms_[i]; }
  int sign() const { return size_ == 0 ? 0 : terms_[size_ - 1] > 0.0 ? 1 : -1; }

 private:
  std::array<double, N> terms_;
  int size_ = 0;
};

Expansion<2> difference(double a, double b) {
  const Rounded rounded = exact_sum(a, -b);
  Expansion<2> result;
  result.append(rounded.rest);
  result.append(rounded.value);
  return result;
}

template <int N, int M>
Expansion<N + M> combined(const Expansion<N>& a, const Expansion<M>& b, double sign_of_b) {
  Expansion<N + M> result;
  for (int i = 0; i < a.size(); ++i) result.append(a.term(i));
  for (int i = 0; i < b.size(); ++i) result.add(sign_of_b * b.term(i));
  return result;
}

template <int N, int M>
Expansion<N + M> operator+(const Expansion<N>& a, const Expansion<M>& b) {
  return combined(a, b, 1.0);
}

template <int N, int M>
Expansion<N + M> operator-(const Expansion<N>& a, const Expansion<M>& b) {
  return combined(a, b, -1.0);
}

// Shewchuk's SCALE-EXPANSION.
template <int N>
Expansion<2 * N> scaled(const Expansion<N>& a, double factor) {
  Expansion<2 * N> result;
  if (a.size() == 0) return result;
  Rounded carry = exact_product(a.term(0), factor);
  result.append(carry.rest);
  for (int i = 1; i < a.size(); ++i) {
    const Rounded product = exact_product(a.term(i), factor);
    const Rounded low = exact_sum(carry.value, product.rest);
    result.append(low.rest);
    carry = exact_ordered_sum(product.value, low.value);
    result.append(carry.rest);
  }
  result.append(carry.value);
  return result;
}

template <int N>
Expansion<4 * N> operator*(const Expansion<N>& a, const Expansion<2>& b) {
  Expansion<4 * N> result;
  for (int j = 0; j < b.size(); ++j) {
    const auto product = scaled(a, b.term(j));
    for (int i = 0; i < product.size(); ++i) result.add(product.term(i));
  }
  return result;
}

// The sign of det(a - p, b - p, c - p).
int exact_sign(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
               const Eigen::Vector3d& p) {
  const auto ax = difference(a.x(), p.x()), ay = difference(a.y(), p.y()),
             az = difference(a.z(), p.z());
  const auto bx = difference(b.x(), p.x()), by = difference(b.y(), p.y()),
             bz = difference(b.z(), p.z());
  const auto cx = difference(c.x(), p.x()), cy = difference(c.y(), p.y()),
             cz = difference(c.z(), p.z());
  const auto determinant =
      (by * cz - bz * cy) * ax + (bz * cx - bx * cz) * ay + (bx * cy - by * cx) * az;
  return determinant.sign();
}

int sign(double value) { return value > 0.0 ? 1 : -1; }

}  // namespace

int side_of_plane(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                  const Eigen::Vector3d& p) {
  const Eigen::Vector3d u = a - p, v = b - p, w = c - p;
  const double vw_x = v.y() * w.z(), wv_x = v.z() * w.y();
  const double vw_y = v.z() * w.x(), wv_y = v.x() * w.z();
  const double vw_z = v.x() * w.y(), wv_z = v.y() * w.x();
  const double determinant = u.x() * (vw_x - wv_x) + u.y() * (vw_y - wv_y) + u.z() * (vw_z - wv_z);
  const double permanent = std::abs(u.x()) * (std::abs(vw_x) + std::abs(wv_x)) +
                           std::abs(u.y()) * (std::abs(vw_y) + std::abs(wv_y)) +
                           std::abs(u.z()) * (std::abs(vw_z) + std::abs(wv_z));
  // Shewchuk 1997, the first stage of ORIENT3D: rounding cannot have changed a larger value's sign.
  const double uncertain = (7.0 + 56.0 * kRounding) * kRounding * permanent;
  // det(a - p, b - p, c - p) is negative where the normal points to.
  if (std::abs(determinant) > uncertain) return -sign(determinant);
  if (p == a || p == b || p == c) return 0;  // As faces with common corners ask, often.
  return -exact_sign(a, b, c, p);
}

int side_of_line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  const double left = (a.x() - p.x()) * (b.y() - p.y());
  const double right = (a.y() - p.y()) * (b.x() - p.x());
  const double determinant = left - right;
  const double uncertain =
      (3.0 + 16.0 * kRounding) * kRounding * (std::abs(left) + std::abs(right));
  if (std::abs(determinant) > uncertain) return sign(determinant);
  return (difference(a.x(), p.x()) * difference(b.y(), p.y()) -
          difference(a.y(), p.y()) * difference(b.x(), p.x()))
      .sign();
}

}  // namespace relief
