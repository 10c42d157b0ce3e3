#pragma once

#include <string>
#include <vector>

#include "relief/scan/camera.h"
#include "relief/scan/discontinuities.h"
#include "relief/scan/range_view.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/units/content_hash.h"

namespace relief {

void hash_into(ContentHash& hash, const Ray& ray);
void hash_into(ContentHash& hash, const PinholeIntrinsics& intrinsics);
void hash_into(ContentHash& hash, const RationalProjection& projection);
void hash_into(ContentHash& hash, const SphericalProjection& projection);
void hash_into(ContentHash& hash, const Camera& camera);
void hash_into(ContentHash& hash, const TriangleMesh& mesh);
void hash_into(ContentHash& hash, const DiscontinuityOptions& options);

/// Hash of what a view measured: its rays and all its grids. Neither its name nor its pose.
std::string hash_of_samples(const RangeView& view);

/// Hash of a whole view, with its name and pose.
std::string hash_of_view(const RangeView& view);

/// The same of each of several views.
std::vector<std::string> hashes_of_views(const std::vector<RangeView>& views);

}  // namespace relief
