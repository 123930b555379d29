/* A device driver's callback, void (*)(const double pos[3], const double vel[3], double force[3]):
   callback ASSET.palp. The driver here is a stand-in that calls it at 1 kHz along a path. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "palpate.h"

typedef void (*force_callback)(const double pos_m[3], const double vel_m_s[3], double force_N[3]);

/* What the callback needs. A driver that passes no user pointer leaves no choice but a static. */
static palpate_asset the_asset;
static palpate_contact the_contact;

static void palpate_force(const double pos_m[3], const double vel_m_s[3], double force_N[3]) {
  palpate_input in = palpate_input_at(pos_m[0], pos_m[1], pos_m[2], 0.001);
  palpate_output out;
  (void)vel_m_s; /* the damper differences positions: a driver's velocity is filtered, late */
  palpate_tick(&the_asset, &the_contact, 1, &in, &out);
  memcpy(force_N, out.force_on_tool_N, sizeof out.force_on_tool_N); /* zero unless all is well */
}

/* Stands for a device: a damped mass of 50 g that a spring pulls towards a point 4 mm deep. It ends
   where spring and tissue balance. Returns the last force upwards. */
static double run_driver(force_callback callback, const double surface_m[3]) {
  double pos[3], vel[3] = {0, 0, 0}, force[3] = {0, 0, 0};
  int tick, k;
  for (k = 0; k < 3; ++k) pos[k] = surface_m[k] + (k == 2 ? 0.004 : 0);
  for (tick = 0; tick < 4000; ++tick) {
    callback(pos, vel, force);
    for (k = 0; k < 3; ++k) {
      const double goal = surface_m[k] - (k == 2 ? 0.004 : 0);
      vel[k] += 1e-3 * (force[k] + 300 * (goal - pos[k]) - 3 * vel[k]) / 0.05;
      pos[k] += 1e-3 * vel[k];
    }
  }
  printf("at rest %.3f mm below the surface, %.4f N\n", 1e3 * (surface_m[2] - pos[2]), force[2]);
  return force[2];
}

int main(int argc, char** argv) {
  palpate_tool tip = palpate_tip();
  palpate_info info;
  double surface[3];
  long size;
  void* bytes;
  FILE* file = argc == 2 ? fopen(argv[1], "rb") : NULL;
  if (file == NULL) return fprintf(stderr, "usage: callback ASSET.palp\n"), 2;
  fseek(file, 0, SEEK_END);
  size = ftell(file);
  rewind(file);
  bytes = malloc((size_t)size);
  if (bytes == NULL || fread(bytes, 1, (size_t)size, file) != (size_t)size) return 1;
  fclose(file);
  if (palpate_open(&the_asset, bytes, (uint64_t)size) != PALPATE_OK) return 1;
  tip.damping_Ns_m = 2;
  tip.damper_depth_m = 0.001;
  palpate_start(&the_contact, &tip);
  palpate_describe(&the_asset, &info);
  surface[0] = 0.5 * (info.box_min_m[0] + info.box_max_m[0]) + 0.0005;
  surface[1] = 0.5 * (info.box_min_m[1] + info.box_max_m[1]) + 0.0003;
  surface[2] = info.box_max_m[2];
  return run_driver(palpate_force, surface) > 0.1 ? 0 : 1;
}
