#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// A closed path along the edges of a mesh, each vertex once. Cutting a closed mesh along it does
/// not part it, so the path runs round a handle or through it.
struct HandleLoop {
  std::vector<std::uint32_t> vertices;
  double length = 0.0;  ///< Where not along marked vertices, it counts more [unit].
};

using AcceptLoop = std::function<bool(const HandleLoop&)>;

/// A short loop of a handle of a patch, of those that `accept` takes: the shortest one of those
/// from vertices all over the patch that are independent of each other (Erickson and Whittlesey,
/// "Greedy optimal homotopy and homology generators", SODA 2005). Inside of the patch, along marked
/// vertices where it can. Nothing where there is none. `patch_faces` are joined by edges.
std::optional<HandleLoop> short_handle_loop(const TriangleMesh& mesh,
                                            std::span<const std::uint32_t> patch_faces,
                                            std::span<const std::uint8_t> marked,
                                            const AcceptLoop& accept);

}  // namespace relief::fusion
