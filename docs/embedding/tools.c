/* Two fingers and a lying capsule: tools ASSET.palp, an asset whose contacts feel each other (its
 * scene has pairs or a [tool]). The fingers press side by side; then the capsule, one tool of four
 * balls, comes down flat, tips over and lifts. */
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

/* The thumb comes first, the finger 0.2 s later. */
static palpate_status press_fingers(const palpate_asset* asset, const double top_m[3],
                                    double radius_m) {
  palpate_contact finger[2];
  palpate_status status = PALPATE_OK;
  const palpate_tool ball = palpate_ball(radius_m);
  int tick, i;
  for (i = 0; i < 2; ++i) palpate_start(&finger[i], &ball);
  for (tick = 0; tick < 800 && status == PALPATE_OK; ++tick) {
    palpate_input in[2];
    palpate_output out[2];
    for (i = 0; i < 2; ++i) {
      const double down = 1e-5 * (tick - 200 * i);
      in[i] = palpate_input_at(top_m[0] + (i == 0 ? -1.5 : 1.5) * radius_m, top_m[1],
                               top_m[2] + 0.001 - fmin(fmax(down, 0), 0.004), 0.001);
    }
    status = palpate_tick(asset, finger, 2, in, out);
    if (tick % 100 == 99)
      printf("%3d ms  thumb %.4f N  finger %.4f N\n", tick + 1, out[0].force_on_tool_N[2],
             out[1].force_on_tool_N[2]);
  }
  return status;
}

/* Down by 2 mm, over by 0.2 rad about y, up. */
static palpate_status tip_capsule_over(const palpate_asset* asset, const double top_m[3],
                                       double radius_m) {
  palpate_tool capsule = palpate_ball(radius_m);
  palpate_contact contact;
  palpate_status status;
  int tick, i;
  capsule.balls = 4;
  for (i = 0; i < 4; ++i) {
    capsule.centre_m[i][0] = radius_m * (1.2 * i - 1.8);
    capsule.radius_m[i] = radius_m;
  }
  status = palpate_start(&contact, &capsule);
  for (tick = 0; tick < 1200 && status == PALPATE_OK; ++tick) {
    const double down = 1e-5 * (tick < 300 ? tick : tick < 900 ? 300 : 300 - 3 * (tick - 900));
    const double turn = tick < 300 ? 0 : 0.2 * fmin((tick - 300) / 500.0, 1);
    palpate_output out;
    palpate_input in = palpate_input_at(top_m[0], top_m[1], top_m[2] + 0.001 - down, 0.001);
    in.tool.orientation[0] = cos(turn / 2);
    in.tool.orientation[2] = sin(turn / 2);
    status = palpate_tick(asset, &contact, 1, &in, &out);
    if (tick % 100 == 99)
      printf("%4d ms  lift %.4f N  torque on the capsule %8.5f N m\n", tick + 1,
             out.force_on_tool_N[2], out.torque_on_tool_Nm[1]);
  }
  return status;
}

int main(int argc, char** argv) {
  palpate_asset asset;
  palpate_info info;
  palpate_status status;
  double top[3]; /* of a ball's centre as it touches */
  size_t size = 0;
  void* bytes = argc == 2 ? read_file(argv[1], &size) : NULL;
  if (bytes == NULL) return fprintf(stderr, "usage: tools ASSET.palp\n"), 2;
  status = palpate_open(&asset, bytes, size);
  if (status != PALPATE_OK) return complain(status);
  palpate_describe(&asset, &info);
  if (!info.couples) return fprintf(stderr, "contacts of this asset feel nothing of others\n"), 1;
  top[0] = 0.5 * (info.box_min_m[0] + info.box_max_m[0]);
  top[1] = 0.5 * (info.box_min_m[1] + info.box_max_m[1]);
  top[2] = info.box_max_m[2] + info.probe_radius_m;
  status = press_fingers(&asset, top, info.probe_radius_m);
  if (status == PALPATE_OK) status = tip_capsule_over(&asset, top, info.probe_radius_m);
  free(bytes);
  return status == PALPATE_OK ? 0 : complain(status);
}
