/* An asset played in a plain C loop: loop ASSET.palp. Presses the ball of its curves 3 mm into the
 * middle of what was measured, drags it aside, lifts. */
#include <stdio.h>
#include <stdlib.h>

#include "palpate.h"

/* The asset's bytes. A file map does as well. */
static void* read_file(const char* path, size_t* size) {
  FILE* file = fopen(path, "rb");
  void* bytes = NULL;
  long length;
  if (file == NULL) return NULL;
  if (fseek(file, 0, SEEK_END) == 0 && (length = ftell(file)) > 0 &&
      fseek(file, 0, SEEK_SET) == 0) {
    *size = (size_t)length;
    bytes = malloc(*size);
    if (bytes != NULL && fread(bytes, 1, *size, file) != *size) {
      free(bytes);
      bytes = NULL;
    }
  }
  fclose(file);
  return bytes;
}

/* The measured vertex that is nearest to the middle of all of them. */
static int32_t middle_vertex(const palpate_mesh* mesh) {
  double middle_m[3] = {0, 0, 0}, least = 1e30;
  int32_t v, k, measured = 0, best = 0;
  for (v = 0; v < mesh->vertices; ++v) {
    if (mesh->covered[v] != 1) continue;
    ++measured;
    for (k = 0; k < 3; ++k) middle_m[k] += mesh->vertex_m[3 * v + k];
  }
  for (v = 0; v < mesh->vertices; ++v) {
    double squared = 0;
    if (mesh->covered[v] != 1) continue;
    for (k = 0; k < 3; ++k) {
      const double off_m = mesh->vertex_m[3 * v + k] - middle_m[k] / measured;
      squared += off_m * off_m;
    }
    if (squared < least) least = squared, best = v;
  }
  return best;
}

int main(int argc, char** argv) {
  static const char* const kState[] = {"air", "stick", "slip"};
  palpate_asset asset;
  palpate_contact contact;
  palpate_info info;
  palpate_mesh mesh;
  palpate_output out;
  palpate_status status;
  palpate_tool ball;
  size_t size = 0;
  double touched_m = 1, aside[3] = {0, 0, 0};
  int32_t v;
  int tick, k;
  /* 1. The asset's bytes, at a multiple of 8. They outlive the asset, which reads them in place. */
  void* bytes = argc == 2 ? read_file(argv[1], &size) : NULL;
  if (bytes == NULL) return fprintf(stderr, "usage: loop ASSET.palp\n"), 2;
  /* 2. Open it once. All bytes are checked here; every later call is safe on them. */
  status = palpate_open(&asset, bytes, size);
  if (status != PALPATE_OK) return fprintf(stderr, "%s\n", palpate_sentence(status)), 1;
  /* 3. Where to press, a direction along the surface there, and the ball of the curves. */
  palpate_describe(&asset, &info);
  palpate_read_mesh(&asset, &mesh);
  v = middle_vertex(&mesh);
  const float* inward = mesh.inward_normal + 3 * v;
  const int axis = inward[0] * inward[0] < 0.5 ? 0 : 1;
  for (k = 0; k < 3; ++k) aside[k] = (k == axis) - inward[axis] * inward[k];
  ball = palpate_ball(info.probe_radius_m); /* another radius wants palpate_indenter_open() */
  /* 4. One contact per tool: it remembers where the tool sticks. */
  palpate_start(&contact, &ball);
  /* 5. The force loop at 1 kHz: 40 mm/s down, then 10 mm/s aside, then up. */
  for (tick = 0; tick < 2000; ++tick) {
    const double down_m = tick < 400    ? 4e-5 * tick
                          : tick < 1400 ? 0.016
                                        : 0.016 - 4e-5 * (tick - 1400);
    const double along_m = tick < 400 ? 0 : tick < 1400 ? 1e-5 * (tick - 400) : 0.01;
    const double deepest_m = touched_m + 0.003;
    const double deep_m = (down_m < deepest_m ? down_m : deepest_m) - 0.006 - info.probe_radius_m;
    palpate_input in = palpate_input_at(0, 0, 0, 0.001);
    for (k = 0; k < 3; ++k)
      in.tool.position_m[k] =
          mesh.origin_m[k] + mesh.vertex_m[3 * v + k] + deep_m * inward[k] + along_m * aside[k];
    /* 6. Where the tool is, and how long since the last tick; its force comes back. */
    status = palpate_tick(&asset, &contact, 1, &in, &out);
    if (status != PALPATE_OK) return fprintf(stderr, "%s\n", palpate_sentence(status)), 1;
    if (touched_m == 1 && out.state != PALPATE_AIR) touched_m = down_m;
    if (tick % 100 == 0)
      printf("%4d ms  force on tool %7.4f %7.4f %7.4f N  depth %5.2f mm  %s\n", tick,
             out.force_on_tool_N[0], out.force_on_tool_N[1], out.force_on_tool_N[2],
             1e3 * out.normal_m, kState[out.state]);
  }
  /* 7. Energies: dry friction only dissipates, and nothing is stored once the tool is lifted. */
  printf("stored %.3g J, dissipated %.3g J\n", out.stored_J, out.dissipated_J);
  free(bytes);
  return 0;
}
