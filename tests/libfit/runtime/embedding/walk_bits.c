/* Walks over an asset, for bindings of other languages to repeat.
 * walk_bits ASSET TICKS: a tip's random walk. Prints a line a tick: x, y, z and the FNV-1a hash of
 * palpate_output, 16 hex digits each.
 * walk_bits ASSET TICKS two: a ball, and a capsule of three balls that turns, ticked together.
 * Prints a path as `palpate replay` takes it, with what each tool felt, in digits that read back as
 * the same double. The ball and the balls of the capsule have the radius of the asset's probe; they
 * stand at z = radius and at x = -1, 0 and 1 radius in the tools' axes. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "palpate.h"

static double random_unit(void) { /* a congruential generator is random enough here */
  static uint64_t state = 7;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) / 9007199254740992.0;
}

/* A random walk in the box or 3 mm about it, a step a call. */
typedef struct stroke {
  double at[3], to[3];
  int left;
} stroke;
static void step(stroke* s, const palpate_info* info) {
  int i;
  if (s->left-- == 0) {
    s->left = 300;
    for (i = 0; i < 3; ++i)
      s->to[i] = info->box_min_m[i] - 0.003 +
                 (info->box_max_m[i] - info->box_min_m[i] + 0.006) * random_unit();
  }
  for (i = 0; i < 3; ++i) s->at[i] += (s->to[i] - s->at[i]) * 0.01;
}

static void walk_tip(const palpate_asset* asset, const palpate_info* info, int ticks) {
  const palpate_tool tip = palpate_tip();
  palpate_contact contact;
  stroke s = {{0, 0, 0}, {0, 0, 0}, 0};
  palpate_start(&contact, &tip);
  while (ticks-- > 0) {
    palpate_input in;
    palpate_output out;
    const unsigned char* byte = (const unsigned char*)&out;
    uint64_t bits[3], hash = 14695981039346656037u;
    size_t b;
    step(&s, info);
    in = palpate_input_at(s.at[0], s.at[1], s.at[2], 0.001);
    palpate_tick(asset, &contact, 1, &in, &out);
    for (b = 0; b < sizeof out; ++b) hash = (hash ^ byte[b]) * 1099511628211u;
    memcpy(bits, s.at, sizeof bits);
    printf("%016" PRIx64 " %016" PRIx64 " %016" PRIx64 " %016" PRIx64 "\n", bits[0], bits[1],
           bits[2], hash);
  }
}

/* Side by side over the middle of the top: down by 3 radii of way, along and about, up again. */
static palpate_input two_at(const palpate_info* info, int tool, int tick) {
  const double t = 1e-3 * tick, radius = info->probe_radius_m;
  const double down = radius * (0.25 + 0.75 * cos(2.1 * t + tool));
  const double aside = radius * ((tool == 0 ? -2.2 : 2.2) + 1.5 * sin(3.3 * t));
  palpate_input in = palpate_input_at(
      0.5 * (info->box_min_m[0] + info->box_max_m[0]) + aside,
      0.5 * (info->box_min_m[1] + info->box_max_m[1]) + radius * sin(1.7 * t + tool),
      info->box_max_m[2] + down + (tool == 0 ? 0 : radius), 0.001);
  const double turn = tool == 0 ? 0 : 0.35 * sin(2.9 * t),
               lean = tool == 0 ? 0 : 0.2 * sin(1.3 * t);
  in.tool.orientation[0] = cos(turn) * cos(lean);
  in.tool.orientation[1] = -sin(turn) * sin(lean);
  in.tool.orientation[2] = cos(turn) * sin(lean);
  in.tool.orientation[3] = sin(turn) * cos(lean);
  return in;
}

static void walk_two(const palpate_asset* asset, const palpate_info* info, int ticks) {
  palpate_tool tool[2];
  palpate_contact contact[2];
  int tick, i, k;
  tool[0] = tool[1] = palpate_ball(info->probe_radius_m);
  tool[0].centre_m[0][2] = info->probe_radius_m;
  tool[1].balls = 3;
  for (i = 0; i < 3; ++i) {
    tool[1].centre_m[i][0] = info->probe_radius_m * (i - 1);
    tool[1].radius_m[i] = info->probe_radius_m;
  }
  for (k = 0; k < 2; ++k) palpate_start(&contact[k], &tool[k]);
  printf("t_s,x_m,y_m,z_m,qx,qy,qz,qw,tool,fx_N,fy_N,fz_N,tx_Nm,ty_Nm,tz_Nm\n");
  for (tick = 0; tick < ticks; ++tick) {
    palpate_input in[2];
    palpate_output out[2];
    for (k = 0; k < 2; ++k) in[k] = two_at(info, k, tick);
    palpate_tick(asset, contact, 2, in, out);
    for (k = 0; k < 2; ++k) {
      const double* q = in[k].tool.orientation;
      printf("%.17g", 1e-3 * tick);
      for (i = 0; i < 3; ++i) printf(",%.17g", in[k].tool.position_m[i]);
      printf(",%.17g,%.17g,%.17g,%.17g,%d", q[1], q[2], q[3], q[0], k);
      for (i = 0; i < 3; ++i) printf(",%.17g", out[k].force_on_tool_N[i]);
      for (i = 0; i < 3; ++i) printf(",%.17g", out[k].torque_on_tool_Nm[i]);
      printf("\n");
    }
  }
}

int main(int argc, char** argv) {
  static unsigned char content[1 << 24], room[1 << 24];
  palpate_asset asset;
  palpate_info info;
  FILE* file = argc == 3 || argc == 4 ? fopen(argv[1], "rb") : NULL;
  const size_t size = file != NULL ? fread(content, 1, sizeof content, file) : 0;
  if (palpate_open(&asset, palpate_copy_aligned(room, sizeof room, content, size), size) !=
      PALPATE_OK)
    return 2;
  fclose(file);
  palpate_describe(&asset, &info);
  if (argc == 3)
    walk_tip(&asset, &info, atoi(argv[2]));
  else
    walk_two(&asset, &info, atoi(argv[2]));
  return 0;
}
