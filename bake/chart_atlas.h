// Chart atlas: texture coordinates for meshes that bring none of use, every triangle a chart of its own.
#pragma once

#include <glm/vec2.hpp>

#include "formats/mesh.h"
#include "formats/result.h"

namespace overcast {

/// Texels a side of the smallest square texture of a power of two that packTriangles can fill with so many triangles; at least 16.
int smallestAtlas(std::size_t triangles);

/// Gives `mesh` texture coordinates in which every triangle is a right triangle with its corners on the middles of texels, the two legs for
/// its two shorter edges, at about the same number of texels for a length wherever that is possible (a leg has at least one). Two triangles
/// share a rectangle; these fill shelves from the largest on. Between charts lie enough texels for bilinear sampling of one never to read
/// what stands for another. Vertices are split: every triangle has three of its own, in its order; what belongs to them is copied, baked
/// visibility and maps go. An Error without a file when they do not fit into side x side texels; it names the size that would do.
/// Deterministic.
Result<Mesh> packTriangles(const Mesh& mesh, int side);

}  // namespace overcast
