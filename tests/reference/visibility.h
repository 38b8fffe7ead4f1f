// Truth for visibility: every triangle for every ray, in double. Shares no code with what it checks.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast::reference {

/// Whether the ray from `origin` along each direction (of any length) meets a triangle in front of it (Moeller and Trumbore 1997). Parallel
/// over directions.
std::vector<char> blocked(const Mesh& mesh, const glm::dvec3& origin, std::span<const glm::dvec3> directions);

}  // namespace overcast::reference
