// Triangle: the exact squared distance from a point to one triangle, in double. Private to bake. Internal linkage and no branches: each
// distance kernel compiles its own copy for its instruction set and the compiler makes vectors of it.
#pragma once

namespace overcast {

/// Squared distance from `p` to the triangle a, b, c. Where the point projects inside, it is the distance to the plane, elsewhere the
/// distance to the nearest edge, which is that of a point on the triangle. A triangle lower than 1e-8 of its edges counts as its edges:
/// below that the rounding of the normal costs more than the area. Error at most about 1e-8 of the longest edge at that height, 1e-16 of it
/// at ordinary ones.
static inline double squaredDistanceToTriangle(const double (&p)[3], const double (&a)[3], const double (&b)[3], const double (&c)[3]) {
  constexpr double kLowest2 = 1e-16;
  const double ap[3] = {p[0] - a[0], p[1] - a[1], p[2] - a[2]};
  const double ab[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const double ac[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const double bp[3] = {p[0] - b[0], p[1] - b[1], p[2] - b[2]};
  const double bc[3] = {c[0] - b[0], c[1] - b[1], c[2] - b[2]};
  const auto dot = [](const double(&x)[3], const double(&y)[3]) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
  const double n[3] = {ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]};
  const double nn = dot(n, n);
  const double ab2 = dot(ab, ab);
  const double ac2 = dot(ac, ac);
  const double bc2 = dot(bc, bc);
  // The side of each edge: (edge x (p - start)) . n, written as p - start against n x edge.
  const auto side = [&](const double(&edge)[3], const double(&from)[3]) {
    const double inward[3] = {n[1] * edge[2] - n[2] * edge[1], n[2] * edge[0] - n[0] * edge[2], n[0] * edge[1] - n[1] * edge[0]};
    return dot(inward, from);
  };
  const bool above = (side(ab, ap) >= 0.0) & (side(ac, ap) <= 0.0) & (side(bc, bp) >= 0.0) & (nn > kLowest2 * ab2 * ac2);
  // One division serves the plane or edge ab: a vector division costs as much as all of the above.
  const double height = dot(n, ap);
  const double divisor = above ? nn : ab2;
  const double quotient = (above ? height * height : dot(ap, ab)) / (divisor > 0.0 ? divisor : 1.0);
  const auto toEdge = [&](const double(&from)[3], const double(&edge)[3], double share) {
    const double t = share > 0.0 ? (share < 1.0 ? share : 1.0) : 0.0;
    const double d[3] = {from[0] - t * edge[0], from[1] - t * edge[1], from[2] - t * edge[2]};
    return dot(d, d);
  };
  const double toAb = toEdge(ap, ab, quotient);
  const double toAc = toEdge(ap, ac, dot(ap, ac) / (ac2 > 0.0 ? ac2 : 1.0));
  const double toBc = toEdge(bp, bc, dot(bp, bc) / (bc2 > 0.0 ? bc2 : 1.0));
  const double least = toAc < toBc ? toAc : toBc;
  const double edges = toAb < least ? toAb : least;
  return above ? quotient : edges;
}

}  // namespace overcast
