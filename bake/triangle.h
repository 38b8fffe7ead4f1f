// Triangle: the exact squared distance from a point to one triangle, in double. Private to bake. Internal linkage and no branches: each
// distance kernel compiles its own copy for its instruction set and the compiler makes vectors of it.
#pragma once

namespace overcast {

/// Squared distance from `p` to the triangle a, b, c. Every candidate is the distance to a point that lies on the triangle, so that slivers
/// and degenerate triangles, whose normal is noise, can never come out nearer than they are.
static inline double squaredDistanceToTriangle(const double (&p)[3], const double (&a)[3], const double (&b)[3], const double (&c)[3]) {
  const double ap[3] = {p[0] - a[0], p[1] - a[1], p[2] - a[2]};
  const double ab[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const double ac[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const auto dot = [](const double(&x)[3], const double(&y)[3]) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
  const double bb = dot(ab, ab);
  const double bc = dot(ab, ac);
  const double cc = dot(ac, ac);
  const double pb = dot(ap, ab);
  const double pc = dot(ap, ac);
  // The point a + s ab + t ac, with s and t on each edge and inside.
  const auto squaredAt = [&](double s, double t) {
    const double d[3] = {ap[0] - s * ab[0] - t * ac[0], ap[1] - s * ab[1] - t * ac[1], ap[2] - s * ab[2] - t * ac[2]};
    return dot(d, d);
  };
  const auto share = [](double numerator, double denominator) {
    const double x = denominator > 0.0 ? numerator / denominator : 0.0;
    return x > 0.0 ? (x < 1.0 ? x : 1.0) : 0.0;
  };
  const double onBc = share(pc - pb + bb - bc, bb + cc - 2.0 * bc);
  const double edgeAb = squaredAt(share(pb, bb), 0.0);
  const double edgeAc = squaredAt(0.0, share(pc, cc));
  const double edgeBc = squaredAt(1.0 - onBc, onBc);
  const double determinant = bb * cc - bc * bc;
  const double s = cc * pb - bc * pc;
  const double t = bb * pc - bc * pb;
  const bool above = (s >= 0.0) & (t >= 0.0) & (s + t <= determinant) & (determinant > 0.0);
  const double divisor = above ? determinant : 1.0;
  const double inside = squaredAt(above ? s / divisor : 0.0, above ? t / divisor : 0.0);  // corner a where it is not above
  const double edges = edgeAb < edgeAc ? edgeAb : edgeAc;
  const double rest = edgeBc < inside ? edgeBc : inside;
  return edges < rest ? edges : rest;
}

}  // namespace overcast
