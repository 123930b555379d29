/* A random walk of a tip over an asset, for bindings of other languages to repeat: walk_bits ASSET
 * TICKS. Prints a line a tick: x, y, z and the FNV-1a hash of palpate_output, 16 hex digits each.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "palpate.h"

static double random_unit(void) { /* a congruential generator is random enough here */
  static uint64_t state = 7;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) / 9007199254740992.0;
}

int main(int argc, char** argv) {
  static unsigned char content[1 << 24], room[1 << 24];
  palpate_asset asset;
  palpate_contact contact;
  palpate_info info;
  palpate_output out;
  const palpate_tool tip = palpate_tip();
  double at[3] = {0, 0, 0}, to[3] = {0, 0, 0};
  int ticks, tick, i, left = 0;
  FILE* file = argc == 3 ? fopen(argv[1], "rb") : NULL;
  const size_t size = file != NULL ? fread(content, 1, sizeof content, file) : 0;
  if (palpate_open(&asset, palpate_copy_aligned(room, sizeof room, content, size), size) !=
      PALPATE_OK)
    return 2;
  fclose(file);
  palpate_describe(&asset, &info);
  palpate_start(&contact, &tip);
  ticks = atoi(argv[2]);
  for (tick = 0; tick < ticks; ++tick) {
    palpate_input in;
    const unsigned char* byte = (const unsigned char*)&out;
    uint64_t bits[3], hash = 14695981039346656037u;
    size_t b;
    if (left-- == 0) { /* the next stroke, to anywhere in the box or 3 mm about it */
      left = 300;
      for (i = 0; i < 3; ++i)
        to[i] = info.box_min_m[i] - 0.003 +
                (info.box_max_m[i] - info.box_min_m[i] + 0.006) * random_unit();
    }
    for (i = 0; i < 3; ++i) at[i] += (to[i] - at[i]) * 0.01;
    in = palpate_input_at(at[0], at[1], at[2]);
    palpate_tick(&asset, &contact, &in, &out);
    for (b = 0; b < sizeof out; ++b) hash = (hash ^ byte[b]) * 1099511628211u;
    memcpy(bits, at, sizeof bits);
    printf("%016" PRIx64 " %016" PRIx64 " %016" PRIx64 " %016" PRIx64 "\n", bits[0], bits[1],
           bits[2], hash);
  }
  return 0;
}
