#include "relief/hybrid/polish_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "hybrid/mesh/mesh_graph.h"
#include "hybrid/mesh/mesh_guard.h"
#include "hybrid/mesh/mesh_preconditioner.h"
#include "hybrid/mesh/mesh_solver.h"
#include "hybrid/mesh/mesh_system.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"
#include "scan/base/stopwatch.h"

namespace relief::hybrid {

namespace {

// A round of reweighting that moved the surface by less than this part of its expected errors is
// the last: it adds 0.05 % to them in quadrature. Refined views take two or three rounds.
constexpr double kSettled = 0.03;

Result<void> check(const TriangleMesh& mesh, const MeshNormals& normals,
                   const PolishOptions& options) {
  const auto bad = [](const std::string& what) { return Error{ErrorKind::kBadInput, what}; };
  const std::size_t count = mesh.vertices.size();
  if (options.sigma_position && !(*options.sigma_position > 0.0))
    return bad("polish: sigma_position must be positive");
  if (options.sigma_normal && !(*options.sigma_normal > 0.0))
    return bad("polish: sigma_normal must be positive");
  if (!(options.tangential > 0.0)) return bad("polish: tangential must be positive");
  if (options.robust_rounds < 0) return bad("polish: robust_rounds must not be negative");
  if (!(options.tolerance > 0.0 && options.tolerance < 1.0))
    return bad("polish: tolerance must lie between 0 and 1");
  if (options.max_iterations < 1) return bad("polish: max_iterations must be positive");
  if (normals.normals.size() != count || normals.sigma.size() != count ||
      normals.views.size() != count)
    return bad("polish: the normals are not those of the mesh's vertices");
  if (!mesh.quality.empty() && mesh.quality.size() != count)
    return bad("polish: the mesh has another number of qualities than vertices");
  bool in_range = true, finite = true;
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    for (const std::uint32_t v : mesh.faces[f]) in_range = in_range && v < count;
  });
  serial_for(count, [&](std::size_t v) { finite = finite && mesh.vertices[v].allFinite(); });
  if (!in_range) return bad("polish: a face names a vertex that is not there");
  if (!finite) return bad("polish: a vertex of the mesh is not finite");
  return {};
}

Error interrupted() { return {ErrorKind::kInterrupted, "polishing the mesh was interrupted"}; }

bool normals_meet(const TriangleMesh& mesh, const MeshNormals& normals) {
  return std::any_of(mesh.faces.begin(), mesh.faces.end(), [&](const auto& face) {
    int measured = 0;
    for (const std::uint32_t v : face) measured += normals.views[v] > 0;
    return measured >= 2;
  });
}

// One linear system after the other, reweighted by what the last one left.
class Solve {
 public:
  Solve(MeshSystem& system, const MeshGraph& graph, const PolishOptions& options)
      : system_(system), options_(options), matrix_(system.normal_matrix()), inverse_(matrix_) {
    const std::size_t count = graph.vertices();
    displacements_ = MeshValues(options.form == MeshForm::kFull ? 3 * count : count);
  }

  // False when the solver gave up.
  bool round() {
    if (rounds_ > 0) {
      system_.reweight(displacements_);
      matrix_ = {};  // Two of them would be large.
      matrix_ = system_.normal_matrix();
    }
    if (!inverse_.update()) return false;
    const LinearMap inverse = [&](const MeshValues& r) { return inverse_(r); };
    MeshValues before = copy_of(displacements_);
    ConjugateGradients solve;
    if (options_.form == MeshForm::kFull) {
      solve = conjugate_gradients(
          [&](const MeshValues& d) { return system_.full_product(d); },
          [&](const MeshValues& r) { return system_.full_precondition(inverse, r); },
          system_.full_rhs(), options_.tolerance, options_.max_iterations, displacements_);
    } else {
      solve = conjugate_gradients([&](const MeshValues& x) { return matrix_ * x; }, inverse,
                                  system_.normal_rhs(), options_.tolerance, options_.max_iterations,
                                  displacements_);
    }
    ++rounds_;
    iterations_ += solve.iterations;
    settled_ = system_.in_errors(displacements_, before) <= kSettled;
    if (!all_finite(displacements_)) displacements_ = std::move(before);
    return solve.converged;
  }

  bool settled() const { return settled_; }
  const MeshValues& displacements() const { return displacements_; }
  int rounds() const { return rounds_; }
  int iterations() const { return iterations_; }

 private:
  MeshSystem& system_;
  const PolishOptions& options_;
  MeshMatrix matrix_;
  MeshPreconditioner inverse_;
  MeshValues displacements_;
  int rounds_ = 0, iterations_ = 0;
  bool settled_ = false;
};

// Displacements in space. What the solve took is gone afterwards.
Result<MeshMoves> least_squares(const TriangleMesh& mesh, const MeshNormals& normals,
                                const PolishOptions& options, const Progress& progress,
                                PolishedMesh& polished) {
  const MeshGraph graph = mesh_graph(mesh);
  MeshSystem system(mesh, graph, normals,
                    {options.sigma_position.value_or(0.0), options.sigma_normal.value_or(0.0),
                     options.tangential});
  Solve solve(system, graph, options);
  while (solve.rounds() <= options.robust_rounds && !solve.settled()) {
    const double done = static_cast<double>(solve.rounds()) / (options.robust_rounds + 1.0);
    if (!report_progress(progress, done, "polish")) return interrupted();
    if (solve.round()) continue;
    polished.status = PolishStatus::kNotConverged;
    break;
  }
  polished.rounds = solve.rounds();
  polished.iterations = solve.iterations();
  return system.in_space(solve.displacements());
}

TriangleMesh copy_of_all_but_vertices(const TriangleMesh& mesh) {
  TriangleMesh copy;
  copy.faces = paged_copy(mesh.faces);
  copy.quality = paged_copy(mesh.quality);
  copy.views = paged_copy(mesh.views);
  copy.source_views = paged_copy(mesh.source_views);
  copy.filled = paged_copy(mesh.filled);
  copy.colours = paged_copy(mesh.colours);
  return copy;
}

void take(GuardedMove move, const TriangleMesh& mesh, const MeshNormals& normals,
          PolishedMesh& polished) {
  double sum = 0.0, largest = 0.0;
  serial_for(move.vertices.size(), [&](std::size_t i) {
    const double moved = (move.vertices[i] - mesh.vertices[i]).squaredNorm();
    largest = std::max(largest, moved);
    if (normals.views[i] > 0) sum += moved;
  });
  polished.max_move = std::sqrt(largest);
  polished.rms_move =
      std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, polished.with_normal)));
  polished.damped = move.damped;
  polished.unmoved = move.unmoved;
  polished.mesh = copy_of_all_but_vertices(mesh);
  polished.mesh.vertices = std::move(move.vertices);
  polished.mesh.normals = vertex_normals(polished.mesh);
}

}  // namespace

std::string_view to_string(PolishStatus status) {
  switch (status) {
    case PolishStatus::kPolished:
      return "polished";
    case PolishStatus::kNoNormals:
      return "no normals";
    case PolishStatus::kMissingUncertainty:
      return "no expected errors";
    case PolishStatus::kNotConverged:
      return "not converged";
  }
  return "";
}

Result<PolishedMesh> polish_mesh(const TriangleMesh& mesh, MeshNormals normals,
                                 const PolishOptions& options, const Context& context) {
  return run_in(context, [&]() -> Result<PolishedMesh> {
    const Stopwatch watch;
    if (const auto ok = check(mesh, normals, options); !ok) return ok.error();
    PolishedMesh polished;
    polished.with_normal = normals.measured;
    polished.sigma_view = normals.sigma_view;
    const auto as_given = [&](PolishStatus status) {
      polished.mesh = mesh;
      polished.status = status;
      polished.seconds = watch.seconds();
      return std::move(polished);
    };
    if (!normals_meet(mesh, normals)) return as_given(PolishStatus::kNoNormals);
    if (mesh.quality.empty() && !options.sigma_position)
      return as_given(PolishStatus::kMissingUncertainty);

    const auto displacements = least_squares(mesh, normals, options, context.progress, polished);
    if (!displacements) return displacements.error();
    normals.edges = {};
    release_freed_memory();
    take(guarded_move(mesh, *displacements), mesh, normals, polished);
    if (!report_progress(context.progress, 1.0, "polish")) return interrupted();
    polished.seconds = watch.seconds();
    return polished;
  });
}

Result<PolishedMesh> polish_mesh(const TriangleMesh& mesh, const std::vector<RangeView>& views,
                                 const PolishOptions& options, const Context& context) {
  const Stopwatch watch;
  const auto half = [&](double first) {
    return context.with_progress([&context, first](double done, std::string_view step) {
      return report_progress(context.progress, first + 0.5 * done, step);
    });
  };
  auto normals = vertex_normals_from_views(mesh, views, options.normals, half(0.0));
  if (!normals) return normals.error();
  auto polished = polish_mesh(mesh, std::move(*normals), options, half(0.5));
  if (polished) polished->seconds = watch.seconds();
  return polished;
}

}  // namespace relief::hybrid
