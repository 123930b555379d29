/* A mesh of your own, moved with the surface: visual ASSET.palp MESH.obj MOVED.obj, after
 * `palpate export asset.palp --visual MESH.obj -o ASSET.palp`. The ball of the curves presses 4 mm
 * deep where curves were measured. MOVED.obj has the `v` lines as the body then is, in metres,
 * and every other line, texture and all, as it was. With out/engine of a run, in C99:
 *
 *   g++ -std=c++17 -O2 -ffp-contract=off -c engine/palpate.cpp
 *   gcc -std=c99 -Iengine visual.c palpate.o -lm -o visual
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "palpate.h"

int main(int argc, char** argv) {
  if (argc != 4) return fprintf(stderr, "visual ASSET.palp MESH.obj MOVED.obj\n"), 2;
  const size_t room = (size_t)1 << 28;
  void* bytes = malloc(room);
  FILE *file = fopen(argv[1], "rb"), *mesh = fopen(argv[2], "r"), *moved = fopen(argv[3], "w");
  if (!bytes || !file || !mesh || !moved) return perror("visual"), 2;
  palpate_asset asset;
  const palpate_status status = palpate_open(&asset, bytes, fread(bytes, 1, room, file));
  if (status != PALPATE_OK) return fprintf(stderr, "%s\n", palpate_sentence(status)), 1;
  palpate_info info;
  palpate_describe(&asset, &info);
  if (!info.has_shape || info.visual_vertices == 0)
    return fprintf(stderr, "the asset moves no mesh of yours: palpate export --visual\n"), 1;

  palpate_mesh surface;
  palpate_read_mesh(&asset, &surface);
  int32_t place = 0;
  while (place + 1 < surface.vertices && surface.covered[place] != 1) ++place;
  const float* inward = surface.inward_normal + 3 * place;

  palpate_contact contact;
  palpate_tool ball = palpate_ball(info.probe_radius_m);
  palpate_start(&contact, &ball);
  double touched_m = 0;
  for (int tick = 0; tick < 4000; ++tick) {
    palpate_output out;
    const double down_m = 1e-5 * tick;
    palpate_input in = palpate_input_at(0, 0, 0, 0.001);
    for (int k = 0; k < 3; ++k)
      in.tool.position_m[k] = surface.origin_m[k] + surface.vertex_m[3 * place + k] +
                              (down_m - 0.006 - info.probe_radius_m) * inward[k];
    palpate_tick(&asset, &contact, 1, &in, &out);
    if (out.events & PALPATE_TOUCHED) touched_m = down_m;
    if (touched_m > 0 && down_m >= touched_m + 0.004) break;
  }

  /* At every frame, in the thread that draws: how the surface moves, then where your vertices are.
   */
  float* displacement_m = malloc(3 * sizeof(float) * (size_t)info.vertices);
  float* place_m = malloc(3 * sizeof(float) * (size_t)info.visual_vertices);
  palpate_deform(&asset, &contact, 1, 0, info.vertices, displacement_m);
  palpate_place_visual(&asset, displacement_m, 0, info.visual_vertices, place_m);

  char line[4096];
  int32_t v = 0;
  while (fgets(line, sizeof line, mesh))
    if (strncmp(line, "v ", 2) != 0)
      fputs(line, moved);
    else if (v < info.visual_vertices)
      fprintf(moved, "v %.9g %.9g %.9g\n", place_m[3 * v], place_m[3 * v + 1], place_m[3 * v + 2]),
          ++v;
  printf("%d vertices\n", (int)v);
  free(place_m), free(displacement_m), free(bytes);
  return fclose(file) | fclose(mesh) | fclose(moved) | (v != info.visual_vertices);
}
