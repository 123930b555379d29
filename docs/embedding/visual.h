/* A mesh of your own for the eye, such as one with textures, that follows the surface of an asset:
   its vertices are hung on the asset's triangles once, and moved at every frame by what
   palpate_deform answers. Order, texture coordinates and everything else of it stay yours. C99.

     palpate_hook* hook = malloc(vertices * sizeof *hook);
     palpate_hang(&mesh, place_m, vertices, hook);                    once; mesh: palpate_read_mesh
     palpate_deform(&asset, &copy_of_contact, 1, 0, mesh.vertices, displacement_m);
     palpate_follow(&mesh, displacement_m, hook, vertices, moved_m);  every frame */
#ifndef PALPATE_VISUAL_H
#define PALPATE_VISUAL_H

#include <math.h>

#include "palpate.h"

/* Where a vertex hangs: on a triangle, at area coordinates, and as far along its outward normal. */
typedef struct palpate_hook {
  int32_t triangle;
  float weight[3], offset_m;
} palpate_hook;

static inline double palpate_dot3(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Corner k of a triangle, moved by displacement_m (3 a vertex; null: at rest). */
static inline void palpate_corner(const palpate_mesh* mesh, const float* displacement_m,
                                  int32_t triangle, int k, double* out) {
  const int32_t v = mesh->triangle[3 * triangle + k];
  for (int i = 0; i < 3; ++i)
    out[i] = mesh->origin_m[i] + (double)mesh->vertex_m[3 * v + i] +
             (displacement_m ? (double)displacement_m[3 * v + i] : 0);
}

static inline void palpate_unit_normal(double corner[3][3], double* out) {
  double a[3], b[3], length;
  for (int i = 0; i < 3; ++i) {
    a[i] = corner[1][i] - corner[0][i];
    b[i] = corner[2][i] - corner[0][i];
  }
  for (int i = 0; i < 3; ++i)
    out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
  length = sqrt(palpate_dot3(out, out));
  for (int i = 0; i < 3; ++i) out[i] = length > 0 ? out[i] / length : 0;
}

/* Area coordinates of the place of a triangle nearest to x (Ericson, Real-Time Collision Detection,
   5.1.5), and its squared distance. */
static inline double palpate_nearest(double corner[3][3], const double* x, double* weight) {
  double ab[3], ac[3], ap[3], bp[3], cp[3], squared = 0;
  for (int i = 0; i < 3; ++i) {
    ab[i] = corner[1][i] - corner[0][i];
    ac[i] = corner[2][i] - corner[0][i];
    ap[i] = x[i] - corner[0][i];
    bp[i] = x[i] - corner[1][i];
    cp[i] = x[i] - corner[2][i];
  }
  const double d1 = palpate_dot3(ab, ap), d2 = palpate_dot3(ac, ap), d3 = palpate_dot3(ab, bp),
               d4 = palpate_dot3(ac, bp), d5 = palpate_dot3(ab, cp), d6 = palpate_dot3(ac, cp);
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  double v = 0, w = 0;
  if (d1 <= 0 && d2 <= 0) {
    v = w = 0;
  } else if (d3 >= 0 && d4 <= d3) {
    v = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    v = d1 / (d1 - d3);
  } else if (d6 >= 0 && d5 <= d6) {
    w = 1;
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    w = d2 / (d2 - d6);
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    v = 1 - w;
  } else {
    v = vb / (va + vb + vc);
    w = vc / (va + vb + vc);
  }
  weight[0] = 1 - v - w;
  weight[1] = v;
  weight[2] = w;
  for (int i = 0; i < 3; ++i) {
    const double off = ap[i] - v * ab[i] - w * ac[i];
    squared += off * off;
  }
  return squared;
}

/* Hangs each of `vertices` places [3 a vertex, in the body's frame] on the nearest triangle. Every
   triangle is looked at for every vertex: 0.25 s for 3,000 of each. */
static inline void palpate_hang(const palpate_mesh* mesh, const float* place_m, int32_t vertices,
                                palpate_hook* hook) {
  for (int32_t v = 0; v < vertices; ++v) {
    const double x[3] = {place_m[3 * v], place_m[3 * v + 1], place_m[3 * v + 2]};
    double least = INFINITY, corner[3][3], weight[3], normal[3];
    palpate_hook nearest = {0, {1, 0, 0}, 0};
    for (int32_t t = 0; t < mesh->triangles; ++t) {
      for (int k = 0; k < 3; ++k) palpate_corner(mesh, 0, t, k, corner[k]);
      const double squared = palpate_nearest(corner, x, weight);
      if (!(squared < least)) continue;
      least = squared;
      palpate_unit_normal(corner, normal);
      nearest.triangle = t;
      nearest.offset_m = 0;
      for (int k = 0; k < 3; ++k) {
        nearest.weight[k] = (float)weight[k];
        nearest.offset_m +=
            (float)(normal[k] * (x[k] - weight[0] * corner[0][k] - weight[1] * corner[1][k] -
                                 weight[2] * corner[2][k]));
      }
    }
    hook[v] = nearest;
  }
}

/* Where the vertices are while tools move the surface: moved_m [3 a vertex]. */
static inline void palpate_follow(const palpate_mesh* mesh, const float* displacement_m,
                                  const palpate_hook* hook, int32_t vertices, float* moved_m) {
  for (int32_t v = 0; v < vertices; ++v) {
    double corner[3][3], normal[3];
    for (int k = 0; k < 3; ++k)
      palpate_corner(mesh, displacement_m, hook[v].triangle, k, corner[k]);
    palpate_unit_normal(corner, normal);
    for (int i = 0; i < 3; ++i)
      moved_m[3 * v + i] =
          (float)(hook[v].weight[0] * corner[0][i] + hook[v].weight[1] * corner[1][i] +
                  hook[v].weight[2] * corner[2][i] + hook[v].offset_m * normal[i]);
  }
}

#endif
