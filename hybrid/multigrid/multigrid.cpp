#include "hybrid/multigrid/multigrid.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/SparseCholesky>

#include "hybrid/multigrid/galerkin.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

// Of the coarsest level; bounds the time. Levels shrink about ninefold, so it has 67 to 600.
constexpr std::size_t kNodesSolvedDirectly = 600;
// Of one piece of work; they change no result.
constexpr std::size_t kRowsAtOnce = 24;     // of pixels; whole rows of groups
constexpr std::size_t kNodesAtOnce = 2048;  // of coarse levels
// Relaxation aims at the spectrum above this part: groups of three leave it waves below 6 samples,
// for a Laplacian (1 - cos(pi / 3)) / 4 = 0.125. Steps: docs/results.md, Steps of the solver.
constexpr double kSmoothed = 0.1;

// Two steps of Chebyshev iteration for the spectrum [kSmoothed, 1] largest (Saad 2003, 12.3):
//   x_1 = first D^-1 r,  x_2 = x_1 + keep (x_1 - x_0) + second D^-1 (r - A x_1).
struct Relaxation {
  explicit Relaxation(double largest) {
    const double centre = 0.5 * (1.0 + kSmoothed) * largest;
    const double half = 0.5 * (1.0 - kSmoothed) * largest;
    const double sigma = centre / half;
    const double rho = 1.0 / (2.0 * sigma - 1.0 / sigma);
    first = 1.0 / centre;
    keep = rho / sigma;
    second = 2.0 * rho / half;
    damping = 4.0 / 3.0 / largest;
  }
  double first, keep, second;
  double damping;  // of the interpolation
};

using Nodes = std::vector<Eigen::Vector3d>;

// The finest level.
class PixelLevel {
 public:
  using Vector = Planes<float>;
  // Every constraint couples two samples: no eigenvalue of D^-1 A exceeds two.
  static constexpr double kLargest = 2.0;

  explicit PixelLevel(const EdgeStencil& stencil) : stencil_(stencil), view_(stencil.view()) {}

  void refresh() { view_ = stencil_.view(); }
  Vector zero() const { return Vector(stencil_.grid().size()); }

  void scale(double b, const Vector& r, Vector& out) const {
    each_row([&](const auto& span) {
      scale_row(view_, static_cast<float>(b), r.view(), span.begin, span.end, out.view());
    });
  }
  void residual(const Vector& r, double c, const Vector& in, Vector& out) const {
    each_row([&](const auto& span) {
      residual_row(view_, r.view(), static_cast<float>(c), in.view(), span.begin, span.end,
                   out.view());
    });
  }
  void relax(double g, Vector& out, double a, const Vector& in, double b, const Vector* r) const {
    each_row([&](const auto& span) {
      relax_row(view_, static_cast<float>(g), static_cast<float>(a), in.view(),
                static_cast<float>(b), r ? r->view() : PlanesView<const float>{}, span.begin,
                span.end, out.view());
    });
  }

  void restrict(const Aggregates& groups, const Vector& fine, Nodes& coarse) const {
    each_row_of_groups(
        groups,
        [&](std::uint32_t first, std::uint32_t last) {
          std::fill(coarse.begin() + first, coarse.begin() + last, Eigen::Vector3d::Zero());
        },
        [&](std::size_t i, std::uint32_t k, const Transport& motion) {
          const double x = fine.x[i];
          coarse[k] += Eigen::Vector3d(motion.scale * x, fine.bu[i] + motion.along_u * x,
                                       fine.bv[i] + motion.along_v * x);
        });
  }
  void prolong(const Aggregates& groups, const Nodes& coarse, Vector& fine) const {
    each_row_of_groups(
        groups, [](std::uint32_t, std::uint32_t) {},
        [&](std::size_t i, std::uint32_t k, const Transport& motion) {
          const Eigen::Vector3d& c = coarse[k];
          fine.x[i] = static_cast<float>(motion.scale * c[0] + motion.along_u * c[1] +
                                         motion.along_v * c[2]);
          fine.bu[i] = static_cast<float>(c[1]);
          fine.bv[i] = static_cast<float>(c[2]);
        });
  }

 private:
  template <typename Body>
  void each_row(const Body& body) const {
    parallel_for(stencil_.spans().size(), kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) body(stencil_.spans()[v]);
    });
  }
  // A row of groups is three rows of pixels: no two threads meet in one group.
  template <typename Start, typename Body>
  void each_row_of_groups(const Aggregates& groups, const Start& start, const Body& body) const {
    parallel_for(groups.rows.size() - 1, kRowsAtOnce / 3, [&](std::size_t begin, std::size_t end) {
      start(groups.rows[begin], groups.rows[end]);
      const std::size_t last = std::min(3 * end, stencil_.spans().size());
      for (std::size_t v = 3 * begin; v < last; ++v) {
        const RowSpan span = stencil_.spans()[v];
        for (std::size_t i = span.begin; i < span.end; ++i) {
          const std::uint32_t k = groups.label[i];
          if (k != kNoAggregate) body(i, k, groups.from_root[i]);
        }
      }
    });
  }

  const EdgeStencil& stencil_;
  StencilView view_;
};

// A coarser level.
class NodeLevel {
 public:
  using Vector = Nodes;

  NodeLevel(CoarseMatrix matrix, Aggregates nodes)
      : matrix_(std::move(matrix)), nodes_(std::move(nodes)) {}

  const Aggregates& nodes() const { return nodes_; }
  // Only the grouping of the next level needs them.
  void drop_bonds() { nodes_.bonds = {}; }
  const CoarseMatrix& matrix() const { return matrix_; }
  std::size_t size() const { return nodes_.nodes.size(); }
  Vector zero() const { return Vector(size(), Eigen::Vector3d::Zero()); }

  // Power iteration from a fixed irregular vector, with a margin.
  double largest_eigenvalue() const {
    Vector x = zero(), image = zero();
    for (std::size_t i = 0; i < size(); ++i) {
      const auto k = static_cast<double>(i % 10007);
      x[i] = {std::sin(1.0 + 12.9898 * k), std::sin(2.0 + 78.233 * k), std::sin(3.0 + 37.719 * k)};
    }
    double largest = 1.0;
    for (int step = 0; step < 12; ++step) {
      relax(0.0, image, 0.0, x, -1.0, nullptr);  // D^-1 A x
      const double before = norm(x), after = norm(image);
      if (!(after > 0.0) || !std::isfinite(after)) break;
      largest = after / before;
      for (std::size_t i = 0; i < size(); ++i) x[i] = image[i] / after;
    }
    return 1.1 * largest;
  }

  void scale(double b, const Vector& r, Vector& out) const {
    each_node([&](std::size_t i) { out[i].noalias() = b * (matrix_.inverse[i] * r[i]); });
  }
  void residual(const Vector& r, double c, const Vector& in, Vector& out) const {
    each_node([&](std::size_t i) { out[i] = r[i] + c * product(i, in); });
  }
  void relax(double g, Vector& out, double a, const Vector& in, double b, const Vector* r) const {
    each_node([&](std::size_t i) {
      const Eigen::Vector3d rest = (r ? (*r)[i] : Eigen::Vector3d::Zero()) - product(i, in);
      const Eigen::Vector3d step = b * (matrix_.inverse[i] * rest) + a * in[i];
      out[i] = g == 0.0 ? step : (g * out[i] + step).eval();
    });
  }

  void restrict(const Aggregates& groups, const Vector& fine, Nodes& coarse) const {
    each_row_of_groups(groups, [&](std::size_t begin, std::size_t end) {
      std::fill(coarse.begin() + groups.rows[begin], coarse.begin() + groups.rows[end],
                Eigen::Vector3d::Zero());
      for (std::size_t i = first_of_row(3 * begin); i < first_of_row(3 * end); ++i) {
        const std::uint32_t k = groups.label[i];
        if (k == kNoAggregate) continue;
        const Transport& motion = groups.from_root[i];
        const double x = fine[i][0];
        coarse[k] += Eigen::Vector3d(motion.scale * x, fine[i][1] + motion.along_u * x,
                                     fine[i][2] + motion.along_v * x);
      }
    });
  }
  void prolong(const Aggregates& groups, const Nodes& coarse, Vector& fine) const {
    each_row_of_groups(groups, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = first_of_row(3 * begin); i < first_of_row(3 * end); ++i) {
        const std::uint32_t k = groups.label[i];
        fine[i].setZero();
        if (k == kNoAggregate) continue;
        const Transport& motion = groups.from_root[i];
        const Eigen::Vector3d& c = coarse[k];
        fine[i] << motion.scale * c[0] + motion.along_u * c[1] + motion.along_v * c[2], c[1], c[2];
      }
    });
  }

 private:
  std::size_t first_of_row(std::size_t row) const {
    return nodes_.rows[std::min(row, nodes_.rows.size() - 1)];
  }
  template <typename Body>
  void each_row_of_groups(const Aggregates& groups, const Body& body) const {
    parallel_for(groups.rows.size() - 1, 16, body);
  }
  Eigen::Vector3d product(std::size_t i, const Vector& in) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    matrix_.matrix.for_each_block(
        i, [&](std::uint32_t j, const auto& block) { sum.noalias() += block * in[j]; });
    return sum;
  }
  template <typename Body>
  void each_node(const Body& body) const {
    parallel_for(size(), kNodesAtOnce, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) body(i);
    });
  }
  static double norm(const Vector& x) {
    double sum = 0.0;
    for (const auto& value : x) sum += value.squaredNorm();
    return std::sqrt(sum);
  }

  CoarseMatrix matrix_;
  Aggregates nodes_;
};

using Factor = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>;

bool factorise(const BlockMatrix& matrix, Factor& factor) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < matrix.rows(); ++i) {
    matrix.for_each_block(i, [&](std::uint32_t j, const auto& block) {
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          entries.emplace_back(static_cast<int>(3 * i) + r, static_cast<int>(3 * j) + c,
                               block(r, c));
    });
  }
  const auto size = static_cast<Eigen::Index>(3 * matrix.rows());
  Eigen::SparseMatrix<double> assembled(size, size);
  assembled.setFromTriplets(entries.begin(), entries.end());
  factor.compute(assembled);
  return factor.info() == Eigen::Success;
}

// What a level keeps from one cycle to the next.
template <typename Level>
struct Workspace {
  explicit Workspace(const Level& level) : step(level.zero()), rest(level.zero()) {}
  typename Level::Vector step, rest;
};

}  // namespace

struct Multigrid::Hierarchy {
  struct Coarse {
    explicit Coarse(NodeLevel of)
        : level(std::move(of)),
          relaxation(level.largest_eigenvalue()),
          work(level),
          rhs(level.zero()),
          x(level.zero()) {}
    NodeLevel level;
    Relaxation relaxation;
    Workspace<NodeLevel> work;
    Nodes rhs, x;
  };

  explicit Hierarchy(const EdgeStencil& stencil)
      : finest(stencil), relaxation(PixelLevel::kLargest), work(finest) {
    Aggregates groups = aggregate_pixels(stencil);
    CoarseMatrix matrix = coarsen(stencil, groups, relaxation.damping);
    coarse.emplace_back(NodeLevel(std::move(matrix), std::move(groups)));
    while (coarse.back().level.size() > kNodesSolvedDirectly) {
      const NodeLevel& below = coarse.back().level;
      Aggregates next = aggregate_nodes(below.nodes());
      if (next.nodes.empty() || 10 * next.nodes.size() > 9 * below.size()) break;
      CoarseMatrix product =
          coarsen(below.matrix(), below.nodes().rows, next, coarse.back().relaxation.damping);
      coarse.emplace_back(NodeLevel(std::move(product), std::move(next)));
    }
    for (Coarse& level : coarse) level.level.drop_bonds();
    release_freed_memory();
    usable = factorise(coarse.back().level.matrix().matrix, factor);
  }

  // One V-cycle from x = 0, symmetric: relax, correct from the next level through
  // P = (1 - damping D^-1 A) P0, relax.
  template <typename Level>
  void cycle(const Level& level, const Relaxation& relaxation_of, Workspace<Level>& work_of,
             const typename Level::Vector& r, typename Level::Vector& x, std::size_t next) {
    auto& [step, rest] = work_of;
    const Relaxation& c = relaxation_of;
    level.scale(c.first, r, step);
    level.relax(0.0, x, 1.0 + c.keep, step, c.second, &r);
    level.residual(r, -1.0, x, rest);
    level.scale(c.damping, rest, step);
    level.residual(rest, -1.0, step, rest);
    Coarse& below = coarse[next];
    level.restrict(below.level.nodes(), rest, below.rhs);
    solve(next);
    level.prolong(below.level.nodes(), below.x, step);
    level.relax(1.0, x, 1.0, step, c.damping, nullptr);
    level.relax(0.0, step, 1.0, x, c.first, &r);
    level.relax(-c.keep, x, 1.0 + c.keep, step, c.second, &r);
  }

  // coarse[k].x = approximately A_k^-1 coarse[k].rhs.
  void solve(std::size_t k) {
    Coarse& here = coarse[k];
    if (k + 1 < coarse.size())
      return cycle(here.level, here.relaxation, here.work, here.rhs, here.x, k + 1);
    const auto size = static_cast<Eigen::Index>(3 * here.rhs.size());
    Eigen::Map<Eigen::VectorXd>(here.x.data()->data(), size) =
        factor.solve(Eigen::Map<const Eigen::VectorXd>(here.rhs.data()->data(), size));
  }

  PixelLevel finest;
  Relaxation relaxation;
  Workspace<PixelLevel> work;
  std::vector<Coarse> coarse;
  Factor factor;
  bool usable = false;
};

Multigrid::Multigrid(const EdgeStencil& stencil)
    : hierarchy_(std::make_unique<Hierarchy>(stencil)) {}
Multigrid::~Multigrid() = default;
Multigrid::Multigrid(Multigrid&&) noexcept = default;

bool Multigrid::usable() const { return hierarchy_->usable; }
int Multigrid::levels() const { return static_cast<int>(hierarchy_->coarse.size()) + 1; }

void Multigrid::refresh() { hierarchy_->finest.refresh(); }

void Multigrid::apply(const Planes<float>& r, Planes<float>& x) {
  Hierarchy& h = *hierarchy_;
  h.cycle(h.finest, h.relaxation, h.work, r, x, 0);
}

}  // namespace relief::hybrid
