/* palpate.h is C: this file is compiled as C99, pedantically, and presses a plate by 3 mm. */
#include "palpate.h"

int palpate_c_walk(const void* bytes, uint64_t size, double* force_z_N);

int palpate_c_walk(const void* bytes, uint64_t size, double* force_z_N) {
  palpate_asset asset;
  palpate_contact contact;
  palpate_output out;
  const palpate_tool tool = palpate_ball(0.004);
  int i;
  palpate_status status = palpate_open(&asset, bytes, size);
  if (status != PALPATE_OK) return status;
  status = palpate_start(&contact, &tool);
  for (i = 0; i <= 40 && status == PALPATE_OK; ++i) {
    const palpate_input in = palpate_input_at(0.001, 0.0013, 0.005 - 1e-4 * i, 0.001);
    status = palpate_tick(&asset, &contact, 1, &in, &out);
  }
  *force_z_N = out.force_on_tool_N[2];
  return status;
}
