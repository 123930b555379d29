/* Two fingers and a lying capsule: tools ASSET.palp, an asset whose contacts feel each other (its
 * scene has pairs or a [tool]). The fingers press side by side as a group; then the capsule, four
 * balls of the asset's radius, comes down flat, tips over and lifts. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "palpate.h"

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

static int complain(palpate_status status) {
  return fprintf(stderr, "%s\n", palpate_sentence(status)), 1;
}

int main(int argc, char** argv) {
  palpate_asset asset;
  palpate_info info;
  palpate_contact thumb, finger;
  palpate_contact* fingers[2] = {&thumb, &finger};
  palpate_group group;
  palpate_compound capsule;
  palpate_tool ball, balls[4];
  palpate_status status;
  double x, y, top, radius;
  size_t size = 0;
  int tick, i;
  void* bytes = argc == 2 ? read_file(argv[1], &size) : NULL;
  if (bytes == NULL) return fprintf(stderr, "usage: tools ASSET.palp\n"), 2;
  status = palpate_open(&asset, bytes, size);
  if (status != PALPATE_OK) return complain(status);
  palpate_describe(&asset, &info);
  if (!info.couples) return fprintf(stderr, "contacts of this asset feel nothing of others\n"), 1;
  radius = info.probe_radius_m;
  x = 0.5 * (info.box_min_m[0] + info.box_max_m[0]);
  y = 0.5 * (info.box_min_m[1] + info.box_max_m[1]);
  top = info.box_max_m[2] + radius;

  ball = palpate_ball(radius);
  palpate_start(&thumb, &ball);
  palpate_start(&finger, &ball);
  palpate_group_start(&group);
  for (tick = 0; tick < 800; ++tick) { /* the thumb comes first, the finger 0.2 s later */
    palpate_output out[2];
    palpate_input in[2];
    for (i = 0; i < 2; ++i) {
      const double down = 1e-5 * (tick - 200 * i);
      in[i] = palpate_input_at(x + (i == 0 ? -1.5 : 1.5) * radius, y,
                               top + 0.001 - fmin(fmax(down, 0), 0.004));
    }
    status = palpate_group_tick(&asset, &group, fingers, in, out, 2);
    if (status != PALPATE_OK) return complain(status);
    if (tick % 100 == 99)
      printf("%3d ms  thumb %.4f N  finger %.4f N\n", tick + 1, out[0].force_on_tool_N[2],
             out[1].force_on_tool_N[2]);
  }

  for (i = 0; i < 4; ++i) {
    balls[i] = palpate_ball(radius);
    balls[i].offset_m[0] = radius * (1.2 * i - 1.8);
  }
  status = palpate_compound_start(&capsule, balls, 4);
  if (status != PALPATE_OK) return complain(status);
  for (tick = 0; tick < 1200; ++tick) { /* down 2 mm, over by 0.2 rad about y, up */
    const double down = 1e-5 * (tick < 300 ? tick : tick < 900 ? 300 : 300 - 3 * (tick - 900));
    const double turn = tick < 300 ? 0 : 0.2 * fmin((tick - 300) / 500.0, 1);
    palpate_output out;
    palpate_input in = palpate_input_at(x, y, top + 0.001 - down);
    in.tool.orientation[0] = cos(turn / 2);
    in.tool.orientation[2] = sin(turn / 2);
    status = palpate_compound_tick(&asset, &capsule, &in, &out);
    if (status != PALPATE_OK) return complain(status);
    if (tick % 100 == 99)
      printf("%4d ms  lift %.4f N  torque on the capsule %8.5f N m\n", tick + 1,
             out.force_on_tool_N[2], out.torque_on_tool_Nm[1]);
  }
  free(bytes);
  return 0;
}
