/* An asset played in a plain C loop: loop ASSET.palp. Presses the ball of its curves 3 mm into the
 * body from above, drags it 10 mm, lifts. */
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

int main(int argc, char** argv) {
  static const char* const kState[] = {"air", "stick", "slip"};
  palpate_asset asset;
  palpate_contact contact;
  palpate_info info;
  palpate_output out;
  palpate_status status;
  palpate_tool ball;
  size_t size = 0;
  double touch_z = 0;
  int tick;
  /* 1. The asset's bytes, at a multiple of 8. They outlive the asset, which reads them in place. */
  void* bytes = argc == 2 ? read_file(argv[1], &size) : NULL;
  if (bytes == NULL) return fprintf(stderr, "usage: loop ASSET.palp\n"), 2;
  /* 2. Open it once. All bytes are checked here; every later call is safe on them. */
  status = palpate_open(&asset, bytes, size);
  if (status != PALPATE_OK) return fprintf(stderr, "%s\n", palpate_sentence(status)), 1;
  /* 3. Where the body is, and the ball that its curves were measured with. */
  palpate_describe(&asset, &info);
  ball = palpate_ball(info.probe_radius_m); /* another radius wants palpate_indenter_open() */
  /* 4. One contact per tool: it remembers where the tool sticks. */
  palpate_start(&contact, &ball);
  /* 5. The force loop at 1 kHz: 40 mm/s down, then 10 mm/s aside, then up. */
  for (tick = 0; tick < 2000; ++tick) {
    const double above = info.box_max_m[2] + 0.006;
    const double x = 0.5 * (info.box_min_m[0] + info.box_max_m[0]) + 0.0013;
    const double y = 0.5 * (info.box_min_m[1] + info.box_max_m[1]) + 0.0007;
    const double down = tick < 400    ? 4e-5 * tick
                        : tick < 1400 ? 0.016
                                      : 0.016 - 4e-5 * (tick - 1400);
    const double aside = tick < 400 ? 0 : tick < 1400 ? 1e-5 * (tick - 400) : 0.01;
    palpate_input in = palpate_input_at(x + aside, y, above - down, 0.001);
    if (touch_z != 0 && in.tool.position_m[2] < touch_z - 0.003)
      in.tool.position_m[2] = touch_z - 0.003;
    /* 6. Where the tool is, and how long since the last tick; its force comes back. */
    status = palpate_tick(&asset, &contact, 1, &in, &out);
    if (status != PALPATE_OK) return fprintf(stderr, "%s\n", palpate_sentence(status)), 1;
    if (touch_z == 0 && out.state != PALPATE_AIR) touch_z = in.tool.position_m[2];
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
