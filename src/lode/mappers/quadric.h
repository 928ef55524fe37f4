// Garland and Heckbert, Surface Simplification Using Quadric Error Metrics (1997): the sum of
// squared distances to planes. Here it only says what is collapsed first; no bound rests on it.
#pragma once

#include "lode/core/vec.h"

namespace lode::simplification {

/// x -> x'Ax + 2b'x + c: the squared distances from x to planes, weighted and added up.
struct Quadric {
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;  ///< A.
  float bx = 0, by = 0, bz = 0, c = 0;

  void add(const Quadric& q) {
    xx += q.xx, xy += q.xy, xz += q.xz, yy += q.yy, yz += q.yz, zz += q.zz;
    bx += q.bx, by += q.by, bz += q.bz, c += q.c;
  }
  [[nodiscard]] float at(const Vec3f& p) const {
    const float x = p[0] * xx + 2 * (p[1] * xy + p[2] * xz + bx);
    const float y = p[1] * yy + 2 * (p[2] * yz + by);
    const float z = p[2] * zz + 2 * bz;
    return p[0] * x + p[1] * y + p[2] * z + c;
  }
};

/// Of the plane through p with unit normal n.
[[nodiscard]] inline Quadric plane_quadric(const Vec3f& n, const Vec3f& p, float weight) {
  const float d = -dot(n, p);
  const Vec3f w = weight * n;
  return {w[0] * n[0], w[0] * n[1], w[0] * n[2], w[1] * n[1], w[1] * n[2],
          w[2] * n[2], d * w[0],    d * w[1],    d * w[2],    weight * d * d};
}

/// Where q is least, as far as it says: along directions that it is nearly constant in, near p.
[[nodiscard]] inline Vec3f minimum_near(const Quadric& q, const Vec3f& p) {
  const double e = 2e-3 * (static_cast<double>(q.xx) + q.yy + q.zz);
  const double xx = q.xx + e;
  const double yy = q.yy + e;
  const double zz = q.zz + e;
  const double xy = q.xy;
  const double xz = q.xz;
  const double yz = q.yz;
  const double gx = -(q.xx * p[0] + q.xy * p[1] + q.xz * p[2] + q.bx);
  const double gy = -(q.xy * p[0] + q.yy * p[1] + q.yz * p[2] + q.by);
  const double gz = -(q.xz * p[0] + q.yz * p[1] + q.zz * p[2] + q.bz);
  const double cxx = yy * zz - yz * yz;
  const double cxy = xz * yz - xy * zz;
  const double cxz = xy * yz - xz * yy;
  const double determinant = xx * cxx + xy * cxy + xz * cxz;
  if (!(determinant > 0)) return p;
  const double cyy = xx * zz - xz * xz;
  const double cyz = xy * xz - xx * yz;
  const double czz = xx * yy - xy * xy;
  const double r = 1 / determinant;
  return {{p[0] + static_cast<float>(r * (cxx * gx + cxy * gy + cxz * gz)),
           p[1] + static_cast<float>(r * (cxy * gx + cyy * gy + cyz * gz)),
           p[2] + static_cast<float>(r * (cxz * gx + cyz * gy + czz * gz))}};
}

}  // namespace lode::simplification
