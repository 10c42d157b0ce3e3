#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "relief/scan/triangle_mesh.h"

namespace relief {

struct SelfIntersections {
  /// Pairs (f, g) of faces, f < g, in ascending order; at most `limit`.
  std::vector<std::array<std::uint32_t, 2>> pairs;
  bool complete = true;  ///< False: there may be more pairs than those listed.

  /// The faces in any of the pairs, in ascending order.
  std::vector<std::uint32_t> faces() const;
};

/// What a mesh is, counted from its vertices and faces alone. Edges are compared by vertex index:
/// two vertices at one place are two vertices (and counted as duplicates).
struct MeshCheck {
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::size_t edges = 0;                  ///< Distinct undirected edges.
  std::size_t boundary_edges = 0;         ///< Edges of one face only.
  std::size_t non_manifold_edges = 0;     ///< Edges of more than two faces.
  std::size_t inconsistent_edges = 0;     ///< Edges that their two faces run in the same direction.
  std::size_t non_manifold_vertices = 0;  ///< Vertices whose faces form more than one fan.
  std::size_t unused_vertices = 0;        ///< Vertices without a face.
  std::size_t degenerate_faces = 0;       ///< Faces with a repeated vertex or without area.
  std::size_t duplicate_vertices = 0;     ///< Vertices at exactly the place of an earlier one.
  std::size_t invalid_faces = 0;        ///< Faces with an index out of range; left out of all else.
  std::size_t non_finite_vertices = 0;  ///< Vertices with a coordinate that is no number.
  std::size_t components = 0;           ///< Sets of faces connected through common vertices.
  long genus = -1;      ///< Handles of all components together; -1 unless a closed manifold.
  double volume = 0.0;  ///< Signed [unit^3]; positive when faces face outwards.
  /// Faces that cross, touch or cover others; nothing unless looked for. Vertices at one place
  /// count as one here.
  std::optional<SelfIntersections> self_intersections;

  /// Every edge has exactly two faces, which run it in opposite directions.
  bool closed() const;
  /// No edge has more than two faces and the faces at each vertex form one fan.
  bool manifold() const;
  /// A valid solid: closed, manifold, without degenerate faces, duplicate, unused or non-finite
  /// vertices, not empty, of positive volume. Self-intersections have no part in it.
  bool watertight() const;
};

struct MeshCheckOptions {
  /// Also look for self-intersections. This takes about twice as long as all the rest together.
  bool self_intersections = false;
};

/// Counts in memory linear (about 120 bytes a vertex of a closed mesh, which lie as its vertices
/// do) and time log-linear in the size of the mesh, which has less than 2^32 / 3 faces.
MeshCheck check_mesh(const TriangleMesh& mesh, const MeshCheckOptions& options = {});

/// The check of a mesh, without self-intersections, in a quarter of the time: `before` is that of
/// the same faces with their vertices at other places.
MeshCheck check_moved_vertices(const TriangleMesh& mesh, MeshCheck before);

struct SelfIntersectionOptions {
  /// The search ends soon after so many pairs are found. >= 1.
  std::size_t limit = 1000000;
};

/// All pairs of faces with a common point that is not on a corner or an edge of both: faces that
/// cross, touch, or lie over each other. Exact for the given doubles (see triangle_overlap.h).
/// Vertices at exactly one place count as one, so that it does not matter whether a mesh is welded.
/// Faces with exactly collinear corners, a vertex that is not finite, or an index out of range have
/// no part in it. Takes about two seconds of one core per million faces.
SelfIntersections find_self_intersections(const TriangleMesh& mesh,
                                          const SelfIntersectionOptions& options = {});

}  // namespace relief
