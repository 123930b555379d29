/* A finer mesh of the asset's own surface, a millimetre outside it, hangs where it lies at rest and
   follows the dent: embedding_visual ASSET.palp. */
#include "docs/embedding/visual.h"

#include <stdio.h>
#include <stdlib.h>

int main(int argc, char** argv) {
  FILE* file = argc == 2 ? fopen(argv[1], "rb") : NULL;
  const size_t room = 1 << 24;
  void* bytes = malloc(room);
  const size_t size = file ? fread(bytes, 1, room, file) : 0;
  palpate_asset asset;
  palpate_info info;
  palpate_mesh mesh;
  if (palpate_open(&asset, bytes, size) != PALPATE_OK) return puts("the asset does not open"), 2;
  palpate_describe(&asset, &info);
  palpate_read_mesh(&asset, &mesh);

  /* The middle of every triangle, 1 mm along its normal. */
  const int32_t count = mesh.triangles;
  float* place_m = malloc(3 * (size_t)count * sizeof(float));
  float* moved_m = malloc(3 * (size_t)count * sizeof(float));
  float* displacement_m = calloc(3 * (size_t)mesh.vertices, sizeof(float));
  palpate_hook* hook = calloc((size_t)count, sizeof *hook);
  for (int32_t t = 0; t < count; ++t) {
    double corner[3][3], normal[3];
    for (int k = 0; k < 3; ++k) palpate_corner(&mesh, NULL, t, k, corner[k]);
    palpate_unit_normal(corner, normal);
    for (int i = 0; i < 3; ++i)
      place_m[3 * t + i] =
          (float)((corner[0][i] + corner[1][i] + corner[2][i]) / 3 + 0.001 * normal[i]);
  }
  palpate_hang(&mesh, place_m, count, hook);
  palpate_follow(&mesh, displacement_m, hook, count, moved_m);
  double off_m = 0;
  for (int32_t i = 0; i < 3 * count; ++i)
    if (fabs((double)moved_m[i] - (double)place_m[i]) > off_m)
      off_m = fabs((double)moved_m[i] - (double)place_m[i]);

  palpate_contact contact;
  palpate_tool ball = palpate_ball(info.probe_radius_m);
  palpate_output out;
  palpate_start(&contact, &ball);
  for (int tick = 0; tick < 400; ++tick) {
    palpate_input in =
        palpate_input_at(0.5 * (info.box_min_m[0] + info.box_max_m[0]),
                         0.5 * (info.box_min_m[1] + info.box_max_m[1]),
                         info.box_max_m[2] + info.probe_radius_m + 0.001 - 1e-5 * tick, 0.001);
    palpate_tick(&asset, &contact, 1, &in, &out);
  }
  if (palpate_deform(&asset, &contact, 1, 0, mesh.vertices, displacement_m) != PALPATE_OK)
    return puts("the asset shows no dent"), 2;
  palpate_follow(&mesh, displacement_m, hook, count, moved_m);
  double most_m = 0, own_m = 0; /* the largest motion of these places, of the asset's vertices */
  for (int32_t i = 0; i < 3 * count; ++i)
    if (fabs((double)moved_m[i] - (double)place_m[i]) > most_m)
      most_m = fabs((double)moved_m[i] - (double)place_m[i]);
  for (int32_t i = 0; i < 3 * mesh.vertices; ++i)
    if (fabs((double)displacement_m[i]) > own_m) own_m = fabs((double)displacement_m[i]);
  printf("%d vertices: %.1e mm off at rest, moved by up to %.2f mm (the surface by %.2f)\n",
         (int)count, 1e3 * off_m, 1e3 * most_m, 1e3 * own_m);
  free(hook), free(displacement_m), free(moved_m), free(place_m), free(bytes);
  return off_m < 1e-6 && most_m > 0.2 * own_m && most_m < 2 * own_m && own_m > 1e-4 ? 0 : 1;
}
